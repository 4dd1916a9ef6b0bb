"""Convert a trajectory to a pandas table: distance and maximum speed of each robot."""

import numpy as np

from emovid import load_scene, simulate, to_dataframe

motion = to_dataframe(simulate(load_scene("fear")))
steps = motion.groupby("robot")[["x", "y"]].diff()
motion["path"] = np.hypot(steps["x"], steps["y"])
robots = motion.groupby("robot").agg(path=("path", "sum"), v_max=("v", "max"))
print(robots.round(3).to_string())
