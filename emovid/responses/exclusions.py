"""Participants and rows that are left out: marks that tools write, words for practice, and the map's `drop` and `rows`.

A mark of a participant (preview, test run, unfinished) leaves out all of the participant's rows. A mark of a row
(practice, instructions, attention check) leaves out this row only.
"""

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from emovid.csv_reader import Table, cells_that
from emovid.errors import SourceError, quoted
from emovid.responses.columns import column
from emovid.responses.labels import number, plain
from emovid.responses.parsed_export import Column, Known, numeric

Mask = NDArray[np.bool_]

TRUE = (
    "true", "t", "1", "yes", "wahr", "ja", "vrai", "oui", "verdadero", "sí", "si", "vero", "waar", "verdadeiro", "sim",
    "prawda", "tak", "истина", "да", "sant", "sann", "tosi", "是", "真", "참", "예", "doğru", "evet",
)  # fmt: skip
FALSE = (
    "false", "f", "0", "no", "falsch", "nein", "faux", "non", "falso", "não", "onwaar", "nee", "fałsz", "nie", "ложь",
    "нет", "falskt", "nej", "usann", "nei", "epätosi", "否", "偽", "假", "거짓", "yanlış", "hayır",
)  # fmt: skip
_PEOPLE = {
    "test run": ("test", "debug", "pretest", "tester", "testlauf", "probelauf", "test run", "testing"),
    "pilot": ("pilot",),
    "preview": ("preview", "survey preview", "vorschau"),
    "partial": (
        "partial", "incomplete", "abandoned", "in progress", "started", "returned", "timed out", "unfinished",
        "aborted", "unvollständig", "abgebrochen", "incomplet", "incompleto", "incompleta", "onvolledig",
    ),
    "rejected": ("rejected", "consent revoked", "data expired", "withdrawn", "screened out", "excluded", "abgelehnt"),
    "bot": ("bot",),
}  # fmt: skip
# Names of columns that say whether a row counts, and the values with which it does not.
_FAILED = ("failed", "fail", "not passed", "nicht bestanden", "échoué", "fallido")
_COUNTS = {
    "excluded": (r"(is )?(exclude|excluded|deleted|discard|discarded|invalid|ausgeschlossen)", TRUE),
    "not valid": (r"(is )?(valid|include|included|gültig)", (*FALSE, "invalid", "ungültig")),
    "no consent": (r"(informed )?(consent|consented|einwilligung|consentement|consentimiento)", FALSE),
    "failed check": (r"(attention|manipulation|bot) ?checks?( passed)?", _FAILED),
}
_PRACTICE = (
    r"(practi[cs]e|prac\b|training|train\b|warm ?up|tutorial|demo\b|demonstration|example|instruction|"
    r"familiari[sz]ation|übung|uebung|probe(durchgang|lauf|block|trial|phase)|beispiel|einweisung|aufwärm|anleitung|"
    r"entra[iî]nement|pratique|exemple|familiarisation|pr[aá]ctica|entrenamiento|ejemplo|instrucci|esempio|"
    r"allenamento|addestramento|istruzion|pr[aá]tica|treino|exemplo|instruç|oefen|voorbeeld|instructie|ćwicze|trening|"
    r"przykład|instrukcj|övning|øvelse|øving|harjoit|esimerkki|alıştırma|örnek|трениров|практика|пример|инструкц|"
    r"gyakorl|cvič|εξάσκηση|練習|れんしゅう|教示|例題|练习|練習|训练|示例|指导语|연습|예시|تدريب|אימון)"
)
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")  # between the words of isPractice
_PRACTICE_WORD = re.compile(rf"(\b|(?<=[^\x00-\u2e7f])){_PRACTICE}")
_NO_PRACTICE = re.compile(r"\b(no|non|not|without|after|post|main|real|experimental)\b")
_CHECK_WORD = re.compile(r"\b(attention|catch( trials?)?$|catch trial|bot ?check|instructed response|imc\b)")
# Words in names of columns that state the part of a study of a row.
_PARTS = frozenset((
    "phase", "block", "section", "stage", "part", "task", "type", "condition", "procedure", "screen", "display",
    "loop", "trialtype", "blocktype", "blockname", "taskname", "practice", "training", "kind", "session", "list",
    "trialname", "component", "running", "trialkind", "routine", "teil", "abschnitt", "durchgang", "bedingung",
    "aufgabe", "typ", "fase", "bloc", "bloque", "blocco", "bloco", "blok", "tâche", "partie", "étape", "condición",
    "tarea", "tipo", "etapa", "taak", "deel", "etap", "część", "vaihe", "lohko", "блок", "фаза", "этап", "часть",
    "aşama", "bölüm", "フェーズ", "ブロック", "課題", "条件", "段階", "阶段", "区块", "階段", "组块", "블록", "단계",
))  # fmt: skip
_FLAGS = {
    "practice": re.compile(rf"(is )?{_PRACTICE}( trial| run| block)?"),
    "attention check": re.compile(r"(is )?(attention check|catch|catch trial|bot check)"),
}


