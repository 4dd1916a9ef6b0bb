"""What a kit knows that a preregistration and a report must say, in sentences."""

from dataclasses import dataclass

from emovid.errors import InputError
from emovid.kit.folder import Kit
from emovid.kit.orders import square_size
from emovid.kit.study import Study
from emovid.statistics.power import plan

OPEN = "**TO DO**"


@dataclass(frozen=True)
class Facts:
    """What is known of a study, as sentences in Markdown.

    Attributes:
        study: it was made from.
        tests: how many Holm's method corrects for: one for each emotion, whatever the number of its videos.
        participants: how many, and why so many.
        stimuli: what was shown.
        blinding: who knew what.
        orders: who saw what in which order.
        measures: what was asked.
        exclusions: whose answers are left out.
        ethics: under which approval.
    """

    study: Study
    tests: int
    participants: str
    stimuli: str
    blinding: str
    orders: str
    measures: str
    exclusions: str
    ethics: str


def facts_of(kit: Kit) -> Facts:
    """Return what a kit knows.

    Raises:
        InputError: for a kit without its private folder, where study and key are.
    """
    if kit.study is None:
        raise InputError(f"{kit.folder.study}: no such file; expected the kit's private folder, with its study")
    if not kit.key:
        raise InputError(f"{kit.folder.key}: no such file; expected the kit's private folder, with its key")
    tests = len(set(kit.key.values()))
    return Facts(
        study=kit.study,
        tests=tests,
        participants=_participants(kit, kit.study, tests),
        stimuli=_stimuli(kit, kit.study),
        blinding=_blinding(kit, kit.study),
        orders=_orders(kit),
        measures=_measures(kit),
        exclusions="\n".join(f"- {rule}" for rule in kit.study.exclusions) or OPEN,
        ethics=_ethics(kit.study),
    )


def _participants(kit: Kit, study: Study, tests: int) -> str:
    said = study.plan
    found = plan(said.rate, len(study.answers), tests, said.alpha, said.power)
    need = "more than can be planned" if found.n is None else str(found.n)
    return (
        f"{kit.manifest.participants} participants. For an emotion whose true hit rate is {said.rate:g}, with "
        f"{len(study.answers)} answers (chance {found.chance:.4f}), a power of {said.power:g} at a level of "
        f"{said.alpha:g} (the first step of Holm's correction: {found.alpha:.4g}) needs {need}: {found.n_binomial} for "
        f"the exact binomial test against chance, {found.n_goodness} for Pearson's chi-squared goodness of fit "
        f"(w = {found.w:.2f})."
    )


def _stimuli(kit: Kit, study: Study) -> str:
    first = kit.manifest.videos[0]
    factors = "".join(f" Factor {name}: {', '.join(levels)}." for name, levels in study.factors.items())
    return (
        f"{len(kit.manifest.videos)} videos, {study.exemplars} exemplar{'s' * (study.exemplars > 1)} of each of "
        f"{len(study.stimuli)} scenes or recordings.{factors} Each lasts {first.duration:g} s, at {first.width}x"
        f"{first.height} pixels and {first.fps} frames a second, without sound."
    )


def _blinding(kit: Kit, study: Study) -> str:
    words = {"seed": "random starts", "turn": "start phases", "mirror": "mirror images", "half_turn": "half turns"}
    varied = ", ".join(word for name, word in words.items() if getattr(study.vary, name))
    runs = f"Runs are not those of the public scenes: {varied} were drawn from a secret seed. " if varied else ""
    return (
        "The videos have random codes for names, equal length, size, frame rate, encoder settings and file size, and "
        f"no metadata. {runs}The key was committed to before the first participant, by SHA-256 "
        f"{kit.manifest.key_commitment}; it is published, with its salt, after the last one."
    )


def _orders(kit: Kit) -> str:
    manifest = kit.manifest
    shown = (
        "Every participant sees every video once"
        if manifest.videos_shown == len(manifest.videos)
        else (
            f"Every participant sees {manifest.videos_shown} of the {len(manifest.videos)} videos, one for each emotion"
        )
    )
    how = {
        "random": "in a random order of their own",
        "latin": "in orders from Latin squares: each video stands in each place equally often",
        "williams": "in orders from Williams squares: each video stands in each place, and right after each other "
        "video, equally often",
    }[manifest.order_scheme]
    size = square_size(manifest.order_scheme, manifest.videos_shown)
    whole = f"; counts are equal after every {size} participants" if size > 1 else ""
    answers = "fixed" if manifest.choices.order == "fixed" else "drawn for each participant, and recorded"
    return f"{shown}, {how}{whole}. The order of the answers is {answers}."


def _measures(kit: Kit) -> str:
    manifest = kit.manifest
    answers = ", ".join(answer.text for answer in manifest.choices.labels)
    lines = [f'- "{manifest.question}" One answer: {answers}.']
    lines += [f'- {rating.name}: "{rating.question}" ({rating.low} to {rating.high})' for rating in manifest.ratings]
    for item in manifest.demographics:
        choices = f" ({', '.join(item.choices)})" if item.choices else ""
        lines.append(f'- {item.name}: "{item.question}"{choices}')
    return "\n".join(lines)


def _ethics(study: Study) -> str:
    board, number = study.ethics.board or OPEN, study.ethics.approval or OPEN
    return f"Approved by {board}, number {number}. Consent text, version {study.consent.version}."
