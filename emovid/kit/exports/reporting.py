"""Drafts of a preregistration and of a reporting checklist, with the facts that a kit knows."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version

from emovid.atomic_io import file_digest
from emovid.errors import InputError
from emovid.kit.exports.texts import Files, template
from emovid.kit.folder import Kit
from emovid.kit.manifest import Manifest
from emovid.kit.orders import balance_of, sets_of, square_size
from emovid.kit.study import Study
from emovid.responses.labels import NONE
from emovid.statistics.planning import plan

OPEN = "**TO DO**"


def preregistration(kit: Kit) -> Files:
    """Return drafts with the fields of the forms of OSF Preregistration and of AsPredicted.

    Raises:
        InputError: for a kit without its private folder.
    """
    facts = _facts(kit)
    return {
        "preregistration.md": template("preregistration.md", **facts),
        "aspredicted.md": template("aspredicted.md", **facts),
    }


def checklist(kit: Kit) -> Files:
    """Return a checklist by the topics of IEEE P3108 and JARS-Quant, ticked where the kit knows the answer.

    Raises:
        InputError: for a kit without its private folder.
    """
    facts = {name: text.replace("\n- ", "; ").removeprefix("- ") for name, text in _facts(kit).items()}
    lines = template("checklist.md", **facts).split("\n")
    marked = [f"- [{' ' if OPEN in line else 'x'}] {line[2:]}" if line.startswith("- **") else line for line in lines]
    return {"checklist.md": "\n".join(marked)}


def _facts(kit: Kit) -> Mapping[str, str]:
    """Return sentences in Markdown by name, as the templates call them."""
    study = kit.study
    if study is None:
        raise InputError(f"{kit.folder.study}: no such file; expected the kit's private folder, with its study")
    if not kit.key:
        raise InputError(f"{kit.folder.key}: no such file; expected the kit's private folder, with its key")
    emotions = [label for label in study.labels if label in kit.key.values()]
    board, approval = study.ethics.board or OPEN, study.ethics.approval or OPEN
    factors = " ".join(
        f"Factor {name}: {OPEN}, direction and test of the difference between {_and(list(levels))}."
        for name, levels in study.factors.items()
    )
    return {
        "open": OPEN,
        "title": kit.manifest.title,
        "version": version("emovid"),
        "authors": ", ".join(kit.manifest.authors) or OPEN,
        "hypotheses": "\n".join(f"{i}. {text}" for i, text in enumerate(study.hypotheses, start=1)) or OPEN,
        "hypotheses_in_line": " ".join(study.hypotheses) or OPEN,
        "factor_hypotheses": factors or "The study has no factors.",
        "emotions": _and(emotions),
        "tests": str(len(emotions)),
        "alpha": f"{study.plan.alpha:g}",
        "design": _design(kit, study, emotions),
        "stimuli": _stimuli(kit, study),
        "source": _source(study),
        "exemplars": _exemplars(study),
        "manipulated": _manipulated(study, emotions),
        "blinding": _blinding(kit.manifest, study),
        "orders": _orders(kit),
        "measures": _measures(kit.manifest),
        "sample": _sample(kit),
        "rationale": _rationale(kit, study, len(emotions)),
        "ratings": _ratings(kit.manifest),
        "none": _none(kit.manifest),
        "groups": _groups(kit.manifest),
        "exclusions": "\n".join(f"- {rule}" for rule in study.exclusions) or OPEN,
        "ethics": f"Approved by {board}, number {approval}. Consent text, version {study.consent.version}.",
        "questions": ", ".join(item.name for item in kit.manifest.demographics) or "nothing",
        "instructions": " ".join(kit.manifest.instructions.split()),
        "manifest": file_digest(kit.folder.manifest),
        "commitment": kit.manifest.key_commitment,
    }


def _design(kit: Kit, study: Study, emotions: Sequence[str]) -> str:
    """Return which factors vary within and which between participants."""
    further = [f"factor {name} ({_and(list(levels))})" for name, levels in study.factors.items()]
    if study.exemplars > 1:
        further.append(f"exemplar ({study.exemplars})")
    within = [f"emotion ({len(emotions)} levels: {_and(emotions)})"]
    if len(sets_of(kit.orders.values())) == 1:
        return f"Within participants: {_and(within + further)}. No factor varies between participants."
    between = _and(further) or "the video of each emotion"
    return f"Within participants: {within[0]}. Between participants: {between}."


def _stimuli(kit: Kit, study: Study) -> str:
    first = kit.manifest.videos[0]
    return (
        f"{_count(len(kit.manifest.videos), 'video')}: {_source(study)} {_exemplars(study)} Each lasts "
        f"{first.duration:g} s, at {first.width}x{first.height} pixels and {first.fps} frames per second, silent."
    )


def _source(study: Study) -> str:
    scenes = [stimulus.scene for stimulus in study.stimuli if stimulus.scene]
    recorded = len(study.stimuli) - len(scenes)
    parts = []
    if scenes:
        parts.append(f"simulations of {_count(len(scenes), 'scene')} ({', '.join(scenes)})")
    if recorded:
        parts.append(f"{_count(recorded, 'finished video')} ({OPEN}: how it was made)")
    return f"{_and(parts)}."


def _exemplars(study: Study) -> str:
    levels = "".join(f" Factor {name} has the levels {_and(list(each))}." for name, each in study.factors.items())
    where = " at each combination of levels" if study.factors else ""
    return f"{_count(study.exemplars, 'exemplar')} of each{where}.{levels}"


def _manipulated(study: Study, emotions: Sequence[str]) -> str:
    lines = [f"- Emotion that a video signals: {_and(emotions)}."]
    lines += [f"- {name}: {_and(list(levels))} ({OPEN}: definition)." for name, levels in study.factors.items()]
    return "\n".join(lines)


def _blinding(manifest: Manifest, study: Study) -> str:
    words = {
        "seed": "random starting positions",
        "turn": "starting phases",
        "mirror": "mirror images",
        "half_turn": "half turns",
    }
    varied = [word for name, word in words.items() if getattr(study.vary, name)]
    scenes = any(stimulus.scene for stimulus in study.stimuli)
    runs = "Runs may be those of the public scenes. " if scenes else ""
    if varied and scenes:
        runs = f"Where a scene allows it, runs differ from those of the public scenes by {_and(varied)}. "
    return (
        "Participants do not know which emotion a video signals: videos have random codes as names, equal length, "
        f"size, frame rate, encoder settings and file size, and no metadata. {runs}The public manifest commits to the "
        f"key by its SHA-256 with a salt, {manifest.key_commitment}."
    )


def _orders(kit: Kit) -> str:
    """Return the orders of the videos for participants, with the balance of the planned orders."""
    manifest, sets = kit.manifest, sets_of(kit.orders.values())
    shown = f"Every participant sees every video once, {manifest.videos_shown} in all."
    if len(sets) > 1:
        shown = (
            f"Every participant sees {manifest.videos_shown} of the {len(manifest.videos)} videos, one of each emotion."
            f" The videos form {len(sets)} sets, which the rows of orders.csv use in turn."
        )
    how = {
        "random": "Each row has a random order.",
        "latin": "Orders come from Latin squares.",
        "williams": "Orders come from Williams squares.",
    }[manifest.order_scheme]
    size = square_size(manifest.order_scheme, manifest.videos_shown) * len(sets)
    equal = f" Counts are equal after every {size} participants." if manifest.order_scheme != "random" else ""
    choices = "the same for all" if manifest.choices.order == "fixed" else "random for each participant and recorded"
    return f"{shown} {how}{equal} {_balance(kit)} The order of the answers is {choices}."


def _balance(kit: Kit) -> str:
    balances = [balance_of(orders, videos) for videos, orders in sets_of(kit.orders.values()).items()]
    positions = _span([count for balance in balances for count in balance.places_range])
    pairs = _span([count for balance in balances for count in balance.pairs_range])
    where = " of its set" if len(balances) > 1 else ""
    rows = f"Over the {_count(len(kit.orders), 'planned row')}, each video has each position {positions}"
    if kit.manifest.videos_shown == 1:
        return f"{rows}."
    return f"{rows}, and follows each other video{where} immediately {pairs}."


def _measures(manifest: Manifest) -> str:
    answers = ", ".join(choice.text for choice in manifest.choices.labels)
    lines = [f'- "{manifest.question}" One answer of: {answers}.']
    lines += [
        f'- {rating.name}: "{rating.question}" Slider from 1 ({rating.low}) to {rating.steps} ({rating.high}).'
        for rating in manifest.ratings
    ]
    for item in manifest.demographics:
        choices = ", ".join(item.choices) if item.choices else "a line of text"
        lines.append(f'- {item.name}: "{item.question}" ({choices}{"" if item.required else "; optional"})')
    return "\n".join(lines)


def _sample(kit: Kit) -> str:
    return f"{_count(kit.manifest.participants, 'participant')}."


def _rationale(kit: Kit, study: Study, tests: int) -> str:
    goal, answers = study.plan, len(study.answers)
    found = plan(goal.rate, answers, tests, goal.alpha, goal.power)
    need = "more than can be planned" if found.n is None else str(found.n)
    few = found.n is None or kit.manifest.participants < found.n
    flag = f" **BELOW THE PLAN**: the kit has {kit.manifest.participants}; {OPEN}: why." if few else ""
    return (
        f"For an emotion with a true hit rate of {goal.rate:g}, {answers} answers (chance {found.chance:.4f}), a power "
        f"of {goal.power:g} and a level of {goal.alpha:g} (first step of Holm's correction for {tests} tests: "
        f"{found.alpha:.4g}), the study needs {need} participants who each answer one video of the emotion: "
        f"{found.n_binomial} for the exact binomial test against chance, {found.n_goodness} for Pearson's chi-squared "
        f"goodness of fit (w = {found.w:.2f}).{flag}"
    )


def _ratings(manifest: Manifest) -> str:
    if not manifest.ratings:
        return "The study has no ratings."
    names = _and([rating.name for rating in manifest.ratings])
    return f"Ratings ({names}): {OPEN}, since `emovid study analyze` does not analyze them."


def _none(manifest: Manifest) -> str:
    if any(choice.label == NONE for choice in manifest.choices.labels):
        return '"None of these" is offered; it counts as an answer that is wrong for every video.'
    return '"None of these" is not offered: a forced choice can raise agreement, which is a limit.'


def _groups(manifest: Manifest) -> str:
    groups = [item.name for item in manifest.demographics if item.choices]
    texts = [item.name for item in manifest.demographics if not item.choices]
    found = f"By {_and(groups)}." if groups else "None."
    return found + (f" Free text, not analyzed by groups: {_and(texts)}." if texts else "")


def _span(counts: Sequence[int]) -> str:
    least, most = min(counts), max(counts)
    return _count(most, "time") if least == most else f"{least} to {_count(most, 'time')}"


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"


def _and(words: Sequence[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else "".join(words)
