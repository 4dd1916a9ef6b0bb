"""Answers that count, the reason for each one that does not, and texts that count as a label they do not spell."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Rejected, coded
from emovid.errors import SourceError
from emovid.responses.labels import NONE, Labels, plain
from emovid.responses.mapping import EACH_FILE
from emovid.responses.parsed_export import Known
from emovid.responses.quality import MEASURED
from emovid.responses.responses import EMOTIONS, Synonym

_ABOUT_VIDEOS = ("no video", "unknown video")
_MOST_REPEATED = 0.05  # of the answers: largest share of repeats that is not refused without a rule
NO_ANSWER, TWICE = "no answer", "answered twice"
COLUMNS = ["participant", "video", "signalled", "perceived", "position"]

Texts = NDArray[np.object_]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class ValidAnswers:
    """Answers after validation.

    Attributes:
        frame: answers that count: `COLUMNS`, `file`, `line`, and the columns of `answers` that tell about quality.
        rejected: answers that do not, in the order of the rows.
        synonyms: texts that count as a label that they do not spell.
        unusable: participants with answers of which none can be used, for another reason than a missing answer.
    """

    frame: pd.DataFrame
    rejected: list[Rejected]
    synonyms: tuple[Synonym, ...]
    unusable: frozenset[str]


def valid_answers(answers: pd.DataFrame, known: Known, files: Sequence[str]) -> ValidAnswers:
    """Return the answers that count.

    An answer counts if its participant, its video and its label are known. Of several answers of a participant to one
    video, those count that the map's `repeats` says; without a map the first, if repeats are few.

    Args:
        answers: as in `ParsedExport`, `file` an index into `files`.
        known: codes, labels and map.
        files: names.

    Raises:
        SourceError: if more than one answer in twenty is a repeat and the map does not say which ones count.
    """
    people, names = pd.factorize(answers["participant"])
    codes, emotions = _translated(
        answers["video"], lambda text: (known.code(text) if text else "", known.emotion(text))
    )
    _, labels = _translated(answers["answer"], lambda text: ("", known.labels.find(text)))
    labels = np.where(_is_python_none(answers["answer"], known.labels), "", labels)
    reasons = np.full(len(answers), "", dtype=object)
    _give(reasons, people == _place(names, ""), "no participant")
    _give(reasons, codes == "", _ABOUT_VIDEOS[0])
    _give(reasons, emotions == None, _ABOUT_VIDEOS[1])  # noqa: E711 - elementwise
    _give(reasons, labels == "", NO_ANSWER)
    _give(reasons, labels == None, "not a label")  # noqa: E711 - as above
    valid = reasons == ""
    if known.mapping.repeats != "all":
        _give(reasons, _repeated(answers, people, codes, valid, known, files), _repeat_reason(known))
    kept = reasons == ""
    frame = answers.loc[kept, ["participant", "position", "file", "line"]].reset_index(drop=True)
    frame = frame.astype({"participant": "str", "position": "Int64"})
    for name, words in (("video", codes), ("signalled", emotions), ("perceived", labels)):
        frame[name] = _column(words[kept])
    for name in MEASURED:
        if name in answers:
            frame[name] = answers[name][kept].to_numpy()
    synonyms = _synonyms(answers["answer"][kept], frame["perceived"], known.labels)
    faulty = set(answers["participant"][(reasons != "") & (reasons != NO_ANSWER)].unique()) - {""}
    unusable = frozenset(map(str, faulty - set(frame["participant"].unique())))
    return ValidAnswers(frame, _rejected(answers, reasons, known, files), synonyms, unusable)


def _repeated(
    answers: pd.DataFrame, people: NDArray[np.int64], codes: Texts, valid: Mask, known: Known, files: Sequence[str]
) -> Mask:
    """Return the answers (True) that repeat an earlier one, or are followed by a later one if the last counts."""
    videos = pd.factorize(codes)[0]
    places = people * (int(videos.max(initial=0)) + 1) + videos
    again = np.zeros(len(answers), dtype=bool)
    if len(pd.unique(places[valid])) == valid.sum():
        return again
    order = np.lexsort((answers["line"].to_numpy(), answers["file"].to_numpy(), _order(answers)))
    pairs = pd.Series(places)[order]
    keep = "last" if known.mapping.repeats == "last" else "first"
    usable = valid[order]
    again[order[usable]] = pairs[usable].duplicated(keep=keep).to_numpy()
    count, total = int(again.sum()), int(valid.sum())
    if known.mapping.repeats is None and count > _MOST_REPEATED * total:
        first = answers[again].iloc[0]
        in_files = places * len(files) + answers["file"].to_numpy(dtype=np.int64)
        by_file = ""
        if len(pd.unique(in_files[valid])) == total:  # files with one id, which somebody forgot to change
            by_file = f"participant: {EACH_FILE}, since no file repeats a video; or "
        message = (
            f"{count} of {total} answers repeat a participant's answer to a video; expected map.yaml: {by_file}"
            "repeats: first, last or all, or rows: those to leave out, such as practice"
        )
        raise SourceError(files[int(first["file"])], message, int(first["line"]))
    return again


def _order(answers: pd.DataFrame) -> NDArray[np.float64]:
    """Return the position of each answer, the same for all where some have none."""
    known = answers["position"].astype("Float64").to_numpy(dtype=float, na_value=np.nan)
    return np.zeros(len(answers)) if np.isnan(known).any() else known


def _repeat_reason(known: Known) -> str:
    return f"answered twice: the {known.mapping.repeats or 'first'} counts"


def _is_python_none(texts: "pd.Series[str]", labels: Labels) -> Mask:
    """Return the answers None (True) that a program wrote for a missing value: all other answers are in lower case."""
    words = [text.strip() for text in coded(texts)[1]]
    if "None" not in words or labels.offers_none or labels.is_declared("None"):
        return np.zeros(len(texts), dtype=bool)
    others = [word for word in words if word != "None" and labels.is_label(word) and word[:1].isalpha()]
    if not others or any(word[0].isupper() for word in others):
        return np.zeros(len(texts), dtype=bool)
    return (texts.str.strip() == "None").to_numpy(dtype=bool)


def _synonyms(texts: "pd.Series[str]", labels: "pd.Series[str]", known: Labels) -> tuple[Synonym, ...]:
    """Return the texts that are not the label that they count as, in the order of labels and counts."""
    places, words = coded(texts)
    firsts = pd.Series(labels.to_numpy()).groupby(places).first()
    counts = np.bincount(places, minlength=len(words))
    order = (*known.signalled, NONE)
    found = [
        Synonym(word, str(firsts[i]), int(counts[i]), known.is_declared(word))
        for i, word in enumerate(words)
        if plain(word) != plain(str(firsts[i]))
    ]
    return tuple(sorted(found, key=lambda one: (order.index(one.label), -one.count, one.text)))


def _translated(column: "pd.Series[str]", translate: Callable[[str], tuple[str, str | None]]) -> tuple[Texts, Texts]:
    """Return the two words that each text of a column is translated to; every text is translated once."""
    places, texts = coded(column)
    pairs = [translate(text) for text in texts]
    firsts, seconds = np.full(len(pairs), None, dtype=object), np.full(len(pairs), None, dtype=object)
    firsts[:], seconds[:] = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    return firsts[places], seconds[places]


def _column(words: Texts) -> "pd.Series[str]":
    places, different = pd.factorize(words)
    return pd.Series(pd.array(different, dtype="str").take(places) if len(different) else [], dtype="str")


def _place(names: "pd.Index[str]", name: str) -> int:
    return int(names.get_loc(name)) if name in names else -2


def _give(reasons: Texts, where: Mask, reason: str) -> None:
    reasons[where & (reasons == "")] = reason


def _rejected(answers: pd.DataFrame, reasons: Texts, known: Known, files: Sequence[str]) -> list[Rejected]:
    bad = answers[reasons != ""]
    why_bad = reasons[reasons != ""]
    cells = np.where(np.isin(why_bad, _ABOUT_VIDEOS), bad["video_cell"], bad["cell"])
    given = zip(bad["file"], bad["line"], cells, bad["video"], bad["answer"], why_bad, strict=True)
    videos = f"expected {_some(list(known.codes))}" if known.codes else f"expected {_emotions(known)}, or a key"
    labels = f"expected {_some(known.labels.signalled)}"
    rejected = []
    for file, line, cell, video, answer, reason in given:
        about = {
            _ABOUT_VIDEOS[0]: (video, reason),
            _ABOUT_VIDEOS[1]: (video, f"unknown video; {videos}"),
            "not a label": (answer, f"not a label; {labels}"),
        }
        value, why = about.get(reason, (answer, reason))
        if reason == "not a label" and any(mark.isdigit() for mark in answer):  # number or code of a choice
            why += "; the map's answers can give its label"
        rejected.append(Rejected(files[file], int(line), str(cell), str(value), why))
    return rejected


def _emotions(known: Known) -> str:
    return "an emotion" if known.labels.signalled == EMOTIONS else _some(known.labels.signalled)


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
