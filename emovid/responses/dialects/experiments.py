"""Experiment software with one row for each trial: how each tool is recognized, its columns, and its marks.

PsychoPy and Pavlovia, OpenSesame, E-Prime, lab.js, Gorilla, Labvanced, PCIbex, pymushra and reVISit.
"""

import re
from collections.abc import Mapping
from dataclasses import replace

import pandas as pd

from emovid.csv_reader import Table, cells_that, translated
from emovid.responses.columns import Format, column
from emovid.responses.dialects.jspsych import without_word
from emovid.responses.dialects.tables import read_long
from emovid.responses.exclusions import TRUE, Marks, is_practice, says
from emovid.responses.parsed_export import Column, Known, ParsedExport
from emovid.responses.participants import PARTICIPANT, groups_of_pairs, joined

_VIDEOS = ("video_code", "video", "videoFile", "video_file", "movieFile", "movie", "stimFile", "stimulus")


# PsychoPy and Pavlovia. One file for each participant; every loop has counters, every response component columns.
_PSYCHOPY_TOOL = ("date", "expName", "expStart", "psychopyVersion", "frameRate", "session", "OS", "notes", "expVersion")
_PSYCHOPY_RESPONSES = (".keys", ".response", ".text", ".clicked_name")


def recognizes_psychopy(table: Table, _: Known) -> bool:
    """Return whether a table has the counter of a loop and PsychoPy's columns about the run."""
    loops = any(name.endswith((".thisN", ".thisTrialN")) for name in table.names)
    return loops and bool({"psychopyVersion", "expName", "frameRate"} & set(table.names))


def read_psychopy(table: Table, known: Known) -> ParsedExport:
    """Read the trials that show a video; trials of loops called practice or the like are left out."""
    table = without_word(table, "None")
    table = _with_buttons(table, known)
    answers = tuple(name for name in table.names if name.endswith(_PSYCHOPY_RESPONSES))
    loops = [name for name in table.names if name.endswith(".thisN")]
    main = [name for name in loops if not is_practice(name.partition(".")[0])]
    table = table.with_column("emovid.order", _order_of_loops(table, main))
    is_tool = lambda name: "." in name or name in _PSYCHOPY_TOOL  # noqa: E731
    form = Format(_VIDEOS, answers, ("emovid.order",), PARTICIPANT, is_tool)
    raw = read_long(table, known, form, _psychopy_marks, by_file=True)
    counters = {name: "order" for name in main if len(main) == 1}
    roles = {name: role for name, role in raw.roles.items() if name != "emovid.order"}
    return replace(raw, roles=roles | counters)


def _with_buttons(table: Table, known: Known) -> Table:
    """Return a table with the names of the Button components that were clicked, if labels name such components."""
    names = {name: name.removesuffix(".numClicks") for name in table.names if name.endswith(".numClicks")}
    buttons = {name: button for name, button in names.items() if known.labels.find(button)}
    if len(buttons) < 2:
        return table
    clicked = pd.Series("", index=table.cells.index, dtype="str")
    for name, button in buttons.items():
        is_clicked = ~table.cells[table.names.index(name)].isin(["", "0", "0.0"])
        clicked = clicked.where(~is_clicked, (clicked + " and " + button).str.removeprefix(" and "))
    return table.with_column("button.clicked_name", clicked)


def _psychopy_marks(table: Table) -> Marks:
    practice = pd.Series(False, index=table.cells.index)
    for place, name in enumerate(table.names):
        loop, _, counter = name.partition(".")
        if counter == "thisN" and is_practice(loop):
            practice |= table.cells[place] != ""
    return Marks(rows={"practice": practice})


def _order_of_loops(table: Table, loops: list[str]) -> Column:
    """Return numbers that order the trials: the counter of the only loop, or the row in the file."""
    filled = [name for name in loops if (table.cells[table.names.index(name)] != "").any()]
    if len(filled) == 1:
        return table.cells[table.names.index(filled[0])]
    in_loop = pd.Series(False, index=table.cells.index)
    for name in filled:
        in_loop |= table.cells[table.names.index(name)] != ""
    return pd.Series(table.lines.astype(str), index=table.cells.index, dtype="str").where(in_loop, "")


