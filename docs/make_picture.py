"""Make the animation at the top of the README: the six emotions side by side, in real time.

Usage: python docs/make_picture.py FILE.webp
"""

import sys

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from emovid import load_scene, simulate
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting
from emovid.scene.video import Colours
from emovid.video.render import frames

SECONDS, FPS = 10, 8
WIDTH, HEIGHT = 288, 192  # pixels of a panel; the stage is 3:2
CAPTION = 22  # pixels above each
KEYS = {"duration": SECONDS, "video.size": f"{2 * WIDTH}x{2 * HEIGHT}", "video.fps": FPS, "video.trails.width": 0.006}


def main(target: str) -> None:
    """Write the picture to `target`."""
    settings = [Setting(key, value, f"{__file__} {key}") for key, value in KEYS.items()]
    films = [frames(simulate(load_scene(name, settings))) for name in EMOTIONS]
    captions = caption(Colours().surround)
    pictures = []
    for panels in zip(*films, strict=True):
        page = captions.copy()
        for i, panel in enumerate(panels):
            page.paste(small(np.asarray(panel)), (i % 3 * WIDTH, i // 3 * (HEIGHT + CAPTION) + CAPTION))
        pictures.append(page)
    pictures[0].save(
        target, save_all=True, append_images=pictures[1:], duration=1000 // FPS, loop=0, quality=70, method=4
    )


def small(frame: "np.ndarray[tuple[int, int, int], np.dtype[np.uint8]]") -> Image.Image:
    """Return a frame, drawn at twice the size, as a panel of the animation."""
    return Image.fromarray(np.ascontiguousarray(frame[..., :3])).resize((WIDTH, HEIGHT), Image.Resampling.BOX)


def caption(surround: str) -> Image.Image:
    """Return the background with the titles of the panels, in the color around the stages."""
    width, height = 3 * WIDTH, 2 * (HEIGHT + CAPTION)
    figure = Figure(figsize=(width / 100, height / 100), dpi=100, facecolor=surround)
    canvas = FigureCanvasAgg(figure)
    for i, (name, emotion) in enumerate(EMOTIONS.items()):
        x, y = (i % 3 + 0.5) / 3, 1 - (i // 3 * (HEIGHT + CAPTION) + CAPTION / 2) / height
        figure.text(x, y, f"{name}: {emotion.behaviour}", ha="center", va="center", fontsize=8)
    canvas.draw()
    return Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())


if __name__ == "__main__":
    main(sys.argv[1])
