import csv
import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
import urllib.request
from functools import partial
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.kit.folder import open_kit
from emovid.responses.read import read_responses
from emovid.survey.app import create_app
from emovid.survey.codes import digest, readable
from emovid.survey.store import database_of, open_survey
from tests.helpers.small_survey import LABELS
from tests.helpers.visitor import Clock, Visitor


@pytest.fixture(autouse=True)
def elsewhere(kit, monkeypatch) -> None:
    """Work in a folder with a copy of the kit."""
    monkeypatch.chdir(kit.parent)


def site_of(kit: Path) -> str:
    _, store = open_survey(kit, pilot=False)
    store.close()
    return store.site


def take_part(answers: list[list[str]], *, pilot: bool = False, submit: bool = True) -> list[Visitor]:
    """Let participants go through the survey of the kit."""
    opened, store = open_survey(Path("kit"), pilot=pilot, create=True)
    clock = Clock()
    store.clock = clock
    app = create_app(opened, store)
    visitors = [Visitor(app, clock).go_through(given, submit=submit) for given in answers]
    store.close()
    return visitors


def test_analysis_counts_the_given_answers(capsys) -> None:
    answers = [[LABELS[(i + j * j) % 6] for j in range(6)] for i in range(4)]
    take_part(answers)
    take_part([["fear"] * 3, []], submit=False)
    assert main(["study", "responses", "kit", "-o", "responses.csv"]) == 0
    told = capsys.readouterr().err
    assert told.startswith("responses.csv: 27 answers; participants: 6 enrolled, 5 began, 4 finished, ")
    read = read_responses(Path("responses.csv"), key=Path("kit/private/key.csv"))
    kit, site = open_kit(Path("kit")), site_of(Path("kit"))
    orders = list(kit.orders.values())
    expected = [
        (f"p-{site}-{person:04d}", code, kit.key[code], label, place)
        for person, (order, given) in enumerate(zip(orders, answers, strict=False), start=1)
        for place, (code, label) in enumerate(zip(order, given, strict=True), start=1)
    ]
    assert [tuple(row) for row in read.answers.itertuples(index=False)] == expected
    assert list(read.participants.columns) == ["gender"]
    assert (read.sources[0].dialect, read.dropped) == ("emovid survey", {"partial": 2})
    assert [(item.value, item.reason) for item in read.rejected] == [
        (f"p-{site}-0005", "left out: partial"),  # who stopped after three videos
        (f"p-{site}-0006", "left out: partial"),  # who left before the first answer
    ]
    assert main(["study", "audit", "kit", "--responses", "responses.csv"]) == 0
    assert "4 participants, 4 with all videos, 24 answers" in capsys.readouterr().out


def test_export_has_video_codes_but_no_true_labels(capsys) -> None:
    take_part([["fear"] * 6])
    assert main(["study", "responses", "kit", "-o", "new/out.csv", "-q"]) == 0
    assert capsys.readouterr().err == ""
    text = Path("new/out.csv").read_text()
    without = text.replace("fear", "").replace(open_kit(Path("kit")).orders["P001"][0], "")
    for row in csv.DictReader(text.splitlines()):
        without = without.replace(row["choices"].replace("fear", ""), "")
    assert not any(label in without for label in LABELS)
    assert "127.0.0.1" not in text


def test_answers_are_printed_where_the_output_is_a_dash(capsysbinary) -> None:
    take_part([["fear"] * 6])
    assert main(["study", "responses", "kit", "-o", "answers.csv", "-q"]) == 0
    assert main(["study", "responses", "kit", "-o", "-", "-q"]) == 0
    assert capsysbinary.readouterr().out == Path("answers.csv").read_bytes()


def test_a_file_of_something_else_is_not_replaced_by_answers(capsys) -> None:
    take_part([["fear"] * 6])
    Path("answers.csv").write_text("mine")
    assert main(["study", "responses", "kit", "-o", "answers.csv"]) == 2
    assert capsys.readouterr().err == "answers.csv exists with other content; use --force to overwrite it, or -o\n"
    assert Path("answers.csv").read_text() == "mine"


