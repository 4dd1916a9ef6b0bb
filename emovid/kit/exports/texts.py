"""Text that several exports share: templates, and pages as HTML in one line."""

import html
import re
from collections.abc import Mapping
from pathlib import Path
from string import Template

from emovid.kit.manifest import Manifest

Files = Mapping[str, str]  # path in the folder of the export -> text

_TEMPLATES = Path(__file__).parent / "templates"


def template(name: str, **fields: object) -> str:
    """Return a file of the folder `templates`, with its `$fields` filled in if there are any."""
    text = (_TEMPLATES / name).read_text(encoding="utf-8")
    return Template(text).substitute(fields) if fields else text


def paragraphs(text: str) -> str:
    """Return text as HTML in one line; blank lines separate paragraphs."""
    parts = re.split(r"\n\s*\n", text.strip())
    return "".join(f"<p>{html.escape(' '.join(part.split()), quote=False)}</p>" for part in parts)


def thanks(manifest: Manifest) -> str:
    """Return the last page as HTML in one line, with the completion code and the return link of the study."""
    last, texts = manifest.thanks, manifest.texts
    code = paragraphs(f"{texts.code} {last.code}") if last.code else ""
    link = f'<p><a href="{html.escape(last.link)}">{html.escape(texts.back)}</a></p>' if last.link else ""
    return paragraphs(last.text) + code + link


def video_tag(code: str, video_url: str) -> str:
    """Return the HTML element of a stimulus."""
    source = html.escape(f"{video_url.rstrip('/')}/{code}.mp4")
    return f'<video src="{source}" controls playsinline preload="auto" style="width:100%;max-width:960px"></video>'
