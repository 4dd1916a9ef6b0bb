"""`gallery.html`: all figures, the videos and the scenes on one page that needs nothing else."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

from emovid.figures.style import heading

_ZOOM = 1.58  # of figures on a wide screen, over the size they have in print: two columns fill the page
_DOTS = 96  # CSS pixels per inch
_WIDE = 5.0  # figures wider than this [in] are scrolled sideways on a phone, since their text would be too small

_STYLE = """
:root { color-scheme: light; --ink: #1a1a1a; --quiet: #555; --line: #d4d4d4; --ground: #f5f5f2; }
* { box-sizing: border-box; }
html { scroll-padding-top: 1rem; }
body { font: 100%/1.5 system-ui, sans-serif; color: var(--ink); background: #fff; max-width: 70rem; margin: 0 auto;
  padding: 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.75rem; line-height: 1.2; } h2 { font-size: 1.35rem; margin: 3rem 0 .25rem; padding-top: .75rem;
  border-top: 1px solid var(--line); } h3 { font-size: 1rem; margin: 2.5rem 0 .5rem; }
a { color: #0b57a4; } a:focus-visible, [tabindex]:focus-visible, video:focus-visible { outline: 3px solid #0b57a4;
  outline-offset: 2px; }
nav ul { display: flex; flex-wrap: wrap; gap: .25rem; padding: 0; list-style: none; }
nav a { display: block; padding: .5rem .75rem; background: var(--ground); border-radius: .25rem; }
p { max-width: 44rem; } .quiet, figcaption { color: var(--quiet); font-size: .9rem; }
.pair { display: grid; gap: 1rem; margin: 1rem 0 1.5rem; }
.pair > * { min-width: 0; }
video { display: block; width: 100%; height: auto; background: var(--ground); border: 1px solid var(--line); }
pre { margin: 0; padding: .75rem; background: var(--ground); border: 1px solid var(--line); overflow: auto;
  white-space: pre-wrap; font: .8rem/1.45 ui-monospace, monospace; max-height: 22rem; }
figure { margin: 1rem 0 0; } figure img { display: block; max-width: 100%; height: auto; }
figcaption { margin-top: .5rem; max-width: 44rem; }
code { font-family: ui-monospace, monospace; font-size: .9em; }
.wide { overflow-x: auto; } .wide img { min-width: 40rem; }
.skip { position: absolute; left: -100vw; } .skip:focus { position: static; }
@media (min-width: 56rem) { .pair { grid-template-columns: 1fr 1fr; } .pair pre { position: absolute; inset: 0;
  max-height: none; } .beside { position: relative; } }
@media print { .beside, nav { display: none; } .pair { display: block; } figure { break-inside: avoid; } }
"""

# Without a script, or for who wants less motion, videos wait for their controls. Otherwise those in view play, but none
# that was stopped by hand.
_SCRIPT = """
const calm = matchMedia("(prefers-reduced-motion: reduce)");
const inView = new Set(), stopped = new Set();
const update = video => inView.has(video) && !stopped.has(video) && !calm.matches
  ? video.play().catch(() => {}) : video.pause();
const observer = new IntersectionObserver(entries => entries.forEach(({ target, isIntersecting }) => {
  inView[isIntersecting ? "add" : "delete"](target);
  update(target);
}), { threshold: 0.3 });
document.querySelectorAll("video").forEach(video => {
  video.addEventListener("pause", () => { if (inView.has(video)) stopped.add(video); });
  video.addEventListener("play", () => stopped.delete(video));
  observer.observe(video);
});
calm.addEventListener("change", () => document.querySelectorAll("video").forEach(update));
"""
# Nothing is fetched, whatever a browser or an editor of this page may add.
_POLICY = "default-src 'none'; img-src data:; media-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


class Film(NamedTuple):
    """A scene on the page.

    Attributes:
        name: of the scene: an emotion.
        said: what it is, in a line.
        authors: address of the video that the paper's authors made of it.
        text: its YAML.
        video: as MP4.
        poster: what is seen before it plays, as PNG.
        size: of the video (width, height) [pixels].
    """

    name: str
    said: str
    authors: str
    text: str
    video: bytes
    poster: bytes
    size: tuple[int, int]


class Picture(NamedTuple):
    """A figure on the page.

    Attributes:
        name: of the figure.
        paper: its number in the paper, or nothing.
        caption: what it shows.
        kind: "png" or "svg+xml".
        data: the file.
        size: in print (width, height) [in].
    """

    name: str
    paper: str
    caption: str
    kind: str
    data: bytes
    size: tuple[float, float]


def gallery_page(films: Sequence[Film], pictures: Sequence[Picture], version: str) -> str:
    """Return the page: each scene with its video, its YAML and its snapshots, then all other figures in their order.

    Args:
        films: of the scenes.
        pictures: of all figures; those of a scene are called after it, with ``-frames``.
        version: of emovid.
    """
    own = {f"{film.name}-frames" for film in films}
    by_name = {picture.name: picture for picture in pictures}
    others = [picture for picture in pictures if picture.name not in own]
    sections = [_scene(film, by_name.get(f"{film.name}-frames")) for film in films]
    links = "".join(f'<li><a href="#{escape(film.name)}">{escape(heading(film.name))}</a></li>' for film in films)
    title = "From Motions to Emotions: videos, scenes and figures"
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<title>{title}</title>
<style>{_STYLE}</style>
</head>
<body>
<a class="skip" href="#main">Skip to the first scene</a>
<header>
<h1>{title}</h1>
<p>Fifteen small robots express six emotions by how they move, after M. Santos and M. Egerstedt,
<a href="https://doi.org/10.1007/s12369-020-00665-6">From Motions to Emotions: Can the Fundamental Emotions be
Expressed in a Robot Swarm?</a> Each scene is a file, shown beside its video; the figures are drawn from runs of these
files, and from the analysis of a study.</p>
<nav aria-label="Sections"><ul>{links}<li><a href="#figures">Figures and tables</a></li></ul></nav>
</header>
<main id="main">
{"".join(sections)}
<section aria-labelledby="figures">
<h2 id="figures">Figures and tables</h2>
{"".join(_titled(picture) for picture in others)}
</section>
</main>
<footer><p class="quiet">Made by emovid {escape(version)}: <code>emovid figures gallery</code></p></footer>
<script>{_SCRIPT}</script>
</body>
</html>
"""


def _scene(film: Film, frames: Picture | None) -> str:
    name, (width, height) = escape(film.name), film.size
    return f"""<section aria-labelledby="{name}">
<h2 id="{name}">{escape(heading(film.name))}</h2>
<p id="{name}-said">{escape(film.said)} <a href="{escape(film.authors)}">The authors’ own video of {name}</a></p>
<div class="pair">
<video loop muted playsinline controls preload="auto" width="{width}" height="{height}"
aria-label="Video of {name}, without sound" aria-describedby="{name}-said"
poster="{_data("image/png", film.poster)}" src="{_data("video/mp4", film.video)}"></video>
<div class="beside">
<pre tabindex="0" role="region" aria-label="Scene of {name}, as YAML">{escape(film.text)}</pre>
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
    image = (
        f'<img src="{_data(f"image/{picture.kind}", picture.data)}" width="{width}" height="{height}" '
        f'alt="{escape(picture.caption)}">'
    )
    if picture.size[0] > _WIDE:
        image = f'<div class="wide" tabindex="0" role="group" aria-label="{escape(picture.name)}">{image}</div>'
    start = f"<strong>{escape(number)}.</strong> " if number else ""
    said = f"{start}{escape(picture.caption)}. <code>emovid figures {escape(picture.name)}</code>"
    return f"<figure>{image}<figcaption>{said}</figcaption></figure>\n"


def _data(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{b64encode(data).decode()}"
