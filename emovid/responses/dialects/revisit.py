"""reVISit's tidy export: a row for each response, demographics among them."""

from dataclasses import replace

from emovid.csv_reader import Table
from emovid.responses.dialects.columns import says
from emovid.responses.dialects.generic import stated_codes
from emovid.responses.dialects.parsed_export import Column, Known, Raw
from emovid.responses.dialects.people import groups_of_pairs, joined
from emovid.responses.dialects.trials import read_trials

_TOOL = ("status", "rejectReason", "rejectTime", "configHash", "responseId", "trialId", "trialOrder", "answer")


def recognises(table: Table, _: Known) -> bool:
    """Return whether a table names participant, trial and response as the tool does."""
    return {"participantId", "trialId", "responseId", "answer"} <= set(table.names)


def read(table: Table, known: Known) -> Raw:
    """Read the responses to a video; those to other trials are groups. Unfinished and rejected runs are left out."""
    stated = {} if known.codes else stated_codes(table, known, table.names.index("trialId"))
    known = replace(known, codes=known.codes or stated)
    reasons = {"rejected": says(table, ("rejected",), "status"), "partial": says(table, _UNFINISHED, "status")}
    raw = read_trials(
        table,
        known,
        lambda rows, _, recognised: _answers(rows, known, recognised),
        ("trialId", "componentName", "stimulus"),
        ("answer",),
        ("trialOrder",),
        ("participantId",),
        reasons,
        _TOOL.__contains__,
    )
    groups = joined(raw.participants, groups_of_pairs(_asked(table, known)))
    return replace(raw, participants=groups, codes=stated)


_UNFINISHED = ("in progress", "inprogress", "incomplete", "partial")


def _answers(table: Table, known: Known, recognised: Column) -> Column:
    """Return the rows of those responses to a video that ask for a label: not, say, for a confidence."""
    names, cells = (table.cells[table.names.index(name)] for name in ("responseId", "answer"))
    meant = cells.isin([word for word in cells.unique() if known.labels.is_label(word)])
    labelled = names[recognised & meant].unique()
    return recognised & names.isin(labelled) if len(labelled) else recognised


def _asked(table: Table, known: Known) -> list[tuple[str, str, str]]:
    columns = [table.cells[table.names.index(name)] for name in ("participantId", "responseId", "answer", "trialId")]
    titles = {title: name for name, title in known.mapping.groups.items()}
    return [
        (person, titles.get(name, name), value)
        for person, name, value, trial in zip(*columns, strict=True)
        if known.emotion(trial) is None
    ]
