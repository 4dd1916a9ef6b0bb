"""From the exports of a survey to `Responses`."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from emovid.csv_reader import Rejected, Table, joined_table
from emovid.errors import SourceError, nearest, quoted
from emovid.responses.answer_validation import COLUMNS, NO_ANSWER, TWICE, ValidAnswers, valid_answers
from emovid.responses.choice_columns import with_choices
from emovid.responses.dialects.registry import Dialect, dialect_of
from emovid.responses.export_files import files_in, open_table, short_names
from emovid.responses.key import read_key
from emovid.responses.labels import NONE, Labels, plain
from emovid.responses.mapping import ExportMap, read_mapping, unknown_column
from emovid.responses.parsed_export import Known, ParsedExport, no_answers
from emovid.responses.quality import MEASURED
from emovid.responses.responses import EMOTIONS, Responses, Source

_WITH_SURVEYS = ("jsPsych", "psiTurk", "reVISit")  # groups are within cells, and not names of columns
_COPY = re.compile(r"(?i:( ?\(\d+\)|[ _-]+(copy|kopie|copie|copia)( ?\(?\d+\)?)?)$)")  # end of the name of a copy
_ODD_NAME = re.compile(r"(test|pilot|demo|debug|preview|tester|mode|mean|median|total|sum|average)[ _-]?\d*")
_SEVERAL = 3  # rows of an unknown video: fewest that can be those of a lost one
_MOST_VALUES = 4  # of a reason: largest number of rare values with a line each
MOST_REJECTED = 0.1  # largest share of answers, rows and participants that may be rejected


@dataclass(frozen=True, eq=False)
class _File:
    """One file: its table, format and digest."""

    table: Table
    dialect: Dialect
    sha256: str


@dataclass(frozen=True, eq=False)
class _Parsed:
    """Files that were read as one table."""

    files: tuple[str, ...]
    parsed: ParsedExport


def read_responses(
    sources: Sequence[Path | str] | Path | str,
    key: Path | str | None = None,
    mapping: Path | str | None = None,
    labels: Sequence[str] | None = None,
    groups: Sequence[str] = (),
    include_pilots: bool = False,
    max_rejected: float = MOST_REJECTED,
) -> Responses:
    """Return the answers in one or more exports.

    Args:
        sources: files, and folders, whose files are read one by one: other files are in `rejected` (row 0).
        key: emotion of each video code, as video_code,true_emotion.
        mapping: a map.yaml.
        labels: instead of the six emotions, or of the map's.
        groups: groups that must be found.
        include_pilots: whether answers of pilot runs count.
        max_rejected: largest share of rows or participants that may be unusable for another reason than a mark of the
            tool, a rule of the map, or a missing answer.

    Raises:
        SourceError: for a file that cannot be understood, if too much is rejected, and if no answer is left.
    """
    paths = list(map(Path, [sources] if isinstance(sources, Path | str) else sources))
    known = known_from(Path(key) if key else None, Path(mapping) if mapping else None, labels, groups)
    known = replace(known, include_pilots=include_pilots)
    files, skipped = _open_all(paths, known, {Path(path).resolve() for path in (key, mapping) if path})
    if not files:
        no_file = "no file here, except those of an analysis; expected an export of a survey"
        raise (
            SourceError(skipped[0].file, skipped[0].reason)
            if skipped
            else SourceError(", ".join(map(str, paths)), no_file)
        )
    _check_columns(known.mapping, files)
    known = replace(known, file_names=short_names(file.table.file for file in files))
    found = _responses(files, known, skipped, max_rejected)
    _check_groups(known, files, list(found.participants.columns))
    return found


def known_from(
    key: Path | None, mapping: Path | None, labels: Sequence[str] | None = None, groups: Sequence[str] = ()
) -> Known:
    """Return the facts known besides the exports. Raises SourceError for an invalid key or map."""
    said = read_mapping(mapping) if mapping else ExportMap()
    try:
        meant = Labels(labels or said.labels or EMOTIONS, said.answers)
    except SourceError as error:
        path = ("answers", error.key) if error.key else ("labels",)
        where = said.place(*path) if path[0] in said.model_fields_set else "--labels"
        raise SourceError(where, error.message, 0, ".".join(path)) from None
    return Known(meant, read_key(key, meant) if key else {}, said, tuple(groups))


def _open_all(paths: Iterable[Path], known: Known, beside: set[Path]) -> tuple[list[_File], list[Rejected]]:
    files: list[_File] = []
    skipped: list[Rejected] = []
    for path in paths:
        for file in files_in(path) if path.is_dir() else [path]:
            if path.is_dir() and file.resolve() in beside:
                continue
            try:
                opened = _open(file, known)
                _check_copy(opened, files)
                files.append(opened)
            except SourceError as error:
                if not path.is_dir():
                    raise
                why = error.message if error.where == str(file) else str(error)
                skipped.append(Rejected(str(file), 0, "", "", why))
    return files, skipped


def _check_copy(file: _File, others: Sequence[_File]) -> None:
    """Raise SourceError for a file that has the bytes of another one, and the name of a copy of it."""
    for other in others:
        if file.sha256 == other.sha256:
            path, first = Path(file.table.file), Path(other.table.file)
            if path == first or _COPY.sub("", path.stem) == _COPY.sub("", first.stem):
                raise SourceError(str(path), f"the same data as {first.name}")


def _open(file: Path, known: Known) -> _File:
    twin = file.with_suffix(".csv")
    if file.suffix == ".json" and twin.exists():
        raise SourceError(str(file), f"the same data as {twin.name}")
    table, digest = open_table(file)
    table = with_choices(table, known)
    return _File(table, dialect_of(table, known), digest)


def read_pooled(files: Sequence[tuple[Table, Dialect]], known: Known) -> Iterator[tuple[tuple[str, ...], ParsedExport]]:
    """Yield the names and the content of files, those of one format with the same columns read as one table.

    The roles of columns are decided once for all participants: a participant who is always right in a file of their own
    does not make the column of answers look like that of true emotions.
    """
    for dialect, tables in pools(files):
        yield tuple(table.file for table in tables), dialect.read(joined_table(tables), known)


def pools(files: Sequence[tuple[Table, Dialect]]) -> list[tuple[Dialect, list[Table]]]:
    """Return the tables that are read as one: those of a tool, and tables of no tool with the same columns."""
    groups: dict[tuple[object, ...], tuple[Dialect, list[Table]]] = {}
    for i, (table, dialect) in enumerate(files):
        is_tool = dialect.is_pooled and dialect.name != "long table" and len(set(table.names)) == len(table.names)
        group = (dialect.name, *(() if is_tool else (tuple(sorted(table.names)),) if dialect.is_pooled else (i,)))
        groups.setdefault(group, (dialect, []))[1].append(table)
    return list(groups.values())


def _responses(files: Sequence[_File], known: Known, skipped: Sequence[Rejected], max_rejected: float) -> Responses:
    parts = [_Parsed(*pair) for pair in read_pooled([(file.table, file.dialect) for file in files], known)]
    parts = [_apart(part, known) if len(files) > 1 else part for part in parts]
    names = [name for part in parts for name in part.files]
    known = replace(known, codes=known.codes or {code: e for part in parts for code, e in part.parsed.codes.items()})
    together = _together(parts)
    valid = valid_answers(together, known, names)
    dropped, left_out = Counter[str](), Counter[str]()
    for part in parts:
        dropped.update(part.parsed.dropped)
        left_out.update(part.parsed.left_out)
    ragged = [row for part in parts for row in part.parsed.rejected]
    rejected = [*skipped, *ragged, *valid.rejected]
    if not len(valid.frame):
        raise _nothing_left(names[0], rejected, dropped)
    rejected += [row for part in parts for row in part.parsed.excluded]
    _check_rejected([*ragged, *valid.rejected], len(together) + len(ragged), max_rejected)
    _check_people(valid, int((together["participant"].drop_duplicates() != "").sum()), max_rejected)
    _check_lost(valid, known)
    participants = _participants(valid.frame, parts, together, dropped)
    warnings = [warning for part in parts for warning in part.parsed.warnings]
    warnings += [*_odd_names(participants.index), *_other_options(valid.rejected)]
    signalled, labels = _labels(valid.frame, together, known)
    notes = {name: part.parsed.note for part in parts for name in part.files}
    return Responses(
        signalled=signalled,
        labels=labels,
        answers=valid.frame[COLUMNS],
        quality=valid.frame[[name for name in MEASURED if name in valid.frame]],
        places=pd.DataFrame({"file": valid.frame["file"].map(dict(enumerate(names))), "line": valid.frame["line"]}),
        participants=participants,
        sources=tuple(_sources(files, valid, names, notes)),
        rejected=tuple(sorted(rejected, key=lambda row: (row.file, row.row))),
        dropped=dict(dropped),
        left_out=dict(left_out),
        synonyms=valid.synonyms,
        repeats=known.mapping.repeats,
        simulated=any(part.parsed.simulated for part in parts),
        warnings=tuple(dict.fromkeys(warnings)),
    )


def _together(parts: Sequence[_Parsed]) -> pd.DataFrame:
    frames, first = [], 0
    for part in parts:
        frames.append(part.parsed.answers.assign(file=part.parsed.answers["file"] + first))
        first += len(part.files)
    filled = [frame for frame in frames if len(frame)]
    return pd.concat(filled, ignore_index=True) if filled else no_answers()


def _labels(answers: pd.DataFrame, together: pd.DataFrame, known: Known) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the labels of videos, and those of all answers."""
    offers_none = known.labels.offers_none or bool((answers["perceived"] == NONE).any())
    stood_for = {*known.codes.values()} or {known.emotion(str(video)) or "" for video in together["video"].unique()}
    signalled = tuple(label for label in known.labels.signalled if label in stood_for)
    others = [label for label in known.labels.signalled if label not in stood_for]
    return signalled, (*signalled, *others, *([NONE] if offers_none else []))