@dataclass(frozen=True)
class Marks:
    """Marks that a survey tool gives its rows.

    Attributes:
        people: rows whose participants are left out, by reason.
        rows: rows that are left out, by reason.
    """

    people: Mapping[str, Column] = field(default_factory=dict)
    rows: Mapping[str, Column] = field(default_factory=dict)


NO_MARKS = Marks()


def says(table: Table, words: Collection[str], *names: str) -> Column:
    """Return the rows (True) in which the first of these columns has one of the words; none without the column."""
    place = column(table, *names)
    if place is None:
        return pd.Series(False, index=table.cells.index)
    return cells_that(table.cells[place], partial(_is_one_of, words))


def below(table: Table, bound: float, *names: str) -> Column:
    """Return the rows (True) in which the first of these columns has a number below a bound."""
    place = column(table, *names)
    if place is None:
        return pd.Series(False, index=table.cells.index)
    return numeric(table.cells[place]) < bound


def marks_of_people(table: Table, known: Known, marks: Marks) -> dict[str, Mask]:
    """Return the rows whose participants are left out, by reason: the tool's, and words in `status` and `mode`."""
    masks = {reason: says(table, words, "status") | says(table, words, "mode") for reason, words in _PEOPLE.items()}
    masks["test run"] |= says(table, TRUE, "is_test")
    masks["bot"] |= says(table, TRUE, "is_bot")
    for reason, mask in marks.people.items():
        masks[reason] = masks[reason] | mask if reason in masks else mask
    if known.include_pilots:
        del masks["pilot"]
    return {reason: np.asarray(mask, dtype=bool) for reason, mask in masks.items()}


def without_rows(
    table: Table, known: Known, people: Column | None, marks: Marks, used: Collection[int | None] = ()
) -> tuple[NDArray[np.bool_], dict[str, int]]:
    """Return the rows (True) to keep, and the number of rows left out, by reason.

    Args:
        table: the file.
        known: whose map can keep or leave out rows by the values of columns; these columns are not searched for words.
        people: participant of each row, None if unknown.
        marks: rows that the tool marks.
        used: columns of videos and answers, which are not searched for words.
    """
    masks = dict(_rows_of_map(table, known))
    selected = {column(table, title) for title in (*known.mapping.rows.keep, *known.mapping.rows.leave_out)}
    masks |= {reason: np.asarray(mask, dtype=bool) for reason, mask in marks.rows.items()}
    codes = np.zeros(len(table.lines), dtype=np.int64) if people is None else pd.factorize(people)[0]
    for place in range(len(table.names)):
        if place not in selected:
            parts = () if place in used else _parts(table, place, codes)
            for reason, mask in (*_uncounted(table, place), *parts):
                masks[reason] = masks[reason] | mask if reason in masks else mask
    kept = np.ones(len(table.lines), dtype=bool)
    counts: dict[str, int] = {}
    for reason, mask in masks.items():
        if (mask & kept).any():
            counts[reason] = int((mask & kept).sum())
        kept &= ~mask
    return kept, counts


