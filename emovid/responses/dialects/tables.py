"""The two layouts of answers, for every tool: one row for each answer (long), or one column for each video (wide)."""

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from emovid.csv_reader import Rejected, Table, cells_that, coded, translated
from emovid.errors import SourceError, quoted
from emovid.responses.columns import (
    POSITION,
    Format,
    Layout,
    check_named,
    column,
    holds_answers,
    is_counted,
    layout,
    named,
    share,
    texts_of,
    video_column,
)
from emovid.responses.exclusions import NO_MARKS, Marks, marks_of_people, says, without_rows
from emovid.responses.key import code_of
from emovid.responses.labels import number, plain
from emovid.responses.parsed_export import (
    ANSWER_TO,
    Column,
    Known,
    ParsedExport,
    answers_long,
    answers_wide,
    no_answers,
    places_in_order,
    ranks,
    whole_numbers,
)
from emovid.responses.participants import PARTICIPANT, People, groups_of, who, who_answered, without
from emovid.responses.quality import LEFT_OUT, SPEEDER, STRAIGHTLINER, measured
from emovid.responses.responses import FAILED_CHECK, RECORDED, SMOOTH, SURVEY_COLUMNS, UNSUBMITTED

# Words in names of columns that accompany an answer.
_BESIDE = re.compile(
    r"\b(time|timing|times|rt|duration|clicks?|plays?|watched|submit|page|comments?|other|correct|confidence|valence|"
    r"arousal|position|order|rank|seconds|changed?|do|started|answered|at|text)\b|time$"
)
_PLACE = re.compile(r"\b(position|order|rank)\b")
_MOST_REPEATED = 0.05  # of the rows: largest share of repeats that is not refused here
_MOST_QUESTIONS = 6  # about one video
Pick = Callable[[Table, int, Column], Column]  # rows that show a video, given the column and the rows of known videos


def recognizes_survey(table: Table, known: Known) -> bool:
    """Return whether a table is the export of our own survey."""
    return set(SURVEY_COLUMNS) <= set(table.names) and table.names[0] == SURVEY_COLUMNS[0] and not is_mapped_wide(known)


def read_survey(table: Table, known: Known) -> ParsedExport:
    """Read the export of our own survey; list the participants and answers that the study's rules leave out.

    Raises:
        SourceError: without a key, unless the names of the videos or a map tell the true emotions.
    """
    table = _without_truth(table, known)
    form = Format(answers=("response",), participants=SURVEY_COLUMNS[:1], is_tool=RECORDED.__contains__)
    parsed = read_long(table, known, form, _survey_marks)
    return replace(parsed, excluded=tuple(_excluded_by_survey(table, known)))


def _without_truth(table: Table, known: Known) -> Table:
    """Return a table of our own survey, none of whose columns can look like that of the true emotions."""
    videos = table.cells[table.names.index("video")]
    shown = [video for video in videos.unique() if video]
    if shown and not (known.codes or known.mapping.truth or any(known.emotion(video) for video in shown)):
        message = "the survey's answers do not contain the true emotions; expected --key kit/private/key.csv"
        raise SourceError(table.file, message, 1)
    named = (*known.mapping.response, known.mapping.truth)
    if "first_response" not in table.names or "first_response" in named:
        return table
    return table.replaced(table.names.index("first_response"), pd.Series("", index=table.cells.index, dtype="str"))


def _survey_marks(table: Table) -> Marks:
    place = column(table, "playback")
    stalled = pd.Series(False, index=table.cells.index) if place is None else ~table.cells[place].isin(("", SMOOTH))
    reasons = (FAILED_CHECK, SPEEDER, STRAIGHTLINER)
    people = {reason: says(table, (reason,), "status") for reason in reasons}
    people["partial"] = says(table, (UNSUBMITTED,), "status")
    return Marks(people, {"playback": stalled})


