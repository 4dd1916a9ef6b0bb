"""Condition files for PsychoPy: one per participant, in the order of presentation."""

from emovid.csv_writer import csv_text
from emovid.kit.exports.design import (
    AFTER,
    CHECKS,
    CODE,
    CONSENT,
    DEBRIEFING,
    DECLINED,
    INSTRUCTIONS,
    LANGUAGE,
    LINK,
    PRACTICE,
    QUESTIONS,
    RATINGS,
    RECRUITMENT,
    REQUIREMENTS,
    RETURNS,
    REVISION,
    WATCHING,
    Limits,
    by_hand,
    design_of,
    listed,
    missing,
)
from emovid.kit.exports.texts import Files, template
from emovid.kit.folder import Kit


def limits(kit: Kit) -> Limits:
    """Return the parts of the design that condition files cannot contain."""
    page = by_hand("Add a routine with the text below.")
    return {
        CONSENT: page,
        DECLINED: by_hand("After consent, end the experiment (thisExp.status = FINISHED), and show the text below."),
        INSTRUCTIONS: page,
        QUESTIONS: by_hand("Ask them in the dialog at the start (Experiment info), or in a routine with a Form."),
        RATINGS: by_hand("Add a routine after the answer with a Slider for each, named after it, as described below."),
        CODE: by_hand("Show it in a routine at the end."),
        LINK: by_hand("Enter it as completed URL (Experiment settings, Online)."),
        WATCHING: by_hand("Empty the field Stop of the Movie component, and tick Force end of Routine."),
        PRACTICE: by_hand("Add a routine before the loop with the video below."),
        CHECKS: by_hand("Add routines with the videos and questions below; leave the loop and enter it again."),
        AFTER: by_hand("Ask them in a routine with a Form after the loop."),
        DEBRIEFING: page,
        REQUIREMENTS: by_hand("PsychoPy does not check them."),
        RECRUITMENT: by_hand("Pavlovia adds the parameters of its address to Experiment info: name them there."),
        RETURNS: by_hand("Show them in routines of their own, or enter the incomplete URL (Experiment settings)."),
        REVISION: missing("A PsychoPy loop does not return to an earlier trial."),
        LANGUAGE: by_hand(f"All texts that you add are to be in {kit.manifest.language}."),
    }


def psychopy(kit: Kit) -> Files:
    """Return the condition files and a README."""
    header = ["position", "video_code", "video_file", *(["choices"] if kit.choices else [])]
    files = {}
    for name, order in kit.orders.items():
        drawn = ["|".join(kit.choices[name])] if name in kit.choices else []
        rows = [[place, code, f"videos/{code}.mp4", *drawn] for place, code in enumerate(order, start=1)]
        files[f"conditions/{name}.csv"] = csv_text(header, rows)
    manifest = kit.manifest
    readme = template(
        "psychopy.md",
        title=manifest.title,
        first=next(iter(kit.orders)),
        left=listed(design_of(kit, limits(kit))),
        question=manifest.question,
        answers="\n".join(f"- {choice.label}: {choice.text}" for choice in manifest.choices.labels),
        texts="\n\n".join(f"### {name}\n\n{text}" for name, text in _texts(kit).items()),
    )
    return files | {"README.md": readme}


def _texts(kit: Kit) -> dict[str, str]:
    """Return the texts of the routines to add, by heading."""
    manifest, consent, last = kit.manifest, kit.manifest.consent, kit.manifest.thanks
    ratings = {
        rating.name: f"{rating.question}\n\n"
        f"Ticks 1 to {rating.steps}, granularity 1; labels: {rating.low}, {rating.high}"
        for rating in manifest.ratings
    }
    questions = {
        item.name: "\n".join([item.question, "", *(f"- {choice}" for choice in item.choices or ("(a line of text)",))])
        for item in (*manifest.demographics, *manifest.questions_after)
    }
    questions |= {
        check.name: f"videos/{check.video.code}.mp4, after {check.after} videos\n\n{check.question}\n\n"
        + "\n".join(f"- {choice}" for choice in check.choices)
        for check in manifest.checks
    }
    if manifest.practice:
        questions["Practice"] = f"videos/{manifest.practice.code}.mp4\n\n{manifest.texts.practice_note}"
    thanks = [
        last.text.strip(),
        manifest.debriefing or "",
        f"{manifest.texts.code} {last.code}" if last.code else "",
        last.link or "",
    ]
    return {
        "Requirements": manifest.requirements.text or "(none)",
        f"Consent, version {consent.version}": f"{consent.text.strip()}\n\n- {consent.agree}\n- {consent.decline}",
        "After declining": consent.declined,
        **questions,
        "Instructions": manifest.instructions.strip(),
        **ratings,
        "Last page": "\n\n".join(filter(None, thanks)),
    }
