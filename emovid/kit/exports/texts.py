"""Text that several exports share: templates, and pages as HTML in one line."""

import html
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from string import Template

from emovid.kit.manifest import Manifest

Files = Mapping[str, str]  # path in the folder of the export -> text

_TEMPLATES = Path(__file__).parent / "templates"


def template(name: str, **fields: object) -> str:
    """Return a file of the folder `templates`, with its `$fields` filled in if there are any."""
    text = (_TEMPLATES / name).read_text(encoding="utf-8")
    return Template(text).substitute(fields) if fields else text


def paragraphs(text: str, escape: Callable[[str], str]) -> str:
    """Return text as HTML in one line; blank lines separate paragraphs."""
    parts = (" ".join(part.split()) for part in re.split(r"\n\s*\n", text))
    return "".join(f"<p>{escape(part)}</p>" for part in parts if part)


def consent(manifest: Manifest, escape: Callable[[str], str]) -> str:
    """Return the first page as HTML in one line: the text of the requirements, if any, and that of the consent."""
    needed = manifest.requirements.text
    return (paragraphs(needed, escape) if needed else "") + paragraphs(manifest.consent.text, escape)


def thanks(manifest: Manifest, escape: Callable[[str], str]) -> str:
    """Return the last page as HTML in one line, with debriefing, completion code and return link of the study."""
    debriefing = paragraphs(manifest.debriefing, escape) if manifest.debriefing else ""
    last = manifest.thanks
    return paragraphs(last.text, escape) + debriefing + way_back(manifest, last.code, last.link, escape)


def way_back(manifest: Manifest, code: str | None, link: str | None, escape: Callable[[str], str]) -> str:
    """Return a completion code and a return link as HTML in one line."""
    texts = manifest.texts
    shown = f"<p>{escape(texts.code)} {escape(code)}</p>" if code else ""
    return shown + (f'<p><a href="{escape(link)}">{escape(texts.back)}</a></p>' if link else "")


def video_element(code: str, video_url: str, escape: Callable[[str], str]) -> str:
    """Return the HTML element of a stimulus, without double quotes."""
    source = escape(f"{video_url.rstrip('/')}/{code}.mp4")
    return f"<video src='{source}' controls playsinline preload='auto' style='width:100%;max-width:960px'></video>"


def escaped(text: str, special: str) -> str:
    """Return text in one line as HTML that a tool shows as written, with its `special` characters as entities."""
    text = html.escape(" ".join(text.split()))
    for character in special:
        text = text.replace(character, f"&#{ord(character)};")
    return text
