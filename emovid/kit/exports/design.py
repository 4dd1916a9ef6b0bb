"""The parts of a study's design, and how far a tool carries each of them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

from emovid.kit.folder import Kit
from emovid.kit.orders import sets_of
from emovid.kit.study import Requirements

VIDEOS, ORDERS, SETS = "videos", "orders", "sets of videos"
CHOICES, RATINGS, QUESTIONS = "choices", "ratings", "questions"
CONSENT, DECLINED, INSTRUCTIONS = "consent", "declining", "instructions"
CODE, LINK = "completion code", "return link"
WATCHING, REVISION, LANGUAGE = "watching to the end", "changing earlier answers", "language"
PRACTICE, CHECKS, AFTER = "practice video", "attention checks", "questions after the videos"
DEBRIEFING, REQUIREMENTS = "debriefing", "devices and browsers"
RECRUITMENT, RETURNS = "recruitment parameters", "codes for declining or failing"
TRANSLATIONS = "further languages"


class Status(Enum):
    """How far a tool carries a part of the design."""

    CARRIED = "carried"
    CHANGED = "carried differently"
    BY_HAND = "to do by hand"
    MISSING = "not possible"


@dataclass(frozen=True)
class Support:
    """Support of a tool for one part of the design, and the work that remains for the researcher."""

    status: Status
    note: str


@dataclass(frozen=True)
class DesignPart:
    """A part of the design of a kit, and its support by a tool."""

    name: str
    value: str
    support: Support


Limits = Mapping[str, Support]
CARRIED = Support(Status.CARRIED, "")


def changed(note: str) -> Support:
    """Return the support of a part that the tool does in another way."""
    return Support(Status.CHANGED, note)


def by_hand(note: str) -> Support:
    """Return the support of a part that the researcher must set in the tool."""
    return Support(Status.BY_HAND, note)


def missing(note: str) -> Support:
    """Return the support of a part that the tool does not have."""
    return Support(Status.MISSING, note)


def design_of(kit: Kit, limits: Limits) -> list[DesignPart]:
    """Return the parts of the design that a kit has, each with the support of a tool; carried unless in `limits`."""
    other = by_hand("The export has one language. Add the others as translations in the tool.")
    known = {TRANSLATIONS: other, **limits}
    return [DesignPart(name, value, known.get(name, CARRIED)) for name, value in _parts(kit).items() if value]


def listed(parts: Iterable[DesignPart]) -> str:
    """Return the parts that are not carried as they are, as a list in Markdown."""
    lines = [
        f"- **{part.name}** ({part.value}): {part.support.status.value}. {part.support.note}"
        for part in parts
        if part.support.status is not Status.CARRIED
    ]
    return "\n".join(lines) or "Nothing: the tool carries the whole design."


def _requirements(needed: Requirements) -> str:
    """Return the requirements that are not the default."""
    usual = Requirements()
    found = [", ".join(needed.devices)] if needed.devices != usual.devices else []
    found += [f"at least {needed.min_width} pixels wide"] if needed.min_width else []
    found += [", ".join(needed.browsers)] if needed.browsers else []
    return "; ".join([*found, *(["a text"] if needed.text else [])])


def _parts(kit: Kit) -> dict[str, str]:
    manifest = kit.manifest
    sets = len(sets_of(kit.orders.values()))
    return {
        VIDEOS: f"{len(manifest.videos)}",
        SETS: f"{sets}, one for each participant, {manifest.videos_shown} videos each" if sets > 1 else "",
        ORDERS: f"{manifest.order_scheme}, {len(kit.orders)} participants",
        CHOICES: f"{len(manifest.choices.labels)}, {manifest.choices.order} order",
        RATINGS: ", ".join(f"{rating.name} (1 to {rating.steps})" for rating in manifest.ratings),
        QUESTIONS: ", ".join(question.name for question in manifest.demographics),
        AFTER: ", ".join(question.name for question in manifest.questions_after),
        PRACTICE: manifest.practice.code if manifest.practice else "",
        CHECKS: ", ".join(f"{check.name} after {check.after} videos" for check in manifest.checks),
        DEBRIEFING: "one text" if manifest.debriefing else "",
        REQUIREMENTS: _requirements(manifest.requirements),
        RECRUITMENT: ", ".join(manifest.recruitment.names) if manifest.recruitment else "",
        RETURNS: "given" if any(word for back in (kit.server.declined, kit.server.failed) for _, word in back) else "",
        CONSENT: f"version {manifest.consent.version}",
        DECLINED: "a page of its own, without completion code",
        INSTRUCTIONS: "one page",
        CODE: manifest.thanks.code or "",
        LINK: manifest.thanks.link or "",
        WATCHING: "required; videos may be repeated",
        REVISION: "until the end",
        LANGUAGE: manifest.language,
        TRANSLATIONS: ", ".join(manifest.translations),
    }
