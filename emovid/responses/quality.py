"""Quality of the data: signs of careless answers and of poor playback, and exclusions by rules fixed beforehand."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Rejected, Table
from emovid.errors import InputError, nearest
from emovid.responses.columns import column
from emovid.responses.parsed_export import numeric
from emovid.responses.responses import FAILED_CHECK, Responses

Mask = NDArray[np.bool_]

SPEEDER, STRAIGHTLINER = "speeder", "straightliner"  # reasons, and values of the column `status` of our own survey
LEFT_OUT = "left out: "  # before the reason, in the list of what was rejected
# Columns of an export that tell about the quality of single answers.
MEASURED = ("response_ms", "watched_share", "frames", "dropped_frames", "stalls", "stalled_ms", "failed_checks")
FEWEST_ALIKE = 3  # ours: videos to which one and the same label is a sign
# Of the median time of all participants: R. Greszki, M. Meyer and H. Schoen, Public Opinion Quarterly 79, 2015.
_FAST = 0.5
_WATCHED = 0.95  # ours: below this share of its length a video was not watched to the end
_DROPPED = 0.1  # ours: of the frames


@dataclass(frozen=True)
class ExclusionRules:
    """Rules for leaving out participants and answers, fixed before the data are seen.

    Attributes:
        straightliners: leave out participants who gave one and the same label to all of three or more videos.
        failed_checks: leave out participants who failed an attention check.
        min_response_ms: leave out participants whose median time to answer is shorter [ms].
        min_watched: leave out answers to videos of which a smaller share was watched.
        max_dropped: leave out answers to videos of which a larger share of frames was dropped.
        max_stalled_ms: leave out answers to videos that stood still for longer [ms].
    """

    straightliners: bool = False
    failed_checks: bool = False
    min_response_ms: float | None = None
    min_watched: float | None = None
    max_dropped: float | None = None
    max_stalled_ms: float | None = None

    def words(self) -> tuple[str, ...]:
        """Return the rules that are set, as on the command line."""
        chosen = {name: value for name, value in asdict(self).items() if value is not None and value is not False}
        return tuple(name if value is True else f"{name}={value:g}" for name, value in chosen.items())


NO_RULES = ExclusionRules()
_NEEDS = {  # title in messages, and columns
    "failed_checks": ("checks", "failed_checks"),
    "min_response_ms": ("response_ms", "response_ms"),
    "min_watched": ("watched_share", "watched_share"),
    "max_dropped": ("frames and dropped_frames", "frames", "dropped_frames"),
    "max_stalled_ms": ("stalled_ms", "stalled_ms"),
}


def rules_from(words: Sequence[str]) -> ExclusionRules:
    """Return the rules that words such as "straightliners" and "min_watched=0.9" state.

    Raises:
        InputError: for an unknown rule, or a value that is no number in range.
    """
    known = [field.name for field in fields(ExclusionRules)]
    values: dict[str, bool | float] = {}
    for word in words:
        name, given, text = (part.strip() for part in word.partition("="))
        name = name.replace("-", "_")
        if name not in known:
            raise InputError(f"--exclude {word}: unknown rule{nearest(name, known)}; expected {', '.join(known)}")
        if name in ("straightliners", "failed_checks"):
            if given:
                raise InputError(f"--exclude {word}: expected {name} without a value")
            values[name] = True
            continue
        values[name] = _number(word, name, text)
    return replace(NO_RULES, **values)  # type: ignore[arg-type]  # checked above


def _number(word: str, name: str, text: str) -> float:
    most = 1.0 if name in ("min_watched", "max_dropped") else float("inf")
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value <= most or value == float("inf"):
        wanted = "a share from 0 to 1" if most == 1 else "milliseconds"
        raise InputError(f"--exclude {word}: expected {name}= and {wanted}, as in {_EXAMPLES[name]}")
    return value


_EXAMPLES = {
    "min_response_ms": "min_response_ms=300",
    "min_watched": "min_watched=0.9",
    "max_dropped": "max_dropped=0.1",
    "max_stalled_ms": "max_stalled_ms=1000",
}


def measured(table: Table) -> dict[str, "pd.Series[float]"]:
    """Return the columns of a table with a row for each answer that tell about quality, as numbers."""
    found = {}
    for name in MEASURED[:-1]:
        if (place := column(table, name)) is not None:
            found[name] = numeric(table.cells[place])
    if (place := column(table, "checks")) is not None:
        parts = table.cells[place].str.extract(r"^(\d+) of (\d+)$").astype(float)
        found[MEASURED[-1]] = parts[1] - parts[0]
    return found


def is_straightliner(labels: Sequence[str], videos: Sequence[str]) -> bool:
    """Return whether a participant gave one and the same label to three or more videos, and no other."""
    return len(set(videos)) >= FEWEST_ALIKE and len(set(labels)) == 1


def is_speeder(response_ms: Sequence[float], least: float | None) -> bool:
    """Return whether the median time of a participant is shorter than the least one [ms]; False without either."""
    return least is not None and len(response_ms) > 0 and float(np.median(response_ms)) < least


def exclude(responses: Responses, rules: ExclusionRules) -> Responses:
    """Return the responses without what the rules leave out; each participant and answer is listed in `rejected`.

    Raises:
        InputError: where the exports lack the column that a rule needs, or nothing is left.
    """
    _check_columns(responses, rules)
    people = responses.answers["participant"]
    out = _participants_out(responses, rules)
    reasons = np.array([out.get(person, "") for person in people], dtype=object)
    by_person = reasons != ""
    for reason, mask in _answers_out(responses.quality, rules):
        reasons[mask & (reasons == "")] = reason
    kept = reasons == ""
    if not kept.any():
        raise InputError(f"--exclude {', '.join(rules.words())}: no answer is left; expected rules that leave some")
    dropped, left_out = dict(responses.dropped), dict(responses.left_out)
    listed = np.flatnonzero(~kept & ~(by_person & people.duplicated().to_numpy()))
    for place in listed:
        counts = dropped if by_person[place] else left_out
        counts[reasons[place]] = counts.get(reasons[place], 0) + 1
    stay = set(people[kept])
    used = people[kept].groupby(responses.places["file"][kept]).nunique() if len(responses.places) else {}
    if without := len(set(people[~by_person]) - stay):
        dropped["no usable answer"] = dropped.get("no usable answer", 0) + without
    return replace(
        responses,
        sources=tuple(replace(source, participants=int(used.get(source.file, 0))) for source in responses.sources),
        answers=responses.answers[kept].reset_index(drop=True),
        quality=responses.quality[kept].reset_index(drop=True),
        places=responses.places[kept].reset_index(drop=True) if len(responses.places) else responses.places,
        participants=responses.participants[responses.participants.index.isin(stay)],
        rejected=(*responses.rejected, *(_row_left_out(responses, int(place), reasons[place]) for place in listed)),
        dropped=dropped,
        left_out=left_out,
        rules=rules.words(),
    )


def _check_columns(responses: Responses, rules: ExclusionRules) -> None:
    for word in rules.words():
        title, *wanted = _NEEDS.get(word.partition("=")[0], ("",))
        for name in wanted:
            if name not in responses.quality or responses.quality[name].isna().all():
                raise InputError(f"--exclude {word}: no export has numbers in {title}; expected a column of that name")


def _participants_out(responses: Responses, rules: ExclusionRules) -> dict[str, str]:
    """Return why the rules leave out a participant, for those whom they do."""
    found = {}
    for person, rows in responses.answers.groupby("participant", sort=False):
        if rules.failed_checks and (responses.quality["failed_checks"][rows.index] > 0).any():
            found[str(person)] = FAILED_CHECK
        elif rules.straightliners and is_straightliner(rows["perceived"].tolist(), rows["video"].tolist()):
            found[str(person)] = STRAIGHTLINER
        elif rules.min_response_ms is not None and is_speeder(
            responses.quality["response_ms"][rows.index].dropna().tolist(), rules.min_response_ms
        ):
            found[str(person)] = SPEEDER
    return found


def _answers_out(quality: pd.DataFrame, rules: ExclusionRules) -> Iterator[tuple[str, Mask]]:
    """Yield the answers that the rules leave out, by reason; an unknown value leaves nothing out."""
    if rules.min_watched is not None:
        yield "not watched", (quality["watched_share"] < rules.min_watched).to_numpy()
    if rules.max_dropped is not None:
        yield "dropped frames", (_dropped_share(quality) > rules.max_dropped).to_numpy()
    if rules.max_stalled_ms is not None:
        yield "stalled", (quality["stalled_ms"] > rules.max_stalled_ms).to_numpy()


def _dropped_share(quality: pd.DataFrame) -> "pd.Series[float]":
    return quality["dropped_frames"] / quality["frames"].clip(lower=1)


def _row_left_out(responses: Responses, place: int, reason: str) -> Rejected:
    person = str(responses.answers["participant"].iloc[place])
    file, line = responses.places.iloc[place] if len(responses.places) else ("", 0)
    return Rejected(str(file), int(line), "participant", person, f"{LEFT_OUT}{reason}")


@dataclass(frozen=True)
class QualitySign:
    """A sign of careless answers or of poor playback among what is analyzed.

    Attributes:
        sign: in words.
        number: participants or answers that show it.
        of: participants or answers of whom it is known.
        unit: "participants" or "answers".
    """

    sign: str
    number: int
    of: int
    unit: str


def quality_signs(responses: Responses) -> tuple[QualitySign, ...]:
    """Return the signs that the exports tell about; none of them leaves anything out by itself."""
    quality, answers = responses.quality, responses.answers
    people = answers.groupby("participant", sort=False)
    enough, signs = people["video"].nunique() >= FEWEST_ALIKE, []
    if len(responses.signalled) > 1 and enough.any():
        alike = (people["perceived"].nunique() == 1) & enough
        words = f"gave one and the same label to all of {FEWEST_ALIKE} or more videos"
        signs.append(QualitySign(words, int(alike.sum()), int(enough.sum()), "participants"))
    persons = answers["participant"].to_numpy()
    if _known(quality, "failed_checks"):
        failed = quality["failed_checks"].groupby(persons).max().dropna()
        signs.append(QualitySign("failed an attention check", int((failed > 0).sum()), len(failed), "participants"))
    if _known(quality, "response_ms"):
        times = quality["response_ms"].groupby(persons).median().dropna()
        middle = float(times.median())
        words = f"took less than half of the median time to answer ({middle / 1000:.1f} s), in their own median"
        signs.append(QualitySign(words, int((times < _FAST * middle).sum()), len(times), "participants"))
    for name, words, shows in _poor_playback(quality):
        values = quality[name].notna()
        signs.append(QualitySign(words, int(shows.sum()), int(values.sum()), "answers"))
    return tuple(signs)


def _poor_playback(quality: pd.DataFrame) -> Iterator[tuple[str, str, "pd.Series[bool]"]]:
    if _known(quality, "watched_share"):
        words = f"video watched for less than {100 * _WATCHED:.0f} % of its length"
        yield "watched_share", words, quality["watched_share"] < _WATCHED
    if _known(quality, "dropped_frames") and _known(quality, "frames"):
        words = f"video of which more than {100 * _DROPPED:.0f} % of the frames were dropped"
        yield "dropped_frames", words, _dropped_share(quality) > _DROPPED
    if _known(quality, "stalls"):
        yield "stalls", "video that stood still during playback", quality["stalls"] > 0


def _known(quality: pd.DataFrame, name: str) -> bool:
    return name in quality and bool(quality[name].notna().any())
