"""A checklist for the report, by the topics of IEEE P3108 and of APA's reporting standards for quantitative work, JARS.

The wording is ours: it says what a reader asks for, and answers what the kit knows.
"""

from emovid.kit.exports.reporting import OPEN, Facts, facts_of
from emovid.kit.exports.texts import Files
from emovid.kit.folder import Kit

_DONE, _LEFT = "[x]", "[ ]"


def checklist(kit: Kit) -> Files:
    """Return the checklist."""
    lines = [
        f"# Reporting checklist: {kit.manifest.title}",
        "",
        "By the topics of IEEE P3108 (studies of human-robot interaction with people) and of JARS-Quant (APA).",
        f"Filled from the kit by `emovid study export --to checklist`; what only you know is marked {OPEN}.",
    ]
    for section, items in _sections(kit, facts_of(kit)).items():
        lines += ["", f"## {section}", ""]
        for item, answer in items.items():
            lines.append(f"- {_LEFT if OPEN in answer else _DONE} **{item}.** {answer}")
    return {"checklist.md": "\n".join([*lines, ""])}


def _sections(kit: Kit, facts: Facts) -> dict[str, dict[str, str]]:
    measures = facts.measures.replace("\n- ", "; ").removeprefix("- ")
    exclusions = facts.exclusions.replace("\n- ", " ").removeprefix("- ")
    hypotheses = " ".join(facts.study.hypotheses) or OPEN
    after = f"{OPEN}: from `emovid study analyze`"
    return {
        "Question": {
            "Hypotheses": hypotheses,
            "Preregistration": f"{OPEN}: where, and when against the first participant.",
        },
        "Participants": {
            "Number and its justification": facts.participants,
            "Recruitment, place and dates": OPEN,
            "Payment": OPEN,
            "Who could take part": OPEN,
            "Demographics": f"Asked: {', '.join(item.name for item in kit.manifest.demographics) or 'nothing'}. "
            f"Distributions, everybody in a category of their own choice: {after}.",
            "Flow and dropouts": f"{OPEN}: invited, consented, finished, analysed; `emovid study audit KIT "
            "--responses` reports the balance that is left.",
            "Exclusions, decided beforehand": exclusions,
            "Ethics and consent": facts.ethics,
        },
        "Robots and stimuli": {
            "Robot, platform and what it does": "A simulated swarm; each video's scene is in the private list of "
            f"stimuli, to be published with the key. {facts.stimuli}",
            "Video rather than presence": "Participants watch videos; conclusions hold for videos.",
            "Stimulus sampling": f"{facts.study.exemplars} exemplar(s) of each scene: say to which motions "
            "results extend.",
            "Manipulation check": f"{OPEN}: the measured motion of each video beside the description it was made to.",
            "Materials available": f"{OPEN}: where the videos, the scenes and the key are published.",
        },
        "Procedure": {
            "Order and counterbalancing": facts.orders,
            "Blinding": facts.blinding,
            "Instructions": "As in the manifest: " + " ".join(kit.manifest.instructions.split()),
            "Setting and devices": OPEN,
        },
        "Measures": {
            "Measures and answers": measures,
            "Forced choice": _forced(kit),
            "Attention checks": OPEN,
        },
        "Analysis and results": {
            "Tests, levels and corrections": "As preregistered: see `emovid study export --to prereg`.",
            "Statistics with effect sizes and intervals": after + ".",
            "Missing data": f"{after}, which lists every answer left out with the reason.",
            "All tests that were run": OPEN,
            "Data and code available": f"{OPEN}: `emovid study export --to psych-ds --responses` makes the data set.",
        },
        "Discussion": {"Limits and generality": OPEN, "Conflicts of interest and funding": OPEN},
    }


def _forced(kit: Kit) -> str:
    none = any(answer.label == "none" for answer in kit.manifest.choices.labels)
    if none:
        return '"None of these" was offered.'
    return '"None of these" was not offered: a forced choice can raise agreement; say so as a limit.'
