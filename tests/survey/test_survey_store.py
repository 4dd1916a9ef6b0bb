import os
import signal
import sqlite3
import stat
import subprocess
import sys

import pytest

from emovid.errors import InputError
from emovid.survey.codes import digest
from emovid.survey.records import Participant, Playback, Screen
from emovid.survey.rules import Play
from emovid.survey.store import Store

ORDERS = {"P001": ("vvv", "www"), "P002": ("www", "vvv")}
CHOICES = dict.fromkeys(ORDERS, ("fear", "anger"))
SCREEN = Screen("phone", 343, 193)


def enrolled(store: Store, code: str = "code") -> Participant:
    store.enroll(digest(code), ORDERS, CHOICES, "1", 60.0)
    found = store.find(digest(code))
    assert found is not None
    return found


def watched(store: Store, person: Participant, place: int) -> bool:
    store.show(person.id, place)
    store.start_play(person.id, place, f"play{place}", SCREEN)
    store.clock.now += 2
    return store.end_play(person.id, place, f"play{place}", 1.0, Playback(20), 2.0)


@pytest.fixture
def small(tmp_path, clock):
    made = Store(tmp_path / "small" / "answers.sqlite", "commitment", clock)
    yield made
    made.close()


def test_database_is_private_and_synchronous(small, tmp_path) -> None:
    files = list((tmp_path / "small").iterdir())
    assert files
    assert {stat.S_IMODE(file.stat().st_mode) for file in files} == {0o600}
    with small._data.reading() as sql:
        said = {name: sql.execute(f"PRAGMA {name}").fetchone()[0] for name in ("journal_mode", "synchronous")}
        assert said == {"journal_mode": "wal", "synchronous": 2}  # FULL


def test_participant_code_is_not_stored_in_plain_text(small, tmp_path) -> None:
    enrolled(small, "a-code-to-be-found")
    small.close()
    assert b"a-code-to-be-found" not in b"".join(file.read_bytes() for file in (tmp_path / "small").iterdir())


def test_records_persist_after_reopening(small, tmp_path, clock) -> None:
    person = enrolled(small)
    small.tell(person.id, {"gender": "Woman"})
    small.instruct(person.id)
    assert watched(small, person, 1)
    assert small.answer(person.id, 1, "fear", {"confidence": 3})
    before, secret = small.find(digest("code")), small.secret
    small.close()
    again = Store(tmp_path / "small" / "answers.sqlite", "commitment", clock)
    assert again.find(digest("code")) == before
    assert again.secret == secret
    again.close()


def test_last_answer_counts_first_is_kept_and_repetition_is_ignored(small) -> None:
    person = enrolled(small)
    watched(small, person, 1)
    for response in ("fear", "fear", "anger", "anger", "fear"):
        small.clock.now += 1
        assert small.answer(person.id, 1, response, {})
    answer = small.find(digest("code")).answers[1]
    assert (answer.response, answer.first, answer.changes) == ("fear", "fear", 2)
    assert answer.given - answer.first_given == 4


def test_answers_are_accepted_only_after_watching_and_before_submission_or_withdrawal(small) -> None:
    person = enrolled(small)
    assert not small.answer(person.id, 1, "fear", {})
    small.show(person.id, 1)
    assert not small.answer(person.id, 1, "fear", {})
    for place in (1, 2):
        watched(small, person, place)
        assert not small.submit(person.id)
        assert small.answer(person.id, place, "fear", {})
    assert small.submit(person.id)
    ended = small.find(digest("code")).submitted
    small.clock.now += 5
    assert small.submit(person.id)
    assert small.find(digest("code")).submitted == ended
    assert not small.answer(person.id, 1, "anger", {})
    small.tell(person.id, {"gender": "Man"})
    assert small.find(digest("code")).about is None
    assert small.withdraw(digest("code"))
    assert not small.answer(person.id, 1, "anger", {})
    assert not small.submit(person.id)


def test_repeated_play_report_counts_once_and_clock_changes_cause_no_delay(small) -> None:
    person = enrolled(small)
    small.show(person.id, 1)
    for _ in range(2):
        small.start_play(person.id, 1, "one", SCREEN)
    small.clock.now -= 3600
    small.start_play(person.id, 1, "two", SCREEN)
    assert small.play(person.id, 1, "one") == Play(small.clock.now, 0.0)
    small.clock.now += 2
    assert small.end_play(person.id, 1, "two", 1.0, Playback(60, 2), 2.0)
    ((_, viewings),) = small.participants()
    assert (viewings[1].plays, viewings[1].frames, viewings[1].dropped, viewings[1].screen) == (2, 60, 2, SCREEN)


def test_question_stays_open_after_a_complete_play(small) -> None:
    person = enrolled(small)
    assert watched(small, person, 1)
    small.start_play(person.id, 1, "again", SCREEN)
    assert small.end_play(person.id, 1, "again", 0.1, Playback(), 2.0)
    assert small.find(digest("code")).opened == {1}