def _sources(
    files: Sequence[_File], valid: ValidAnswers, names: Sequence[str], notes: Mapping[str, str]
) -> Iterator[Source]:
    kept = valid.frame.groupby("file")["participant"].nunique()
    for file in files:
        name = file.table.file
        yield Source(name, file.dialect.name, file.sha256, int(kept.get(names.index(name), 0)), notes[name])


def _apart(part: _Parsed, known: Known) -> _Parsed:
    """Return the content of files; participants that are numbers of rows get the name of their file as well."""
    parsed = part.parsed
    if not parsed.numbered:
        return part
    labels = [f"{known.file_names[name]}:" for name in part.files]
    if len(labels) == 1:
        participants = parsed.participants.rename(index=lambda name: labels[0] + name)
    else:
        participants = parsed.participants  # numbers differ between the rows of joined files
        labels = [""] * len(labels)
    prefix = parsed.answers["file"].map(dict(enumerate(labels))).astype("str")
    answers = parsed.answers.assign(participant=prefix + parsed.answers["participant"])
    return replace(part, parsed=replace(parsed, answers=answers, participants=participants))


def _participants(
    answers: pd.DataFrame, parts: Sequence[_Parsed], together: pd.DataFrame, dropped: Counter[str]
) -> pd.DataFrame:
    """Return the groups of each participant who has an answer; the others are counted as dropped."""
    people = pd.Index(answers["participant"].unique(), name="participant", dtype="str")
    given = together["participant"]
    without = given[given != ""].nunique() - len(people)
    if without:
        dropped["no usable answer"] += without
    frame = pd.DataFrame(index=people)
    for part in parts:
        for name in part.parsed.participants.columns:
            column = part.parsed.participants[name].reindex(people).fillna("").astype("str")
            frame[name] = frame[name].where(frame[name] != "", column) if name in frame else column
    return frame


