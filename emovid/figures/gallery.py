"""`gallery.html`: all figures, videos and scenes on one page that needs no other file."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import NamedTuple

from emovid.figures.style import heading

_PAGE = Path(__file__).with_name("gallery.html")
_ZOOM = 1.58  # size of figures on a wide screen, over their size in print: two columns fill the page
_DOTS = 96  # CSS pixels per inch
_WIDE = 5.0  # wider figures [in] scroll sideways on a phone, where their text would be too small


class SceneVideo(NamedTuple):
    """A scene on the page.

    Attributes:
        name: of the scene, an emotion.
        description: in one line.
        authors: address of the video by the paper's authors.
        text: the scene as YAML.
        video: as MP4.
        poster: picture before it plays, as PNG.
        size: of the video (width, height) [pixels].
    """

    name: str
    description: str
    authors: str
    text: str
    video: bytes
    poster: bytes
    size: tuple[int, int]


class Picture(NamedTuple):
    """A figure or table on the page.

    Attributes:
        name: of the figure.
        paper: its number in the paper, or empty.
        caption: in one line.
        kind: "png", "svg+xml", or "html" for a table.
        data: the file.
        size: in print (width, height) [in].
    """

    name: str
    paper: str
    caption: str
    kind: str
    data: bytes
    size: tuple[float, float]


def gallery_page(scenes: Sequence[SceneVideo], pictures: Sequence[Picture], version: str) -> str:
    """Return the page: each scene with its video, YAML and snapshots, then all other figures in their order.

    Args:
        scenes: with their videos.
        pictures: all figures; the snapshots of a scene have its name with ``-frames``.
        version: of emovid.
    """
    snapshots = {f"{scene.name}-frames" for scene in scenes}
    by_name = {picture.name: picture for picture in pictures}
    # The page fetches nothing: its policy forbids it, whatever a browser or an editor may add. Videos in view play,
    # except one paused by hand; without the script, or with less motion preferred, they wait for their controls.
    return Template(_PAGE.read_text(encoding="utf-8")).substitute(
        links="".join(f'<li><a href="#{escape(each.name)}">{escape(heading(each.name))}</a></li>' for each in scenes),
        scenes="".join(_scene(scene, by_name.get(f"{scene.name}-frames")) for scene in scenes),
        figures="".join(_titled(picture) for picture in pictures if picture.name not in snapshots),
        version=escape(version),
    )


def _scene(scene: SceneVideo, frames: Picture | None) -> str:
    name, (width, height) = escape(scene.name), scene.size
    return f"""<section aria-labelledby="{name}">
<h2 id="{name}">{escape(heading(scene.name))}</h2>
<p id="{name}-said">{escape(scene.description)}
<a href="{escape(scene.authors)}">The authors’ own video of {name}</a></p>
<div class="pair">
<video loop muted playsinline controls preload="auto" width="{width}" height="{height}"
aria-label="Video of {name}, without sound" aria-describedby="{name}-said"
poster="{_data("image/png", scene.poster)}" src="{_data("video/mp4", scene.video)}"></video>
<div class="beside">
<pre tabindex="0" role="region" aria-label="Scene of {name}, as YAML">{escape(scene.text)}</pre>
</div>
</div>
{_figure(frames, frames.paper) if frames else ""}</section>
"""


def _titled(picture: Picture) -> str:
    words = picture.name.replace("-", " ")
    title = f"{picture.paper}: {words}" if picture.paper else heading(words)
    return f'<h3 id="{escape(picture.name)}">{escape(title)}</h3>\n{_figure(picture)}'


def _figure(picture: Picture, number: str = "") -> str:
    width, height = (round(_ZOOM * _DOTS * side) for side in picture.size)
    if picture.kind == "html":
        shown = picture.data.decode()
    else:
        source = _data(f"image/{picture.kind}", picture.data)
        shown = f'<img src="{source}" width="{width}" height="{height}" alt="{escape(picture.caption)}">'
    if picture.size[0] > _WIDE:
        shown = f'<div class="wide" tabindex="0" role="group" aria-label="{escape(picture.name)}">{shown}</div>'
    start = f"<strong>{escape(number)}.</strong> " if number else ""
    said = f"{start}{escape(picture.caption)}. <code>emovid figures {escape(picture.name)}</code>"
    return f"<figure>{shown}<figcaption>{said}</figcaption></figure>\n"


def _data(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{b64encode(data).decode()}"
