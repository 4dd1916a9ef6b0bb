"""From answers as they stand in files to answers that count, and the reason for each one that does not."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Rejected
from emovid.responses.dialects.parsed_export import Known
from emovid.responses.key import code_of
from emovid.responses.responses import EMOTIONS

_ABOUT_VIDEOS = ("no video", "unknown video")
COLUMNS = ["participant", "video", "signalled", "perceived", "position"]


def settle(answers: pd.DataFrame, known: Known, files: Sequence[str]) -> tuple[pd.DataFrame, list[Rejected]]:
    """Return the answers that count, and those that do not.

    An answer counts if its participant, its video and the label it means are known, and if it is the participant's
    first to that video.

    Args:
        answers: as in `Raw`, with `file` (a place in `files`) besides.
        known: the codes and labels.
        files: names.

    Returns:
        the columns `COLUMNS` and `file`, and what is rejected, in the order of the rows.
    """
    people, names = pd.factorize(answers["participant"])
    codes, emotions = _translated(answers["video"], lambda text: (code_of(text), known.emotion(text)))
    _, labels = _translated(answers["answer"], lambda text: ("", known.labels.find(text)))
    reasons = np.full(len(answers), "", dtype=object)
    _give(reasons, people == _place(names, ""), "no participant")
    _give(reasons, codes == "", _ABOUT_VIDEOS[0])
    _give(reasons, emotions == None, _ABOUT_VIDEOS[1])  # noqa: E711 - elementwise
    _give(reasons, labels == "", "no answer")
    _give(reasons, labels == None, "no label")  # noqa: E711 - as above
    valid = reasons == ""
    videos = pd.factorize(codes)[0]
    pairs = pd.Series(people * (int(videos.max(initial=0)) + 1) + videos)
    again = np.zeros(len(answers), dtype=bool)
    again[valid] = pairs[valid].duplicated().to_numpy()
    _give(reasons, again, "answered twice: the first counts")
    kept = reasons == ""
    words = {"participant": answers["participant"], "video": codes, "signalled": emotions, "perceived": labels}
    frame = pd.DataFrame({name: pd.Series(np.asarray(column)[kept], dtype="str") for name, column in words.items()})
    frame["position"] = answers["position"][kept].astype("Int64").to_numpy()
    frame["file"] = answers["file"][kept].to_numpy()
    frame["position"] = frame["position"].astype("Int64")
    return frame, _rejected(answers, reasons, known, files)


def _translated(column: "pd.Series[str]", translate: object) -> tuple[NDArray[np.object_], NDArray[np.object_]]:
    """Return the two words that each text of a column is translated to; every text is translated once."""
    assert callable(translate)
    places, texts = pd.factorize(column)
    pairs = [translate(str(text)) for text in texts]
    firsts, seconds = np.full(len(pairs), None, dtype=object), np.full(len(pairs), None, dtype=object)
    firsts[:], seconds[:] = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    return firsts[places], seconds[places]


def _place(names: "pd.Index[str]", name: str) -> int:
    return int(names.get_loc(name)) if name in names else -2


def _give(reasons: NDArray[np.object_], where: NDArray[np.bool_], reason: str) -> None:
    reasons[where & (reasons == "")] = reason


def _rejected(
    answers: pd.DataFrame, reasons: NDArray[np.object_], known: Known, files: Sequence[str]
) -> list[Rejected]:
    bad = answers[reasons != ""]
    why_bad = reasons[reasons != ""]
    cells = np.where(np.isin(why_bad, _ABOUT_VIDEOS), bad["video_cell"], bad["cell"])
    given = zip(bad["file"], bad["line"], cells, bad["video"], bad["answer"], why_bad, strict=True)
    videos = f"expected {_some(known.codes)}" if known.codes else f"expected {_emotions(known)}, or a key"
    labels = f"expected {_some(known.labels.signalled)}"
    rejected = []
    for file, line, cell, video, answer, reason in given:
        about = {
            _ABOUT_VIDEOS[0]: (video, reason),
            _ABOUT_VIDEOS[1]: (video, f"unknown video; {videos}"),
            "no label": (answer, f"no label; {labels}"),
        }
        value, why = about.get(reason, (answer, reason))
        if reason == "no label" and any(mark.isdigit() for mark in answer):  # a choice's number or code
            why += "; map.yaml: answers can say what it means"
        rejected.append(Rejected(files[file], int(line), str(cell), str(value), why))
    return rejected


def _emotions(known: Known) -> str:
    return "an emotion" if known.labels.signalled == EMOTIONS else _some(known.labels.signalled)


def _some(words: object) -> str:
    names = list(words)  # type: ignore[call-overload]
    return ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