def grouped(rejected: Sequence[Rejected]) -> list[str]:
    """Return one line for each reason and value: "20 rows: 'curious' unknown video; ...", the most frequent first.

    Rare values of a reason with many share a line. A file that was skipped has a line of its own.
    """
    values: dict[str, Counter[str]] = {}
    for row in rejected:
        if row.row:
            values.setdefault(row.reason, Counter())[row.value if row.cell else ""] += 1
    counts: Counter[str] = Counter()
    for reason, found in values.items():
        rare = [value for i, (value, n) in enumerate(found.most_common()) if n == 1 or i >= _MOST_VALUES]
        if len(rare) > _MOST_VALUES:
            rest = sum(found.pop(value) for value in rare)
            counts[f"{quoted(rare[0])} and {len(rare) - 1} other values {reason}"] = rest
        counts.update({f"{quoted(value)} {reason}" if value else reason: n for value, n in found.items()})
    lines = [f"{count} row{'s' if count > 1 else ''}: {line}" for line, count in counts.most_common()]
    return lines + [f"{row.file}: {row.reason}" for row in rejected if not row.row]


def _check_rejected(rejected: Sequence[Rejected], total: int, most: float) -> None:
    """Raise SourceError if more than a share of the rows cannot be used; missing answers and repeats are usable."""
    faults = [row for row in rejected if row.reason != NO_ANSWER and not row.reason.startswith(TWICE)]
    usable = total - (len(rejected) - len(faults))
    if len(faults) > most * usable:
        lines = grouped(faults)
        shown = "; ".join(lines[:3]) + (f"; and {len(lines) - 3} more reasons" if len(lines) > 3 else "")
        message = (
            f"{len(faults)} of {usable} answers cannot be used ({shown}); expected at most {100 * most:g} %: correct "
            "the key or the map, or accept more with --max-rejected"
        )
        raise SourceError(faults[0].file, message)