def _rows_of_map(table: Table, known: Known) -> Iterator[tuple[str, Mask]]:
    for title, values in known.mapping.rows.leave_out.items():
        if (place := column(table, title)) is not None:
            for value in values:
                yield f"{title} = {value}", _has(table.cells[place], (value,))
    for title, values in known.mapping.rows.keep.items():
        if (place := column(table, title)) is not None:
            yield f"{title} other than {', '.join(values)}", ~_has(table.cells[place], values)


def _has(cells: Column, values: Collection[str]) -> Mask:
    wanted = {number(value).casefold() for value in values}
    return cells_that(cells, lambda cell: number(cell).casefold() in wanted).to_numpy()


def _uncounted(table: Table, place: int) -> Iterator[tuple[str, Mask]]:
    """Yield the rows that do not count by a column such as `excluded` or `valid`."""
    name = plain(table.names[place])
    for reason, (pattern, words) in _COUNTS.items():
        if re.fullmatch(pattern, name):
            yield reason, cells_that(table.cells[place], partial(_is_one_of, words)).to_numpy()


def _is_one_of(words: Collection[str], text: str) -> bool:
    return plain(number(text)) in words


def _parts(table: Table, place: int, people: NDArray[np.int64]) -> Iterator[tuple[str, Mask]]:
    """Yield the rows of practice and of attention checks marked by a column.

    A column counts only if participants with such rows have other rows, too: training as an experimental condition, or
    as a question about participants, does not vary within them.
    """
    name, cells = plain(_CAMEL.sub(" ", table.names[place])), table.cells[place]
    for reason, pattern in _FLAGS.items():
        if pattern.fullmatch(name):
            mask = cells_that(cells, partial(_is_one_of, TRUE)).to_numpy()
            if mask.any() and _varies(mask, people):
                yield reason, mask
    if not set(name.split()) & _PARTS:
        return
    for reason, is_marked in (("attention check", _is_check), ("practice", is_practice)):
        mask = cells_that(cells, is_marked).to_numpy()
        if mask.any() and _varies(mask, people):
            yield reason, mask


def is_practice(text: str) -> bool:
    """Return whether the name of a loop, block or the like means practice, an example or an instruction."""
    words = plain(_CAMEL.sub(" ", text))
    return bool(_PRACTICE_WORD.search(words)) and not _NO_PRACTICE.search(words)


def _is_check(text: str) -> bool:
    return bool(_CHECK_WORD.search(plain(text)))


def _varies(mask: Mask, people: NDArray[np.int64]) -> bool:
    """Return whether most participants with rows in a mask have other rows, too."""
    marked = np.unique(people[mask])
    return bool(np.isin(marked, people[~mask]).mean() > 0.5) if len(marked) else False


def dropped_by_map(table: Table, known: Known, people: Column) -> dict[str, Mask]:
    """Return the rows of participants whom the map leaves out, by reason.

    Raises:
        SourceError: if a value differs between the rows of a participant.
    """
    masks: dict[str, Mask] = {}
    for title, values in known.mapping.drop.items():
        place = column(table, title)
        if place is None:
            continue
        for value in values:
            mask = _has(table.cells[place], (value,))
            given = pd.Series(mask).groupby(pd.factorize(people)[0]).agg(["any", "all"])
            if (given["any"] & ~given["all"]).any() and mask.sum() > 0:
                message = (
                    f"{quoted(value)} is in some rows of a participant only, and drop leaves out participants; "
                    f"expected rows: {{leave_out: {{{title}: [{value}]}}}}"
                )
                raise SourceError(known.mapping.place("drop", title), message, 0, f"drop.{title}")
            masks[f"{title} = {value}"] = mask
    return masks