def _excluded_by_survey(table: Table, known: Known) -> Iterator[Rejected]:
    """Yield the first row of each participant who is left out, and each answer that is left out."""
    marks = _survey_marks(table)
    ids = table.cells[table.names.index(SURVEY_COLUMNS[0])]
    told: set[str] = set()
    for reason, mask in marks_of_people(table, known, marks).items():
        for row, name in ids[mask].drop_duplicates().items():
            if name not in told:
                yield _row_left_out(table, int(str(row)), SURVEY_COLUMNS[0], str(name), reason)
            told.add(str(name))
    for reason, mask in marks.rows.items():
        for row, name in ids[mask & ~ids.isin(told)].items():
            yield _row_left_out(table, int(str(row)), SURVEY_COLUMNS[0], str(name), reason)


def _row_left_out(table: Table, row: int, cell: str, value: str, reason: str) -> Rejected:
    file = table.file if table.origins is None else table.files[table.origins[row]]
    return Rejected(file, int(table.lines[row]), cell, value, f"{LEFT_OUT}{reason}")


def recognizes_long(table: Table, known: Known) -> bool:
    """Return whether a table has a row for each answer: it has a column of videos, and no columns of single videos."""
    if is_mapped_wide(known):
        return False
    return video_column(table, known) is not None and (
        bool(known.mapping.video) or not _has_video_columns(table, known)
    )


def _has_video_columns(table: Table, known: Known) -> bool:
    """Return whether several columns of answers name a video in their header."""
    places = [place for place in range(len(table.names)) if _code_in_header(table, place, known)]
    return sum(holds_answers(table, place, known) for place in places) > 1


def recognizes_wide(table: Table, known: Known) -> bool:
    """Return whether a table has a column for each video."""
    return bool(video_columns(table, known))


def read_generic_long(table: Table, known: Known) -> ParsedExport:
    """Read a table of no particular tool with one row for each answer."""
    return read_long(table, known, Format())


def read_long(
    table: Table,
    known: Known,
    form: Format,
    marks: Callable[[Table], Marks] = lambda _: NO_MARKS,
    pick: Pick | None = None,
    by_file: bool = False,
) -> ParsedExport:
    """Read a table with one row for each answer or trial, of which some show a video.

    Args:
        table: the file.
        known: facts known besides.
        form: columns that the tool defines.
        marks: participants and rows that the tool marks.
        pick: rows (True) that show a video; by default all rows with a video.
        by_file: whether a file without a column of participants belongs to one of them.
    """
    check_named(table, known)
    simulated = bool(says(table, ("simulated",), "mode").any())
    video = _needed_video(table, known, form)
    ids = form.participants or PARTICIPANT
    people = who(table, known, *ids, by_file=by_file)
    found = None if people.numbered else people.ids
    kept, left_out = without_rows(table, known, found, marks(table), (video,))
    table, people = table.rows(kept), replace(people, ids=people.ids[kept].reset_index(drop=True))
    table, people = without(table, known, people, marks_of_people(table, known, marks(table)))
    if not len(table.lines):
        return ParsedExport(no_answers(), groups_of(table, known, people.ids), table.rejected, people.dropped, left_out)
    video, recognized = _needed_video(table, known, form), _recognized(table, known, video)
    rows = (pick(table, video, recognized) if pick else table.cells[video] != "").to_numpy(dtype=bool)
    if not (pick or form.videos):  # a row of no tool must have a video, or else is rejected
        rows = np.ones(len(table.lines), dtype=bool)
    roles = layout(table.rows(rows), known, video, form, people.place)
    rows = rows & (table.cells[[video, *roles.answers]] != "").any(axis=1).to_numpy()
    shown = table.rows(rows)
    if not form.participants and not by_file:
        codes = codes_of_rows(table, known, video)
        people = _with(people, who_answered(table, known, codes, {video, *roles.answers, *roles.truth}))
    _check_questions(shown, known, people.ids[rows].reset_index(drop=True), video, {*roles.answers, people.place})
    order, position = _positions(shown, known, form, people.ids[rows].reset_index(drop=True), video)
    answers = answers_long(
        shown, people.ids[rows].reset_index(drop=True), video, texts_of(shown, roles.answers), position
    ).assign(**measured(shown))
    return ParsedExport(
        answers,
        _groups(table, known, people, roles, form, order),
        table.rejected,
        people.dropped,
        left_out,
        *_described(table, roles, people, order),
        people.numbered,
        dict(roles.codes),
        people.note,
        roles.warnings,
        simulated,
    )