def test_pilot_answers_are_marked_and_excluded_from_the_analysis(capsys) -> None:
    take_part([["fear"] * 6], pilot=True)
    assert main(["study", "responses", "kit"]) == 2
    assert capsys.readouterr().err == (
        "kit/answers/answers.sqlite: no such file; expected answers: emovid study serve records them\n"
    )
    take_part([["anger"] * 6])
    assert main(["study", "responses", "kit", "-o", "real.csv", "-q"]) == 0
    assert main(["study", "responses", "kit", "--pilot", "-o", "pilot.csv", "-q"]) == 0
    real, pilot = (list(csv.DictReader(Path(f"{name}.csv").read_text().splitlines())) for name in ("real", "pilot"))
    assert {(row["participant"], row["mode"], row["response"]) for row in real} == {
        (f"p-{site_of(Path('kit'))}-0001", "study", "anger")
    }
    assert {(row["participant"][:6], row["mode"], row["response"]) for row in pilot} == {("pilot-", "pilot", "fear")}
    mixed = read_responses([Path("real.csv"), Path("pilot.csv")], key=Path("kit/private/key.csv"))
    assert set(mixed.answers["participant"]) == {f"p-{site_of(Path('kit'))}-0001"}
    assert mixed.dropped == {"pilot": 1}


def test_progress_shows_participants_and_balance(capsys) -> None:
    visitors = take_part([["fear"] * 6] * 4)
    take_part([["fear"]], submit=False)
    assert main(["study", "withdraw", "kit", readable(visitors[0].cookie), "-q"]) == 0
    assert main(["study", "progress", "kit"]) == 0
    out = capsys.readouterr().out
    counts = dict(re.findall(r"^([a-z ]+?) +(\d+)$", out, re.MULTILINE))
    # The clock of these participants differs by years from that of this machine: the interrupted one is one of the two.
    assert int(counts.pop("in progress")) + int(counts.pop("abandoned")) == 1
    assert counts == {
        "enrolled": "5", "began": "4", "finished": "3", "complete": "0", "withdrawn": "1", "answers": "19",
    }  # fmt: skip
    assert "each row 0 to 1 times, each video 0 to 1 times in each place" in out
    assert main(["study", "progress", "kit", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["finished"], said["places"], said["rows"]["P001"], said["rows"]["P002"]) == (3, [0, 1], 0, 1)


def test_withdrawal_by_code_deletes_data_and_prints_remaining_steps(capsys) -> None:
    (visitor,) = take_part([["fear"] * 6])
    code = readable(visitor.cookie)
    assert main(["study", "withdraw", "kit", code]) == 0
    assert "earlier exports" in capsys.readouterr().err
    _, store = open_survey(Path("kit"), pilot=False)
    assert store.participants() == []
    assert store.has_withdrawn(digest(visitor.cookie))
    store.close()


def test_a_withdrawal_that_a_reader_delays_fails_with_a_message_until_it_is_repeated(capsys, monkeypatch) -> None:
    (visitor,) = take_part([["fear"] * 6])
    monkeypatch.setattr("emovid.cli.survey.open_survey", partial(open_survey, patience=0.1))
    reader = sqlite3.connect("kit/answers/answers.sqlite", isolation_level=None)
    reader.execute("BEGIN")
    reader.execute("SELECT * FROM participants").fetchall()
    assert main(["study", "withdraw", "kit", readable(visitor.cookie)]) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert "another program" in told
    assert "run this command again" in told
    reader.close()
    assert main(["study", "withdraw", "kit", readable(visitor.cookie)]) == 0


@pytest.mark.parametrize("counted", [False, True])
def test_complete_answers_without_a_submission_count_if_the_study_says_so(counted, capsys) -> None:
    take_part([["fear", "anger", "fear", "anger", "fear", "anger"]])
    take_part([["fear", "anger", "fear", "anger", "fear", "anger"]], submit=False)
    manifest = Path("kit/public/manifest.json")
    said = json.loads(manifest.read_text())
    manifest.write_text(json.dumps(said | {"counting": said["counting"] | {"unsubmitted": counted}}))
    assert main(["study", "responses", "kit", "-o", "responses.csv"]) == 0
    read = read_responses(Path("responses.csv"), key=Path("kit/private/key.csv"))
    assert len(read.participants) == 1 + counted
    assert sum(read.dropped.values()) == 1 - counted
    statuses = {row["status"] for row in csv.DictReader(Path("responses.csv").read_text().splitlines())}
    assert statuses == {"finished", "complete" if counted else "unsubmitted"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["serve", "nowhere"], "nowhere: no such folder; expected a kit"),
        (["responses", "nowhere"], "nowhere: no such folder; expected a kit"),
        (["progress", "kit"], "kit/answers/answers.sqlite: no such file; expected answers: emovid study serve records "
         "them"),
        (["progress", "kit", "--pilot"], "kit/answers/pilot.sqlite: no such file; expected answers: emovid study serve "
         "--pilot records them"),
        (["responses", "kit", "-o", "kit"], "-o kit: is a folder; expected a file"),
        (["serve", "kit", "--host", "256.0.0.1"], "--host 256.0.0.1: not an address of this machine"),
    ],
)  # fmt: skip
def test_invalid_input_gives_a_one_line_message(arguments, message, capsys) -> None:
    assert main(["study", *arguments]) in (1, 2)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(message)
    assert err.count("\n") == 1