# OpenSesame. One file for each participant; every variable of the experiment has a column.
def recognizes_opensesame(table: Table, _: Known) -> bool:
    """Return whether a table has variables that OpenSesame always logs."""
    return {"subject_nr", "subject_parity"} <= set(table.names) or {"subject_nr", "opensesame_version"} <= set(
        table.names
    )


def read_opensesame(table: Table, known: Known) -> ParsedExport:
    """Read the trials that show a video; rows whose `practice` is yes are left out."""
    table = without_word(table, "NA")
    answers = tuple(name for name in table.names if re.fullmatch(r"response(_\w+)?", name) and "time" not in name)
    last = ("response",) if "response" in table.names else answers
    is_tool = lambda name: re.match(_OPENSESAME_TOOL, name) is not None  # noqa: E731
    form = Format(_VIDEOS, last, ("live_row", "count_trial_sequence"), ("subject_nr", *PARTICIPANT), is_tool)
    return read_long(table, known, form, _flagged_practice, by_file=True)


_OPENSESAME_TOOL = (
    r"count_|time_|response|acc(uracy)?$|average_response|avg_rt|correct|datetime|description|experiment_|form_|"
    r"canvas_|compensation|disable|display_|font_|foreground|background|fullscreen|height|width|keyboard_|mouse_|"
    r"live_row|logfile|practice$|opensesame_|psychopy_|repeat_cycle|round_decimals|sampler_|sound_|start|subject_parity|synth_|"
    r"title|total_|transparent|uniform_|color_|clock_|coordinates|bidi|sketchpad|jobs_|pool_|width|cycle"
)


def _flagged_practice(table: Table) -> Marks:
    return Marks(rows={"practice": says(table, TRUE, "practice")})


# E-Prime: text that E-DataAid or E-Merge exports, in UTF-16, perhaps with the path of the data file above the header.
def recognizes_eprime(table: Table, _: Known) -> bool:
    """Return whether a table has E-Prime's columns of the experiment."""
    return {"ExperimentName", "Subject"} <= set(table.names)


def read_eprime(table: Table, known: Known) -> ParsedExport:
    """Read the trials that show a video; procedures called practice or the like are left out."""
    table = without_word(table, "NULL")
    answers = tuple(name for name in table.names if name.endswith(".RESP"))
    order = tuple(
        name for name in table.names if name in ("Trial", "SubTrial", "LogLevel5") or name.endswith(".Sample")
    )
    is_tool = lambda name: "." in name or "[" in name or name in _EPRIME_TOOL  # noqa: E731
    form = Format(("Video", "Movie", "Stimulus", *_VIDEOS), answers, order[:1], ("Subject",), is_tool)
    return read_long(table, known, form, _eprime_marks)


_EPRIME_TOOL = (
    "ExperimentName",
    "Session",
    "Block",
    "Trial",
    "SubTrial",
    "Clock.Information",
    "DataFile.Basename",
    "Procedure",
)


def _eprime_marks(table: Table) -> Marks:
    practice = pd.Series(False, index=table.cells.index)
    for place, name in enumerate(table.names):
        if name.startswith(("Procedure", "Running")):
            practice |= cells_that(table.cells[place], is_practice)
    return Marks(rows={"practice": practice})


# lab.js. One row for each screen and each loop around it.
_LABJS_TOOL = (
    "sender",
    "sender_type",
    "sender_id",
    "meta",
    "ended_on",
    "duration",
    "correct",
    "correctResponse",
    "url",
)


def recognizes_labjs(table: Table, _: Known) -> bool:
    """Return whether a table names the screen of each row."""
    return {"sender", "sender_type"} <= set(table.names)


def read_labjs(table: Table, known: Known) -> ParsedExport:
    """Read the screens that show a video; the rows of loops and sequences, which repeat it, are not screens."""
    form = Format(
        answers=("response",),
        order=("timestamp", "time_run", "sender_id"),
        participants=(*PARTICIPANT, "observation"),
        is_tool=lambda name: name in _LABJS_TOOL or name.startswith("time_"),
    )
    return read_long(table, known, form, pick=_is_screen, by_file=True)


def _is_screen(table: Table, video: int, _: Column) -> Column:
    place = column(table, "sender_type")
    assert place is not None  # it was recognized by this column
    return (table.cells[video] != "") & ~table.cells[place].str.startswith("flow.")