def _check_questions(table: Table, known: Known, ids: Column, video: int, used: Collection[int | None]) -> None:
    """Raise SourceError if a video has several answers of each participant, to the questions that a column names."""
    rows = pd.DataFrame({"person": ids, "video": codes_of_rows(table, known, video)})
    if known.mapping.repeats or rows.duplicated().mean() <= _MOST_REPEATED:
        return
    for place, name in enumerate(table.names):
        questions = coded(table.cells[place])[1]
        if place in (video, *used) or is_counted(name) or not 1 < len(questions) <= _MOST_QUESTIONS:
            continue
        if not rows.assign(question=table.cells[place]).duplicated().any():
            count = int(rows.duplicated().sum())
            message = (
                f"{count} of {len(rows)} answers repeat a participant's answer to a video, and differ in "
                f"{quoted(name)} ({', '.join(map(quoted, questions[:3]))}); expected map.yaml: rows: {{keep: {{{name}: "
                f"[{questions[0]}]}}}}, or repeats: first, last or all if they answer one question"
            )
            raise SourceError(table.file, message, 1)


def _needed_video(table: Table, known: Known, form: Format) -> int:
    video = video_column(table, known, form)
    if video is None:
        raise SourceError(table.file, "no column of videos; expected one with the key's codes", 1)
    return video


def _recognized(table: Table, known: Known, video: int) -> Column:
    return cells_that(table.cells[video], lambda text: bool(known.emotion(text)))


def codes_of_rows(table: Table, known: Known, video: int) -> Column:
    """Return the code of the video of each row, "" where there is none."""
    return translated(table.cells[video], lambda text: known.code(text) if text else "")


def _with(before: People, found: People) -> People:
    return replace(found, dropped=before.dropped)


def _positions(table: Table, known: Known, form: Format, ids: Column, video: int) -> tuple[int | None, Column | None]:
    """Return the column that counts the answers, and the position of each."""
    place = column(table, *(form.order or POSITION))
    if place is None:
        return None, None
    if form.order:
        return place, ranks(ids, table.cells[place])
    codes = codes_of_rows(table, known, video)
    return place, places_in_order(ids, codes, whole_numbers(table.cells[place]))


def _groups(table: Table, known: Known, people: People, roles: Layout, form: Format, order: int | None) -> pd.DataFrame:
    tools = {place for place, name in enumerate(table.names) if form.is_tool(name)}
    used = {roles.video, *roles.answers, *roles.truth, people.place, order, *tools}
    return groups_of(table, known, people.ids, used)


def _described(table: Table, roles: Layout, people: People, order: int | None) -> tuple[dict[str, str], dict[str, str]]:
    """Return the role of each column, and the evidence for it."""
    found: list[tuple[int | None, str]] = [(place, "true emotion") for place in roles.truth]
    found += [(place, "answer") for place in roles.answers]
    found += [(roles.video, "video"), (order, "order"), (people.place, "participant")]
    names = {table.names[place]: role for place, role in found if place is not None}
    return names, {table.names[place]: why for place, why in roles.evidence.items()}


def read_wide(table: Table, known: Known, *ids: str, marks: Marks = NO_MARKS, skip: Sequence[str] = ()) -> ParsedExport:
    """Read a table with one column for each video.

    Args:
        table: the file.
        known: facts known besides.
        ids: columns that can name the participant; otherwise the usual ones.
        marks: participants and rows that the tool marks.
        skip: columns of the tool that hold neither answers nor groups.
    """
    if known.mapping.video:  # a form that was sent once for each video
        form = Format(is_tool={plain(name) for name in skip}.__contains__)
        return read_long(table, known, form, lambda _: NO_MARKS)
    people = who(table, known, *(ids or PARTICIPANT))
    kept, left_out = without_rows(table, known, None, marks, range(len(table.names)))
    table, people = table.rows(kept), replace(people, ids=people.ids[kept].reset_index(drop=True))
    masks = {reason: np.asarray(mask)[kept] for reason, mask in marks.people.items()}
    table, people = without(table, known, people, marks_of_people(table, known, Marks(masks)))
    tools = {place for place, name in enumerate(table.names) if plain(name) in {plain(title) for title in skip}}
    videos = video_columns(table, known, [people.place, *tools])
    if not videos:
        raise SourceError(
            table.file,
            no_videos(table, known)
            or "no column names a video; expected map.yaml: videos: the code of each column of answers",
            1,
        )
    _check_not_truth(table, known, videos)
    used = {*tools, *about_videos(table, known)}
    roles = {place: f"{ANSWER_TO}{code}" for place, code in videos.items()} | {people.place: "participant"}
    return ParsedExport(
        answers_wide(table, people.ids, videos, positions(table, known)),
        groups_of(table, known, people.ids, {*roles, *used}),
        table.rejected,
        people.dropped,
        left_out,
        {table.names[i]: role for i, role in roles.items() if i is not None},
        dict.fromkeys((table.names[i] for i in videos), "named by the map" if is_mapped_wide(known) else "its header"),
        people.numbered,
        simulated=bool(says(table, ("simulated",), "mode").any()),
    )