def test_missing_extra_gives_an_installation_hint(monkeypatch, capsys) -> None:
    monkeypatch.setitem(sys.modules, "waitress.server", None)
    monkeypatch.delitem(sys.modules, "emovid.survey.serve", raising=False)
    assert main(["study", "serve", "kit"]) == 1
    assert capsys.readouterr().err == "waitress.server is missing: pip install 'emovid[serve]'\n"


def test_unknown_code_deletes_nothing(capsys) -> None:
    take_part([["fear"] * 6])
    for code in ("nonsense", "b" * 24):
        assert main(["study", "withdraw", "kit", code]) == 2
        assert capsys.readouterr().err.startswith(f"{code}: no participant has this code")
    assert main(["study", "responses", "kit", "-o", "left.csv"]) == 0
    assert "6 answers" in capsys.readouterr().err


def test_progress_without_orders_gives_a_one_line_message(capsys) -> None:
    take_part([["fear"] * 6])
    Path("kit/orders.csv").unlink()
    assert main(["study", "progress", "kit"]) == 2
    assert capsys.readouterr().err == "kit/orders.csv: no such file; expected the orders of the kit\n"


@pytest.mark.parametrize(
    "what", ["orders", "orders of another kit", "video", "video of another size", "another kit's answers"]
)
def test_incomplete_kit_is_not_served(what, capsys) -> None:
    video = next(Path("kit/public/videos").iterdir())
    if what == "orders":
        Path("kit/orders.csv").unlink()
    elif what == "orders of another kit":
        Path("kit/orders.csv").write_text(Path("kit/orders.csv").read_text().replace(video.stem, "bbbbbb"))
    elif what == "video":
        video.unlink()
    elif what == "video of another size":
        video.write_bytes(video.read_bytes()[:-1])
    else:
        take_part([["fear"] * 6])
        manifest = Path("kit/public/manifest.json")
        said = json.loads(manifest.read_text())
        manifest.write_text(json.dumps(said | {"key_commitment": "0" * 64}))
    assert main(["study", "serve", "kit", "--port", "0"]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "expected" in err


# A name with two addresses, as localhost with IPv6, and more open files than select() supports.
ODD = """
import os, resource, socket, sys
from emovid.__main__ import run
first = socket.getaddrinfo("127.0.0.1", 0, 0, socket.SOCK_STREAM, socket.IPPROTO_TCP)
socket.getaddrinfo = lambda *_: 2 * first
limits = resource.getrlimit(resource.RLIMIT_NOFILE)
resource.setrlimit(resource.RLIMIT_NOFILE, (min(2000, limits[1]), limits[1]))
kept = [os.open(os.devnull, os.O_RDONLY) for _ in range(1100)]
sys.argv = ["emovid", "study", "serve", "kit", "--host", "localhost", "--port", "0", "--quiet"]
run()
"""


def test_server_supports_two_addresses_and_many_open_files() -> None:
    with subprocess.Popen([sys.executable, "-c", ODD], stderr=subprocess.PIPE, text=True) as server:
        try:
            address = re.match(r"http://localhost:(\d+)/: survey of ", said := server.stderr.readline())
            assert address, said + server.stderr.read()
            with urllib.request.urlopen(f"http://127.0.0.1:{address[1]}/") as reply:
                assert "I agree and want to take part" in reply.read().decode()
        finally:
            server.terminate()
            left = server.stderr.read()
    assert left == ""
    assert server.returncode == 0


def test_server_prints_its_address_responds_and_stops_on_a_signal(kit) -> None:
    command = [sys.executable, "-m", "emovid", "study", "serve", str(kit), "--port", "0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        try:
            said = server.stderr.readline()
            address = re.match(r"(http://127\.0\.0\.1:\d+/): survey of ", said)
            assert address, said
            with urllib.request.urlopen(address[1]) as reply:  # noqa: S310 - it is http
                assert "I agree and want to take part" in reply.read().decode()
                assert reply.headers["Server"] == "emovid"
            again = [*command[:-1], address[1].rsplit(":", 1)[1].strip("/")]
            taken = subprocess.run(again, capture_output=True, text=True, check=False)
            assert taken.returncode == 1
            assert "address already in use" in taken.stderr
            assert taken.stderr.count("\n") == 1
        finally:
            os.kill(server.pid, signal.SIGTERM)
            left = server.stderr.read()
    assert "Traceback" not in left
    assert "private is not needed here" in left
    assert server.returncode == 0
    assert database_of(kit, pilot=False).is_file()
