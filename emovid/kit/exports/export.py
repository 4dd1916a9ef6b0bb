"""What an export is, and what several of them write alike."""

import html
import re
from collections.abc import Mapping

from emovid.kit.manifest import Manifest

Files = Mapping[str, str]  # from the path in the export's folder to the text


def paragraphs(text: str) -> str:
    """Return text as HTML in one line: paragraphs where it has blank lines."""
    parts = re.split(r"\n\s*\n", text.strip())
    return "".join(f"<p>{html.escape(' '.join(part.split()), quote=False)}</p>" for part in parts)


def thanks(manifest: Manifest) -> str:
    """Return the last page as HTML in one line, with the completion code and the way back, if the study has them."""
    said, texts = manifest.thanks, manifest.texts
    code = paragraphs(f"{texts.code} {said.code}") if said.code else ""
    link = f'<p><a href="{html.escape(said.link)}">{html.escape(texts.back)}</a></p>' if said.link else ""
    return paragraphs(said.text) + code + link


def video_tag(code: str, video_url: str) -> str:
    """Return the element that shows a stimulus."""
    source = html.escape(f"{video_url.rstrip('/')}/{code}.mp4")
    return f'<video src="{source}" controls playsinline preload="auto" style="width:100%;max-width:960px"></video>'