def is_mapped_wide(known: Known) -> bool:
    """Return whether map.yaml names the columns of videos."""
    return bool(known.mapping.videos)


def video_columns(table: Table, known: Known, skip: Sequence[int | None] = ()) -> dict[int, str]:
    """Return the column with the answers to each video, and its code; none if no header names a video.

    Raises:
        SourceError: if the map's columns do not exist, or several columns can hold the answers to one video.
    """
    if known.mapping.codes_of_columns:
        return {named(table, title, "videos"): code for title, code in known.mapping.codes_of_columns.items()}
    if known.mapping.codes_in_order:
        _check_fixed_order(table, known, skip)
        return dict(zip(_alike(table, known, skip), known.mapping.codes_in_order, strict=True))
    found: dict[str, list[int]] = {}
    for place in range(len(table.names)):
        code = _code_in_header(table, place, known)
        if code and place not in skip and not _stands_beside(table, place, known):
            found.setdefault(code, []).append(place)
    chosen = {code: _chosen(table, known, code, places) for code, places in found.items()}
    return {place: code for code, place in chosen.items() if place is not None}


def _check_fixed_order(table: Table, known: Known, skip: Sequence[int | None]) -> None:
    """Raise SourceError if a column shows the videos in orders that differ between rows, so that no list fits."""
    for place in range(len(table.names)):
        if place in skip or not known.codes:
            continue
        orders = {
            tuple(code for part in re.split(r"[,|;]", cell) if (code := code_of(part.strip(" \"'[]"))) in known.codes)
            for cell in coded(table.cells[place])[1]
        }
        if len(orders - {()}) > 1:
            message = (
                f"column {quoted(table.names[place])} shows that the videos of a column differ between participants; "
                "expected a column for each video, or a row for each answer"
            )
            raise SourceError(table.file, message, 1, "videos")


def _check_not_truth(table: Table, known: Known, videos: Mapping[int, str]) -> None:
    """Raise SourceError if the columns that were found hold the true emotion of their video in every row."""
    if is_mapped_wide(known) or not known.codes:
        return
    wrong = cells = 0
    for place, code in videos.items():
        labels = translated(table.cells[place], lambda text: known.labels.find(text) or "")
        filled = labels != ""
        wrong += int((labels[filled] != known.codes[code]).sum())
        cells += int(filled.sum())
    if wrong == 0 and cells >= 3 * len(videos):
        names = ", ".join(f"{table.names[place]}: {code}" for place, code in videos.items())
        message = (
            f"the columns of videos agree with the key in all {cells} answers, so they seem to hold the true emotions; "
            f"expected map.yaml: videos: {{{names}}} if all answers are right"
        )
        raise SourceError(table.file, message, 1)


def positions(table: Table, known: Known) -> dict[str, Column]:
    """Return the position of each video from columns such as `z8r4_position`."""
    found: dict[str, Column] = {}
    for place, name in enumerate(table.names):
        code = _code_in_header(table, place, known)
        if code and _PLACE.search(plain(name)) and share(table, place, lambda cell: number(cell).isdecimal()) == 1:
            found[code] = whole_numbers(table.cells[place])
    from_zero = int(any((column == 0).any() for column in found.values()))
    return {code: column + from_zero for code, column in found.items()}


