"""Compare emovid with other tools on the same kind of video: whole processes, alternating in one run.

1. matplotlib's `FuncAnimation.save`: the same scene, simulated by us, drawn by artists that are set anew for each
   frame, with the same encoder settings; and with frames that are thrown away. Processor time.
2. ir-sim (PyPI), in an environment of its own that is made here and removed: 15 robots for 12 s at 30 frames a second,
   with the trajectories of five. Wall time. Without a network it is not measured.

Usage: python benchmarks/peers.py [ROUNDS]
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from typing import Literal

import numpy as np
from processes import cost

from emovid.scene.load import load_scene
from emovid.swarm.simulate import simulate
from emovid.video import ffmpeg
from emovid.video.canvas import Change
from emovid.video.encoder import video_arguments
from emovid.video.pixel_formats import Yuv420
from emovid.video.render import frames

CPU_LIMIT, WALL_LIMIT = 8.0, 12.0

ANIMATION = """
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
matplotlib.rcParams["animation.ffmpeg_path"] = sys.argv[2]
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, FuncAnimation
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.transforms import Affine2D

from emovid import load_scene, simulate
from emovid.video.robots import robot_parts, robot_rim
from emovid.video.trails import trailed_robots

scene = load_scene("anger")
run, colours, video = simulate(scene), scene.video.palette, scene.video
poses = run.at(np.arange(scene.frames) / video.fps)
figure = Figure(figsize=(12.8, 7.2), dpi=100, facecolor=colours.surround)
axes = figure.add_axes((0, 0, 1, 1), xlim=(-0.765, 0.765), ylim=(-0.43, 0.43))
axes.set_axis_off()
axes.add_patch(Rectangle((-0.6, -0.4), 1.2, 0.8, facecolor=colours.stage, edgecolor=colours.boundary, lw=2))
trailed = trailed_robots(run.poses[0], video.trails.robots).tolist()
lines = [axes.plot([], [], color=colour, lw=2.4)[0] for colour in colours.trails]
parts = {"rim": robot_rim(scene.robot.body, 0.0012), **robot_parts(scene.robot.body)}
robots = []
for robot in range(scene.robots):
    body = colours.trails[trailed.index(robot)] if robot in trailed else colours.body
    faces = {"rim": colours.stage, "wheels": colours.wheels, "body": body, "front": colours.front}
    robots.append([axes.add_patch(PathPatch(path, facecolor=faces[name], lw=0)) for name, path in parts.items()])


def draw(k):
    for robot, patches in enumerate(robots):
        x, y, heading = poses[k, robot]
        for patch in patches:
            patch.set_transform(Affine2D().rotate(heading).translate(x, y) + axes.transData)
    for robot, line in zip(trailed, lines, strict=True):
        line.set_data(*poses[: k + 1, robot, :2].T)


class Nothing(AbstractMovieWriter):
    def setup(self, *settings, **keys):
        super().setup(*settings, **keys)

    def grab_frame(self, **keys):
        self.fig.savefig(open("/dev/null", "wb"), format="rgba", dpi=self.dpi)

    def finish(self):
        pass


settings = "-preset veryfast -crf 16 -profile:v high -g 30 -keyint_min 30 -sc_threshold 0 -bf 0 -threads 1".split()
writer = Nothing(video.fps)
if sys.argv[2] != "none":
    writer = FFMpegWriter(fps=video.fps, codec="libx264", extra_args=[*settings, "-pix_fmt", "yuv420p"])
FuncAnimation(figure, draw, frames=scene.frames).save(sys.argv[1], writer=writer, dpi=100)
"""

DRAWING = """
from emovid import load_scene, simulate
from emovid.video.render import frames

for _ in frames(simulate(load_scene("anger"))):
    pass