def _check_lost(valid: ValidAnswers, known: Known) -> None:
    """Raise SourceError if a video of the key has no answer, and a video that is not in the key has several."""
    lost = sorted(set(known.codes) - set(valid.frame["video"].unique()))
    unknown = Counter(row.value for row in valid.rejected if row.reason.startswith("unknown video"))
    if lost and unknown and (most := unknown.most_common(1)[0])[1] >= _SEVERAL:
        fault = next(row for row in valid.rejected if row.value == most[0])
        message = (
            f"{most[1]} rows of the unknown video {quoted(most[0])}, and none of {lost[0]}, which is in the key; "
            "expected the codes of the key, or map.yaml: rows: {leave_out: ...}"
        )
        raise SourceError(fault.file, message, fault.row, fault.cell)


def _odd_names(names: "pd.Index[str]") -> list[str]:
    """Return a warning about participants whose ids are words for test runs or for rows of totals."""
    odd = [name for name in names.tolist() if _ODD_NAME.fullmatch(name.casefold())]
    shown = ", ".join(map(quoted, odd[:3])) + (", ..." if len(odd) > 3 else "")
    advice = "leave them out with the map's drop if they are not participants"
    return [f"participants {shown} count: {advice}"] if odd else []


def _other_options(rejected: Sequence[Rejected]) -> list[str]:
    """Return a warning about the most frequent texts that are no labels."""
    texts = Counter(row.value for row in rejected if row.reason.startswith("not a label"))
    shown = ", ".join(f"{quoted(text)} ({count})" for text, count in texts.most_common(3))
    return [f"answers that are no labels: {shown}; if the survey offered them, name all --labels"] if texts else []


def _check_people(valid: ValidAnswers, total: int, most: float) -> None:
    """Raise SourceError if too many participants have no answer that can be used."""
    count = len(valid.unusable)
    if count > most * total:
        fault = next(row for row in valid.rejected if row.reason != NO_ANSWER)
        message = (
            f"no answer of {count} of {total} participants can be used ({quoted(fault.value)}: {fault.reason}, ...); "
            f"expected at most {100 * most:g} %, or more with --max-rejected"
        )
        raise SourceError(fault.file, message, fault.row)


def _nothing_left(file: str, rejected: Sequence[Rejected], dropped: Counter[str]) -> SourceError:
    if dropped.total() and not any(item.row for item in rejected):
        counts = ", ".join(f"{count} {reason}" for reason, count in dropped.items() if count)
        return SourceError(file, f"no participant is left ({counts}); expected answers")
    if not rejected:
        return SourceError(file, "no answers found; expected some")
    first = next((item for item in rejected if item.row), rejected[0])  # a cell is more informative than a skipped file
    given = f"{quoted(first.value)} " if first.value else ""
    others = f" ({len(rejected)} cells or rows rejected)" if len(rejected) > 1 else ""
    return SourceError(first.file, f"{given}{first.reason}{others}; see emovid study columns", first.row, first.cell)


def _check_columns(mapped: ExportMap, files: Sequence[_File]) -> None:
    """Raise SourceError if the map selects participants or rows by columns that no file has."""
    names = [name for file in files for name in (*file.table.names, *file.table.texts)]
    spelled = {plain(name) for name in names}
    paths: list[tuple[tuple[str, ...], str]] = [(("drop", title), title) for title in mapped.drop]
    if not any(file.dialect.name in _WITH_SURVEYS for file in files):
        paths += [(("groups", group), title) for group, title in mapped.groups.items()]
    paths += [(("rows", "keep", title), title) for title in mapped.rows.keep]
    paths += [(("rows", "leave_out", title), title) for title in mapped.rows.leave_out]
    for path, title in paths:
        if plain(title) not in spelled:
            raise unknown_column(mapped, path, title, nearest(title, names))


def _check_groups(known: Known, files: Sequence[_File], found: Sequence[str]) -> None:
    """Raise SourceError if no file has a group that the map names, or a requested one."""
    names = [name for file in files for name in (*file.table.names, *file.table.texts)]
    for name, title in known.mapping.groups.items():
        if name not in found and plain(title) not in map(plain, names):
            raise unknown_column(known.mapping, ("groups", name), title, nearest(title, names))
    for name in known.groups:
        if name not in found:
            message = f"no file has this group{nearest(name, found)}; expected {', '.join(found) or 'a column of it'}"
            raise SourceError("--by", message, 0, name)
