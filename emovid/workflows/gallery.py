"""The gallery: every figure, and each shipped scene as a small video with its YAML, on one page."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from emovid.figures.catalogue import Entry
from emovid.figures.gallery import Picture, SceneVideo, gallery_page
from emovid.figures.paper_tables import table_html
from emovid.figures.run_cache import Material
from emovid.figures.style import encoded
from emovid.scene.emotions import EMOTIONS
from emovid.version import __version__
from emovid.video.painter import Painter
from emovid.video.render import render_video

GALLERY = "gallery"
_SIZE = (600, 400)  # of the videos [pixels]
_CRF = 28  # coarser than the study's videos: a third of their bytes


def steps(entries: Sequence[Entry]) -> int:
    """Return how many times `gallery` calls `done`."""
    return len(EMOTIONS) + len(entries)


def gallery(material: Material, entries: Sequence[Entry], done: Callable[[str], None]) -> bytes:
    """Return the HTML page with all shipped scenes and some figures.

    Args:
        material: inputs of the figures.
        entries: the figures, of the catalog.
        done: called with the name of each finished video and figure.
    """
    videos, pictures = [], []
    for emotion in EMOTIONS:
        videos.append(_scene_video(material, emotion))
        done(f"video of {emotion}")
    for entry in entries:
        pictures.append(_picture(material, entry))
        done(entry.name)
    return gallery_page(videos, pictures, __version__).encode()


def _scene_video(material: Material, emotion: str) -> SceneVideo:
    run = material.run(emotion)
    video = run.scene.video.model_copy(update={"size": "{}x{}".format(*_SIZE), "format": "mp4"})
    run = replace(run, scene=run.scene.model_copy(update={"video": video}))
    with TemporaryDirectory() as folder:
        target = Path(folder) / "video.mp4"
        render_video(run, target, crf=_CRF)
        data = target.read_bytes()
    known, poster = EMOTIONS[emotion], BytesIO()
    frame = Painter(run).frame(min(known.snapshot_times[-1], float(run.t[-1])))
    Image.fromarray(frame[..., :3].copy()).save(poster, "png", optimize=True)
    caption = f"{known.behaviour.capitalize()}; {known.control}."
    return SceneVideo(emotion, caption, known.video, material.text(emotion), data, poster.getvalue(), _SIZE)


def _picture(material: Material, entry: Entry) -> Picture:
    """Return a figure as SVG or PNG, whichever is smaller, and a table as HTML."""
    if entry.data:
        html = table_html(entry.data).encode()
        return Picture(entry.name, entry.paper, entry.caption, "html", html, (entry.width, 0))
    figure = entry.figure(material)
    svg, png = encoded(figure, "svg"), encoded(figure, "png")
    kind, data = ("svg+xml", svg) if len(svg) < len(png) else ("png", png)
    width, height = figure.get_size_inches().tolist()
    return Picture(entry.name, entry.paper, entry.caption, kind, data, (width, height))
