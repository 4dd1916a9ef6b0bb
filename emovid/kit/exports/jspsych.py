"""A page for jsPsych (J. R. de Leeuw, Behav. Res. Methods 47, 1-12, 2015), without jsPsych itself."""

import html
import json
from pathlib import Path
from string import Template

from emovid.kit.exports.export import Files
from emovid.kit.read import Kit

# The release the page was tried with, and its files: where each comes from in the packages, and where the page looks.
RELEASE = {
    "jspsych@8.3.0": {"dist/index.browser.js": "jspsych.js", "css/jspsych.css": "jspsych.css"},
    "@jspsych/plugin-preload@2.1.0": {"dist/index.browser.js": "plugin-preload.js"},
    "@jspsych/plugin-html-button-response@2.1.0": {"dist/index.browser.js": "plugin-html-button-response.js"},
    "@jspsych/plugin-survey-html-form@2.1.0": {"dist/index.browser.js": "plugin-survey-html-form.js"},
}
_SHOWN = (  # of the manifest
    "title", "question", "choices", "ratings", "demographics", "consent", "instructions", "thanks", "texts",
    "key_commitment",
)  # fmt: skip
_README = """# {title}

A page for jsPsych 8. Put these files of its npm packages beside index.html (`npm pack jspsych@8.3.0` and so on, or the
release archive of that version):

| package | file in it | put it at |
|---|---|---|
{files}

Serve the folder by any web server: browsers do not load videos into a page that is opened as a file. Answers are
downloaded at the end; `save` in experiment.js is the place to send them to a server instead.

`?participant={first}` in the address names the participant and takes the order of that row; without it, the page takes
a row by chance, which balances on average only. A PROLIFIC_PID in the address names the participant, too.

jsPsych has no way back to an earlier video: the procedure of the paper, in which participants could change answers
until the end, needs the survey that emovid serves.

    emovid study analyze DOWNLOADED_FILES --key key.csv --map map.yaml
"""


def jspsych(kit: Kit) -> Files:
    """Return the page, its script and style, and what to put beside them; the videos go with it."""
    here = Path(__file__).parent
    page = Template((here / "index.html").read_text(encoding="utf-8"))
    manifest = kit.manifest
    said = manifest.model_dump(mode="json", include=set(_SHOWN))
    shown = {"choice_orders": kit.choices} | {key: said[key] for key in _SHOWN}
    # The preload list in the order of the codes, before the participants' orders, and both far from the labels.
    shown |= {"preload": [video.file for video in manifest.videos], "orders": kit.orders}
    text = json.dumps(shown, ensure_ascii=False).replace("<", r"\u003c")  # no text of the study ends the data early
    fields = {"language": manifest.language, "title": html.escape(manifest.title), "kit": text}
    return {
        "index.html": page.substitute(fields),
        "experiment.js": (here / "experiment.js").read_text(encoding="utf-8"),
        "experiment.css": (here / "experiment.css").read_text(encoding="utf-8"),
        "README.md": _readme(kit),
    }


def _readme(kit: Kit) -> str:
    files = "\n".join(
        f"| {package} | {source} | jspsych/{target} |"
        for package, sources in RELEASE.items()
        for source, target in sources.items()
    )
    return _README.format(title=kit.manifest.title, files=files, first=next(iter(kit.orders)))