def test_plays_beyond_the_limit_are_not_stored(small, monkeypatch) -> None:
    monkeypatch.setattr("emovid.survey.store._MAX_PLAYS", 5)
    person = enrolled(small)
    small.show(person.id, 1)
    for n in range(8):
        small.start_play(person.id, 1, str(n), SCREEN)
    ((_, viewings),) = small.participants()
    assert viewings[1].plays == 5


def test_only_abandoned_rows_are_reassigned(small) -> None:
    first, second = enrolled(small, "a"), enrolled(small, "b")
    assert (first.order_row, second.order_row) == ("P001", "P002")
    for place in (1, 2):
        watched(small, first, place)
        small.answer(first.id, place, "fear", {})
    small.submit(first.id)
    small.clock.now += 61
    assert enrolled(small, "c").order_row == "P002"
    assert small.find(digest("b")).order_row == "P002"  # a returning participant keeps the answers
    assert enrolled(small, "d").order_row == "P001"


def test_withdrawal_erases_all_files_and_numbers_are_not_reused(small, tmp_path) -> None:
    person = enrolled(small)
    small.tell(person.id, {"country": "Liechtenstein"})
    watched(small, person, 1)
    small.answer(person.id, 1, "anger", {})
    assert small.withdraw(digest("code"))
    assert small.withdraw(digest("code"))
    assert not small.withdraw(digest("nobody"))
    assert small.find(digest("code")) is None
    assert small.has_withdrawn(digest("code"))
    assert small.withdrawals() == 1
    with small._data.reading() as sql:
        tables = ("participants", "views", "plays", "answers")
        assert [sql.execute(f"SELECT * FROM {table}").fetchall() for table in tables] == [[]] * 4  # noqa: S608
        assert sql.execute("SELECT * FROM withdrawn").fetchall() == [(digest("code"),)]  # but not the time
    assert enrolled(small, "next").id == person.id + 1
    assert b"Liechtenstein" not in b"".join(file.read_bytes() for file in (tmp_path / "small").iterdir())


def test_reports_from_a_page_after_withdrawal_are_not_recorded(small) -> None:
    person = enrolled(small)
    small.withdraw(digest("code"))
    assert not watched(small, person, 1)
    with small._data.reading() as sql:
        assert sql.execute("SELECT * FROM views, plays").fetchall() == []


def test_backup_during_operation_contains_all_records(small, tmp_path, clock) -> None:
    person = enrolled(small)
    small.tell(person.id, {"gender": "Woman"})
    with sqlite3.connect(tmp_path / "small" / "answers.sqlite") as other:
        other.execute("VACUUM INTO ?", (str(tmp_path / "backup.sqlite"),))
    other.close()
    restored = Store(tmp_path / "backup.sqlite", "commitment", clock)
    assert restored.find(digest("code")) == small.find(digest("code"))
    restored.close()


def test_failed_change_is_rolled_back(small) -> None:
    def change() -> None:
        with small._data.writing() as sql:
            sql.execute("INSERT INTO withdrawn VALUES ('x')")
            raise KeyError

    with pytest.raises(KeyError):
        change()
    assert small.withdrawals() == 0


@pytest.mark.parametrize("what", ["text", "other", "folder"])
def test_database_of_another_kit_is_refused_and_unchanged(what, tmp_path) -> None:
    path = tmp_path / "answers.sqlite"
    if what == "text":
        path.write_text("not a database, and long enough to be taken for none " * 20)
    elif what == "other":
        Store(path, "another").close()
    else:
        path.mkdir()
    before = path.read_bytes() if path.is_file() else None
    with pytest.raises(Exception, match=r"answers\.sqlite") as raised:
        Store(path, "commitment")
    assert raised.type is InputError or what == "folder"
    if what == "text":
        assert path.read_bytes() == before


KILLED = """
import itertools, sys
from pathlib import Path
from emovid.survey.records import Playback, Screen
from emovid.survey.store import Store
store = Store(Path(sys.argv[1]), "commitment")
store.enroll("digest", {"P001": ("vvv",)}, {"P001": ("fear",)}, "1", 60.0)
person = store.find("digest").id
store.show(person, 1)
store.start_play(person, 1, "one", Screen("phone", 1, 1))
store.end_play(person, 1, "one", 1.0, Playback(), 1e-9)
for number in itertools.count():
    assert store.answer(person, 1, f"answer {number}", {})
    print(number, flush=True)
"""


def test_acknowledged_answers_survive_a_kill(tmp_path) -> None:
    path = tmp_path / "answers.sqlite"
    script = [sys.executable, "-c", KILLED, str(path)]
    with subprocess.Popen(script, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            if int(line) == 25:
                os.kill(process.pid, signal.SIGKILL)
                break
        acknowledged = max([25, *(int(line) for line in process.stdout)])
    with sqlite3.connect(path) as sql:
        said = [text for (text,) in sql.execute("SELECT response FROM answers ORDER BY id")]
    sql.close()
    assert said[: acknowledged + 1] == [f"answer {n}" for n in range(acknowledged + 1)]
    assert len(said) <= acknowledged + 2  # one more may have been in transit
