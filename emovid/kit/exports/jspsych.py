"""A page for jsPsych (J. R. de Leeuw, Behav. Res. Methods 47, 1-12, 2015), without the files of jsPsych."""

import html
import json

from emovid.kit.exports.design import (
    CHECKS,
    CODE,
    LINK,
    ORDERS,
    RECRUITMENT,
    REQUIREMENTS,
    RETURNS,
    REVISION,
    TRANSLATIONS,
    Limits,
    by_hand,
    changed,
    design_of,
    listed,
    missing,
)
from emovid.kit.exports.texts import Files, template
from emovid.kit.folder import Kit
from emovid.kit.study import Requirements

# The tested releases: their files, and the names under which the page loads them.
RELEASE = {
    "jspsych@8.3.0": {"dist/index.browser.js": "jspsych.js", "css/jspsych.css": "jspsych.css"},
    "@jspsych/plugin-preload@2.1.0": {"dist/index.browser.js": "plugin-preload.js"},
    "@jspsych/plugin-html-button-response@2.1.0": {"dist/index.browser.js": "plugin-html-button-response.js"},
    "@jspsych/plugin-survey-html-form@2.1.0": {"dist/index.browser.js": "plugin-survey-html-form.js"},
}
_SHOWN = (  # of the manifest
    "title", "question", "choices", "ratings", "demographics", "consent", "instructions", "thanks", "texts",
    "key_commitment", "requirements", "questions_after", "debriefing",
)  # fmt: skip


def limits(kit: Kit) -> Limits:
    """Return the parts of the design that jsPsych does not carry as they are."""
    seen = changed("It is in the source of the page, where anyone can read it without taking part.")
    found = {
        CODE: seen,
        LINK: seen,
        RETURNS: missing("A page without a server cannot keep them secret, nor judge an attention check."),
        CHECKS: changed("The page does not judge the answers: they are in the column check_response."),
        RECRUITMENT: changed("The parameters are in the same file as the answers: remove them before you share it."),
        ORDERS: changed("Without ?participant=... in the address, a row of orders.csv is chosen at random."),
        REVISION: missing("jsPsych cannot return to an earlier video."),
    }
    if kit.manifest.translations:
        found[TRANSLATIONS] = missing("The page has one language: export a kit for each.")
    if kit.manifest.requirements != Requirements(text=kit.manifest.requirements.text):
        found[REQUIREMENTS] = by_hand("The page does not check them; plugin-browser-check of jsPsych can.")
    return found


def jspsych(kit: Kit) -> Files:
    """Return the page, its script and style, and a README."""
    manifest = kit.manifest
    public = manifest.model_dump(mode="json", include=set(_SHOWN))
    shown = {"choice_orders": kit.choices} | {key: public[key] for key in _SHOWN}
    # Codes come last, far from the labels, and in an uninformative order.
    shown |= {
        "parameters": manifest.recruitment.names if manifest.recruitment else (),
        "practice": manifest.practice.file if manifest.practice else None,
        "checks": [
            {
                "name": one.name,
                "question": one.question,
                "choices": one.choices,
                "after": one.after,
                "file": one.video.file,
            }
            for one in manifest.checks
        ],
    }
    shown |= {"preload": [video.file for video in manifest.videos], "orders": kit.orders}
    text = json.dumps(shown, ensure_ascii=False).replace("<", r"\u003c")  # no text can end the script element
    fields = {"language": manifest.language, "title": html.escape(manifest.title), "kit": text}
    return {
        "index.html": template("index.html", **fields),
        "experiment.js": template("experiment.js"),
        "experiment.css": template("experiment.css"),
        "README.md": _readme(kit),
    }


def _readme(kit: Kit) -> str:
    files = "\n".join(
        f"| {package} | {source} | jspsych/{target} |"
        for package, sources in RELEASE.items()
        for source, target in sources.items()
    )
    left = listed(design_of(kit, limits(kit)))
    return template("jspsych.md", title=kit.manifest.title, files=files, first=next(iter(kit.orders)), left=left)