def about_videos(table: Table, known: Known) -> set[int]:
    """Return the columns about a video, such as `z8r4_position`, which describe no participant.

    A code in the header shows it; the name of an emotion alone does not, as in "fear of robots".
    """
    coded = {place: bool(_code_in_header(table, place, known)) for place in range(len(table.names))}
    return {
        place for place, is_coded in coded.items() if is_coded and (known.codes or _stands_beside(table, place, known))
    }


def code_in(text: str, known: Known) -> str:
    """Return the one video code that a text names, or ""."""
    if known.codes:
        code = known.code(text)
        return code if code in known.codes else ""
    found = {label for word in plain(text).split() if (label := known.emotion(word))}
    return found.pop() if len(found) == 1 else ""


def _code_in_header(table: Table, place: int, known: Known) -> str:
    return code_in(table.names[place], known) or code_in(table.texts[place], known)


def _stands_beside(table: Table, place: int, known: Known) -> bool:
    name = plain(table.names[place])
    if not _BESIDE.search(name):
        return False
    is_count = len(name.split()) <= 5 and share(table, place, str.isdigit) == 1  # even if the map has labels for digits
    return is_count or not holds_answers(table, place, known)


def _chosen(table: Table, known: Known, code: str, places: list[int]) -> int | None:
    """Return the one of the columns that name a video which holds its answers."""
    exact = [place for place in places if code_of(table.names[place]) == code]
    holding = [place for place in places if holds_answers(table, place, known)]
    if len(holding) > 1:
        varied = [place for place in holding if not _is_true_emotion(table, known, code, place)]
        holding = varied or holding
    for candidates in (holding, exact, places if known.codes else []):
        if len(candidates) == 1:
            return candidates[0]
        if candidates:
            names = " and ".join(quoted(table.names[place]) for place in candidates[:2])
            message = f"columns {names} both name the video {code}; expected one of them in map.yaml: videos"
            raise SourceError(table.file, message, 1)
    return None


def _is_true_emotion(table: Table, known: Known, code: str, place: int) -> bool:
    """Return whether all cells of a column are the true emotion of a video."""
    texts = coded(table.cells[place])[1]
    return {known.labels.find(text) for text in texts if text} == {known.codes.get(code)}


def _alike(table: Table, known: Known, skip: Sequence[int | None]) -> list[int]:
    """Return the columns that ask one question, as many as the map lists codes."""
    wanted = len(known.mapping.codes_in_order)
    bases: dict[str, list[int]] = {}
    for place, text in enumerate(table.texts):
        if place not in skip and holds_answers(table, place, known):
            bases.setdefault(question(text), []).append(place)
    fitting = [places for places in bases.values() if len(places) == wanted]
    together = [place for places in bases.values() for place in places]
    if len(fitting) != 1 and len(together) != wanted:
        message = f"{len(together)} columns hold answers; the map lists {wanted} codes"
        raise SourceError(table.file, message, 1, "videos")
    return _in_order(table, fitting[0]) if len(fitting) == 1 else sorted(together)


def _in_order(table: Table, places: list[int]) -> list[int]:
    """Return columns by the number after their question, where a tool numbers repeated ones; otherwise as they are."""
    ends = [re.search(r"(\d+)\)?\s*$", table.names[place]) for place in places]
    numbers = [int(end[1]) if end else 0 for end in ends]
    return (
        [place for _, place in sorted(zip(numbers, places, strict=True))]
        if len(set(numbers)) == len(places)
        else places
    )


def no_videos(table: Table, known: Known) -> str:
    """Return the problem of a table in which no column names a video, or "" if no two columns hold answers."""
    holding = [place for place in range(len(table.names)) if holds_answers(table, place, known)]
    if len(holding) < 2:
        return ""
    alone = len({question(table.texts[place]) for place in holding}) == 1
    what = "ask one question" if alone else "hold answers"
    where = "a code of the key" if known.codes else "an emotion"
    first = quoted(table.texts[holding[0]])
    remedy = f"{'' if known.codes else 'a key, or '}map.yaml: videos (or video and response, if each row is one answer)"
    return f"{len(holding)} columns {what} ({first} ...), and none is named by {where}; expected {remedy}"


def question(text: str) -> str:
    """Return a question without the number that a tool adds where it is repeated."""
    return plain(re.sub(r"[\s_.(]*\d+\)?$", "", text))