"""

WORLD = """
world: {height: 0.8, width: 1.2, step_time: 0.0333333333, sample_time: 0.0333333333, collision_mode: unobstructed}
robot:
""" + "".join(
    f"""  - kinematics: {{name: diff}}
    shape: {{name: circle, radius: 0.0175}}
    state: [{0.2 + 0.2 * (i % 5)}, {0.2 + 0.2 * (i // 5)}, 0]
    goal: [{1.0 - 0.2 * (i % 5)}, {0.6 - 0.2 * (i // 5)}, 0]
    behavior: {{name: dash}}
    vel_max: [0.05, 3]
    plot: {{show_trajectory: {i % 3 == 0}, show_goal: False, show_arrow: False}}
"""
    for i in range(15)
)

IR_SIM = """
import irsim

env = irsim.make("world.yaml", display=False, save_ani=True, log_level="ERROR")
for _ in range(360):
    env.step()
    env.render(0)
env.end(0, suffix=".mp4", fps=30)
"""


def render(*arguments: str) -> list[str]:
    """Return the command that renders anger."""
    return [sys.executable, "-m", "emovid", "render", "--emotion", "anger", "--force", "--quiet", *arguments]


def compare(
    what: str, ours: list[str], theirs: list[str], used: Literal["cpu", "wall"], limit: float, rounds: int, folder: Path
) -> tuple[str, float]:
    """Return a row of the table and the median of the other tool [s]; the two alternate in who starts first."""
    pairs = []
    for k in range(rounds):
        first, second = (theirs, ours) if k % 2 else (ours, theirs)
        times = [getattr(cost(command, folder), used) for command in (first, second)]
        pairs.append(times[::-1] if k % 2 else times)
    mine, other = (median(times) for times in zip(*pairs, strict=True))
    ratio = median(b / a for a, b in pairs)
    return f"{what:<38}{mine:>8.2f} s{other:>10.2f} s{ratio:>8.1f}   at least {limit:g}", other


def encoding_alone(rounds: int, folder: Path) -> float:
    """Return the median processor time of ffmpeg alone, fed with the converted frames of anger [s].

    What a program that draws and converts for nothing would still take.
    """
    run = simulate(load_scene("anger"))
    video = run.scene.video
    everywhere = np.arange(video.width * video.height)
    command = [ffmpeg.executable(), *video_arguments(video), "alone.mp4"]
    times = []
    for _ in range(rounds):
        convert = Yuv420(video.width, video.height).convert
        changes = ((frame, Change(everywhere, frame.reshape(-1).view(np.uint32))) for frame in frames(run))
        times.append(cost(command, folder, (convert(*change).data for change in changes)).cpu)
    return median(times)


def ir_sim(folder: Path) -> list[str] | None:
    """Return the command that renders with ir-sim in its own environment; None if that cannot be installed."""
    python = folder / "environment" / "bin" / "python"
    (folder / "world.yaml").write_text(WORLD)
    try:
        subprocess.run([sys.executable, "-m", "venv", str(python.parents[1])], check=True, capture_output=True)
        install = [str(python), "-m", "pip", "install", "--quiet", "ir-sim", "imageio-ffmpeg"]
        subprocess.run(install, check=True, capture_output=True, timeout=600)
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
        return None
    return [str(python), "-c", IR_SIM]


def main() -> None:
    """Print the table with the limits."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    print(f"{'':<38}{'emovid':>10}{'theirs':>12}{'ratio':>8}   limit")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        animation = [sys.executable, "-c", ANIMATION, "theirs.mp4"]
        ours = render("-o", "ours.mp4")
        row, whole = compare(
            "FuncAnimation.save", ours, [*animation, ffmpeg.executable()], "cpu", CPU_LIMIT, rounds, folder
        )
        print(row, flush=True)
        ours = [sys.executable, "-c", DRAWING]
        row, _ = compare("the same, not encoded", ours, [*animation, "none"], "cpu", CPU_LIMIT, rounds, folder)
        print(row, flush=True)
        encoder = encoding_alone(rounds, folder)
        most = f"no program with it can take more than {whole / encoder:.1f} times less than FuncAnimation.save"
        print(f"the encoder alone takes {encoder:.2f} s: {most}", flush=True)
        if command := ir_sim(folder):
            clip = render("-o", "ours.mp4", "--set", "duration=12")
            what = "ir-sim, 12 s of 15 robots, wall time"
            print(compare(what, clip, command, "wall", WALL_LIMIT, rounds, folder)[0])
        else:
            print("ir-sim: not measured, because it could not be installed")


if __name__ == "__main__":
    main()