# Gorilla. One row for each screen and zone of a task; task builder 1 and 2 have the same columns of the participant.
def recognizes_gorilla(table: Table, _: Known) -> bool:
    """Return whether a table has Gorilla's columns of the participant."""
    return {"Event Index", "Participant Private ID"} <= set(table.names)


def read_gorilla(table: Table, known: Known) -> ParsedExport:
    """Read the responses to a video; rejected participants, previews, and practice by its display are left out."""
    ids = ("Participant Private ID", "Participant Public ID")
    form = Format((), ("Response",), ("Trial Number",), ids, _is_of_gorilla)
    status = "Participant Status"

    def marks(rows: Table) -> Marks:
        people = {
            "partial": says(rows, ("in progress", "incomplete", "timed out", "time limit", "live", "active"), status),
            "rejected": says(rows, ("rejected", "excluded"), status),
            "preview": says(rows, ("preview",), status),
        }
        return Marks(people)

    return read_long(table, known, form, marks, _answers_of_zones)


_GORILLA_TOOL = frozenset((
    "Event Index", "UTC Timestamp", "UTC Date", "Local Timestamp", "Local Timezone", "Local Date", "Experiment ID",
    "Experiment Version", "Tree Node Key", "Repeat Key", "Schedule ID", "Participant Public ID",
    "Participant Private ID", "Participant Starting Group", "Participant Status", "Participant Completion Code",
    "Participant External Session ID", "Participant Device Type", "Participant Device", "Participant OS",
    "Participant Browser", "Participant Monitor Size", "Participant Viewport Size", "Checkpoint", "Room ID",
    "Room Order", "Task Name", "Task Version", "Spreadsheet", "Spreadsheet Name", "Spreadsheet Row", "Trial Number",
    "Screen Number", "Screen Name", "Zone Name", "Zone Type", "Reaction Time", "Reaction Onset", "Response Type",
    "Response", "Attempt", "Correct", "Incorrect", "Dishonest", "X Coordinate", "Y Coordinate", "Timed Out",
    "display", "randomise_blocks", "randomise_trials", "ShowProgressBar", "Display", "Screen ID", "Screen",
    "Screen Counter", "Absolute Reaction Time", "Tag", "Component Name", "Object Name", "Object Number", "Object ID",
    "Onset Time", "Clock Time", "Question Key", "Randomise Blocks", "Randomise Trials",
))  # fmt: skip
_GORILLA_NODE = re.compile(r"(branch|checkpoint|quota|delay|redirect|switch|repeat|reject)-\w{4}|Store: .*")
# Events that are no answers: of media and buttons (zones of task builder 1), and of screens (task builder 2).
_GORILLA_EVENT = re.compile(r"(?i:(audio|video) (started|finished|stopped|paused|seek.*|play.*)|(begin|end) .*)")
_GORILLA_ZONE = re.compile(r"(content|continue|fixation|timelimit|feedback)_?.*")
_GORILLA_TYPES = ("info", "continue", "action")


def _is_of_gorilla(name: str) -> bool:
    return name in _GORILLA_TOOL or _GORILLA_NODE.fullmatch(name) is not None


def _answers_of_zones(table: Table, video: int, recognized: Column) -> Column:
    place = column(table, "Response")
    if place is None:
        return table.cells[video] != ""
    events = cells_that(table.cells[place], lambda text: not text or _GORILLA_EVENT.fullmatch(text) is not None)
    events |= says(table, _GORILLA_TYPES, "Response Type")
    for name, is_event in (
        ("Zone Type", lambda text: _GORILLA_ZONE.fullmatch(text) is not None),
        ("Question Key", lambda text: text.endswith("-quantised")),  # the number of the answer in another row
    ):
        if name in table.names:
            events |= cells_that(table.cells[table.names.index(name)], is_event)
    return recognized & ~events


# Labvanced. One row for each trial; variables of the study are columns.
def recognizes_labvanced(table: Table, _: Known) -> bool:
    """Return whether a table has Labvanced's columns of the trial."""
    return {"Block_Nr", "Task_Nr", "Trial_Nr"} <= set(table.names)


def read_labvanced(table: Table, known: Known) -> ParsedExport:
    """Read the trials that show a video; blocks called practice or the like are left out."""
    ids = ("Exp_Subject_Id", "Rec_Session_Id", "Crowdsourcing_Code", "Subject_Code")
    is_tool = lambda name: re.match(_LABVANCED_TOOL, name) is not None  # noqa: E731
    form = Format((), (), ("Trial_Nr",), ids, is_tool)
    return read_long(table, known, form, lambda _: Marks(), lambda rows, video, _: rows.cells[video] != "")


