"""From the exports of a survey to `Responses`: the door of this half of the room."""

import hashlib
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from emovid.csv_reader import Rejected, Table, read_bytes, read_table, utf8
from emovid.errors import SourceError, nearest, quoted, reason
from emovid.responses.answer_validation import COLUMNS, settle
from emovid.responses.dialects.jspsych import json_table
from emovid.responses.dialects.parsed_export import Known, Raw, no_answers
from emovid.responses.dialects.registry import dialect_of
from emovid.responses.key import read_key
from emovid.responses.labels import NONE, Labels, plain
from emovid.responses.mapping import Mapping, read_mapping
from emovid.responses.responses import EMOTIONS, Responses, Source
from emovid.responses.results_files import is_of_analysis, is_results


@dataclass(frozen=True, eq=False)
class _Read:
    """One file: what it is, and what it says."""

    source: Source
    names: tuple[str, ...]
    raw: Raw


def read_responses(
    sources: Sequence[Path | str] | Path | str,
    key: Path | str | None = None,
    mapping: Path | str | None = None,
    labels: Sequence[str] | None = None,
    groups: Sequence[str] = (),
) -> Responses:
    """Return the answers in one or more exports.

    Args:
        sources: files, and folders, which are read file by file: one that is no export is named in `rejected` (row 0).
        key: the emotion of each video code, as video_code,true_emotion.
        mapping: a map.yaml.
        labels: instead of the six emotions, or of the map's.
        groups: that must be found.

    Raises:
        SourceError: for a file that cannot be understood, and where no answer is left.
    """
    paths = list(map(Path, [sources] if isinstance(sources, Path | str) else sources))
    known = known_from(Path(key) if key else None, Path(mapping) if mapping else None, labels, groups)
    files, skipped = _read_all(paths, known, {Path(path).resolve() for path in (key, mapping) if path})
    if not files:
        no_file = "no file here, those of an analysis aside"
        first = skipped[0] if skipped else Rejected(", ".join(map(str, paths)), 0, "", "", no_file)
        raise SourceError(
            first.file, f"{first.reason}; expected an export of a survey" if not skipped else first.reason
        )
    _check_columns(known.mapping, files)
    found = _responses(files, known, skipped)
    _check_groups(known, list(found.participants.columns))
    return found


def known_from(
    key: Path | None, mapping: Path | None, labels: Sequence[str] | None = None, groups: Sequence[str] = ()
) -> Known:
    """Return what is known besides the exports. Raises SourceError for a key or a map that cannot be meant."""
    said = read_mapping(mapping) if mapping else Mapping()
    try:
        meant = Labels(labels or said.labels or EMOTIONS, said.answers)
    except SourceError as error:
        path = ("answers", error.key) if error.key else ("labels",)
        raise SourceError(said.places.get(path, "--labels"), error.message, 0, ".".join(path)) from None
    return Known(meant, read_key(key, meant) if key else {}, said, tuple(groups))


def open_table(path: Path) -> tuple[Table, str]:
    """Return the table of a file, CSV or jsPsych's JSON, and the SHA-256 of its bytes.

    Raises:
        SourceError: if it is neither, or has no rows.
    """
    data = read_bytes(path)
    is_json = utf8(data[:100], str(path)).lstrip()[:1] in (b"[", b"{")
    table = json_table(data, str(path)) if is_json else read_table(data, str(path))
    if not len(table.lines):
        found = table.rejected[0].reason if table.rejected else "a header alone"
        raise SourceError(str(path), f"{found}; expected a row for each participant or answer", 1)
    return table, hashlib.sha256(data).hexdigest()


def _read_all(paths: Iterable[Path], known: Known, beside: set[Path]) -> tuple[list[_Read], list[Rejected]]:
    files: list[_Read] = []
    skipped: list[Rejected] = []
    for path in paths:
        for file in files_in(path) if path.is_dir() else [path]:
            if path.is_dir() and file.resolve() in beside:
                continue
            try:
                files.append(_read_one(file, known))
            except SourceError as error:
                if not path.is_dir():
                    raise
                skipped.append(Rejected(str(file), 0, "", "", str(error).removeprefix(f"{file}: ")))
    return files, skipped


def _read_one(file: Path, known: Known) -> _Read:
    twin = file.with_suffix(".csv")
    if file.suffix == ".json" and twin.exists():
        raise SourceError(str(file), f"the same data as {twin.name}")
    table, digest = open_table(file)
    dialect = dialect_of(table, known)
    return _Read(Source(str(file), dialect.name, digest, 0), (*table.names, *table.texts), dialect.read(table, known))


