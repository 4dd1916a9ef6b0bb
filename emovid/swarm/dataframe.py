"""A trajectory as a tidy table, for notebooks."""

import numpy as np
import pandas as pd

from emovid.swarm.trajectory import Trajectory


def to_dataframe(trajectory: Trajectory) -> pd.DataFrame:
    """Return one row for each sample and robot, in this order: T N rows.

    The columns are time [s], robot (from 1), x [m], y [m], heading [rad], and the command v [m/s], omega [rad/s] that
    is held from this sample to the next; after the last sample it is missing.
    """
    samples, robots = trajectory.poses.shape[:2]
    commands = np.full((samples, robots, 2), np.nan)
    commands[:-1] = trajectory.commands
    columns = {"time": np.repeat(trajectory.t, robots), "robot": np.tile(np.arange(1, robots + 1), samples)}
    columns |= dict(zip(("x", "y", "heading"), trajectory.poses.reshape(-1, 3).T, strict=True))
    columns |= dict(zip(("v", "omega"), commands.reshape(-1, 2).T, strict=True))
    return pd.DataFrame(columns)