_LABVANCED_TOOL = (
    r"(Rec_|Exp_|Group_|Session_|Block_|Task_|Trial_|Condition_|Start_Time|End_Time|Crowdsourcing_|Subject_|Role_Id|Frame_|"
    r"Choose_Role|Selection_|Time_)"
)


# pymushra, the server of webMUSHRA. One row for each answer.
def recognizes_pymushra(table: Table, _: Known) -> bool:
    """Return whether a table has the column of rated stimuli."""
    return "responses_stimulus" in table.names


def read_pymushra(table: Table, known: Known) -> ParsedExport:
    """Read one row for each answer; answers to the questionnaire are groups."""
    names = tuple(name.removeprefix("questionnaire_") for name in table.names)
    ids = tuple(name for name in names if re.search(r"uuid$|session_id$|participant", name))
    form = Format(
        ("responses_stimulus",),
        tuple(name for name in names if name.startswith("responses_")),
        ("trial_position", "position"),
        (*ids, *PARTICIPANT),
        lambda name: name.startswith(("responses_", "trial_", "wm_", "config", "errors")),
    )
    return read_long(replace(table, names=names, texts=names), known, form, by_file=True)


# reVISit: the tidy export. One row for each response, demographics among them.
_REVISIT_TOOL = ("status", "rejectReason", "rejectTime", "configHash", "responseId", "trialId", "trialOrder", "answer")


def recognizes_revisit(table: Table, _: Known) -> bool:
    """Return whether a table names participant, trial and response as reVISit does."""
    return {"participantId", "trialId", "responseId", "answer"} <= set(table.names)


def read_revisit(table: Table, known: Known) -> ParsedExport:
    """Read the responses to a video; those to other trials are groups. Unfinished and rejected runs are left out."""
    stated = {} if known.codes else _stated_by_revisit(table, known)
    known = replace(known, codes=known.codes or stated)
    form = Format(
        ("trialId", "componentName", "stimulus"),
        ("answer",),
        ("trialOrder",),
        ("participantId",),
        _REVISIT_TOOL.__contains__,
    )

    def marks(rows: Table) -> Marks:
        unfinished = ("in progress", "inprogress", "incomplete", "partial")
        return Marks({"rejected": says(rows, ("rejected",), "status"), "partial": says(rows, unfinished, "status")})

    raw = read_long(table, known, form, marks, lambda rows, _, recognized: _asks_for_label(rows, known, recognized))
    groups = joined(raw.participants, groups_of_pairs(_revisit_answers(table, known)))
    return replace(raw, participants=groups, codes=stated)


def _stated_by_revisit(table: Table, known: Known) -> Mapping[str, str]:
    """Return the emotion of each trial from `correctAnswer`; none if a trial has two."""
    place = column(table, "correctAnswer")
    if place is None:
        return {}
    trials = table.cells[table.names.index("trialId")]
    pairs = pd.DataFrame(
        {"trial": trials, "truth": translated(table.cells[place], lambda cell: known.labels.find(cell) or "")}
    )
    pairs = pairs[pairs["truth"] != ""].drop_duplicates()
    return {} if pairs["trial"].duplicated().any() else {known.code(t): e for t, e in pairs.to_numpy().tolist()}


def _asks_for_label(table: Table, known: Known, recognized: Column) -> Column:
    """Return the rows of those responses to a video that ask for a label and not, say, for a confidence."""
    names, cells = (table.cells[table.names.index(name)] for name in ("responseId", "answer"))
    labels = cells_that(cells, known.labels.is_label)
    labelled = names[recognized & labels].unique()
    return recognized & names.isin(labelled) if len(labelled) else recognized


def _revisit_answers(table: Table, known: Known) -> list[tuple[str, str, str]]:
    columns = [table.cells[table.names.index(name)] for name in ("participantId", "responseId", "answer", "trialId")]
    titles = {title: name for name, title in known.mapping.groups.items()}
    return [
        (person, titles.get(name, name), value)
        for person, name, value, trial in zip(*columns, strict=True)
        if known.emotion(trial) is None
    ]
