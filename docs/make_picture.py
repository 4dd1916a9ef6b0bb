"""Draw the picture at the top of the README: each emotion at the last of the paper's snapshot times.

Usage: python docs/make_picture.py FILE.png
"""

import sys

import numpy as np
from matplotlib.figure import Figure

from emovid import load_scene, simulate
from emovid.scene.emotions import EMOTIONS
from emovid.video.draw import Painter


def main(target: str) -> None:
    """Write the picture to `target`."""
    figure = Figure(figsize=(12, 5.7), dpi=100, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.02, h_pad=0.02, wspace=0.01, hspace=0.01)
    for axes, (name, emotion) in zip(figure.subplots(2, 3).flat, EMOTIONS.items(), strict=True):
        painter = Painter(simulate(load_scene(name)))
        frame = painter.frame(emotion.snapshot_times[-1])
        left = round((painter.camera.width - 1.5 * painter.camera.height) / 2)
        axes.imshow(np.array(frame[:, left:-left]), interpolation="antialiased")
        axes.set_title(f"{name}: {emotion.behaviour}, {emotion.control}", fontsize=11)
        axes.set_axis_off()
    figure.savefig(target, metadata={"Software": None})


if __name__ == "__main__":
    main(sys.argv[1])
