"""A survey for Qualtrics in its "Advanced Format TXT"."""

import html

from emovid.kit.exports.texts import Files, paragraphs, template, thanks, video_tag
from emovid.kit.folder import Kit
from emovid.kit.study import Question


def qualtrics(kit: Kit, video_url: str) -> Files:
    """Return the survey, with the videos at an address, and a README."""
    manifest = kit.manifest
    blocks = [
        _block("Consent", _question("consent", paragraphs(manifest.consent.text), _agreement(kit))),
        *([_block("About you", *map(_item, manifest.demographics))] if manifest.demographics else []),
        _block("Instructions", f"[[Question:DB]]\n[[ID:instructions]]\n{paragraphs(manifest.instructions)}\n"),
        *(_block(code, *_video(kit, code, video_url)) for code in manifest.codes),
        _block("End", f"[[Question:DB]]\n[[ID:end]]\n{thanks(manifest)}\n"),
    ]
    seconds = f"{manifest.videos[0].duration:g}"
    readme = template("qualtrics.md", title=manifest.title, shown=manifest.videos_shown, seconds=seconds)
    return {"survey.txt": "[[AdvancedFormat]]\n\n" + "\n".join(blocks), "README.md": readme}


def _block(name: str, *questions: str) -> str:
    return f"[[Block:{name}]]\n\n" + "\n".join(questions)


def _question(name: str, text: str, choices: list[str], layout: str = "Vertical") -> str:
    listed = "\n".join(map(html.escape, choices))
    return f"[[Question:MC:SingleAnswer:{layout}]]\n[[ID:{name}]]\n{text}\n[[Choices]]\n{listed}\n"


def _agreement(kit: Kit) -> list[str]:
    return [kit.manifest.consent.agree, kit.manifest.consent.decline]


def _item(item: Question) -> str:
    if item.choices is None:
        return f"[[Question:TE:SingleLine]]\n[[ID:{item.name}]]\n{html.escape(item.question)}\n"
    return _question(item.name, html.escape(item.question), list(item.choices))


def _video(kit: Kit, code: str, video_url: str) -> list[str]:
    manifest = kit.manifest
    text = f"{video_tag(code, video_url)}<br>{html.escape(manifest.question)}"
    questions = [_question(code, text, [answer.text for answer in manifest.choices.labels])]
    for rating in manifest.ratings:
        label = f"{html.escape(rating.question)} (1: {html.escape(rating.low)}, 7: {html.escape(rating.high)})"
        questions.append(_question(f"{code}_{rating.name}", label, list("1234567"), "Horizontal"))
    return [*questions, "[[PageBreak]]\n"]