def files_in(folder: Path) -> list[Path]:
    """Return the files of a folder and of those in it by their names, hidden ones and those of an analysis aside."""
    try:
        files = sorted(file for file in folder.rglob("*") if file.is_file() and not file.name.startswith("."))
        analysed = {file.parent for file in files if file.name == "results.json" and is_results(file)}
        return [file for file in files if not is_of_analysis(file, file.parent in analysed)]
    except OSError as error:
        raise SourceError(str(folder), f"cannot be read: {reason(error)}") from None


def _responses(files: list[_Read], known: Known, skipped: list[Rejected]) -> Responses:
    raws = [_apart(file, len(files) > 1) for file in files]
    stated = {code: emotion for raw in raws for code, emotion in raw.codes.items()}
    names = [file.source.file for file in files]
    parts = [raw.answers.assign(file=place) for place, raw in enumerate(raws)]
    together = pd.concat(parts, ignore_index=True) if any(map(len, parts)) else no_answers().assign(file=[])
    known = replace(known, codes=known.codes or stated)
    answers, rejected = settle(together, known, names)
    dropped = Counter[str]()
    for raw in raws:
        dropped.update(raw.dropped)
    rejected = [*skipped, *(row for raw in raws for row in raw.rejected), *rejected]
    if not len(answers):
        raise _nothing_left(names[0], rejected, dropped)
    kept = answers.groupby("file")["participant"].nunique()
    offers_none = known.labels.offers_none or bool((answers["perceived"] == NONE).any())
    stood_for = {*known.codes.values()} or {known.emotion(str(video)) or "" for video in together["video"].unique()}
    signalled = tuple(label for label in known.labels.signalled if label in stood_for)
    answers_only = [label for label in known.labels.signalled if label not in stood_for]
    return Responses(
        signalled=signalled,
        labels=(*signalled, *answers_only, *([NONE] if offers_none else [])),
        answers=answers[COLUMNS],
        participants=_participants(answers, raws, together, dropped),
        sources=tuple(
            replace(file.source, participants=int(kept.get(i, 0)), note=file.raw.note) for i, file in enumerate(files)
        ),
        rejected=tuple(sorted(rejected, key=lambda row: (row.file, row.row))),
        dropped=dict(dropped),
    )


def _apart(file: _Read, several: bool) -> Raw:
    """Return what a file says; where its participants are mere numbers, and other files have theirs, with its name."""
    raw = file.raw
    if not (several and raw.numbered):
        return raw
    prefix = f"{Path(file.source.file).stem}:"
    answers = raw.answers.assign(participant=prefix + raw.answers["participant"])
    return replace(raw, answers=answers, participants=raw.participants.rename(index=lambda name: prefix + name))


def _participants(
    answers: pd.DataFrame, raws: Sequence[Raw], together: pd.DataFrame, dropped: Counter[str]
) -> pd.DataFrame:
    """Return the groups of each participant who has an answer; the others are counted as dropped."""
    people = pd.Index(answers["participant"].unique(), name="participant", dtype="str")
    without = len(set(together["participant"].unique()) - {""} - set(people))
    if without:
        dropped["no usable answer"] += without
    frame = pd.DataFrame(index=people)
    for raw in raws:
        for name in raw.participants.columns:
            column = raw.participants[name].reindex(people).fillna("").astype("str")
            frame[name] = frame[name].where(frame[name] != "", column) if name in frame else column
    return frame


def _nothing_left(file: str, rejected: Sequence[Rejected], dropped: Counter[str]) -> SourceError:
    if dropped.total() and not any(item.row for item in rejected):
        counts = ", ".join(f"{count} {reason}" for reason, count in dropped.items() if count)
        return SourceError(file, f"no participant is left ({counts}); expected answers")
    if not rejected:
        return SourceError(file, "no answer in it; expected some")
    first = next((item for item in rejected if item.row), rejected[0])  # a cell says more than a file passed over
    given = f"{quoted(first.value)} " if first.value else ""
    others = f" ({len(rejected)} cells or rows rejected)" if len(rejected) > 1 else ""
    return SourceError(first.file, f"{given}{first.reason}{others}; see emovid study columns", first.row, first.cell)


def _check_columns(said: Mapping, files: Sequence[_Read]) -> None:
    """Refuse a map whose columns no file has."""
    names = [name for file in files for name in file.names]
    spelled = {plain(name) for name in names}
    paths = [(("groups", group), title) for group, title in said.groups.items()]
    paths += [(("drop", title), title) for title in said.drop]
    for path, title in paths:
        if plain(title) not in spelled:
            message = f"no file has the column {quoted(title)}{nearest(title, names)}; expected one that is there"
            raise SourceError(said.places[path], message, 0, ".".join(path))


def _check_groups(known: Known, found: Sequence[str]) -> None:
    """Refuse groups that are asked for and that no file has."""
    for name in known.groups:
        if name not in found:
            message = f"no file has this group{nearest(name, found)}; expected {', '.join(found) or 'a column of it'}"
            raise SourceError("--by", message, 0, name)
