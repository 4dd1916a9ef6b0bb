"""The server is killed while people answer. The long form is `make bench-survey`."""

import socket
import urllib.request
from contextlib import ExitStack

from tests.helpers.crowd import Crowd
from tests.helpers.killing import kill_under_load
from tests.helpers.served import serving


def test_acknowledged_answers_are_stored_exactly_once(kit) -> None:
    outcome = kill_under_load(kit, duration=1.0, kills=6, people=12, seed=1)
    assert outcome.failures == []
    assert outcome.acknowledged >= 12 * 6
    assert (outcome.kills, outcome.lost, outcome.twice) == (6, 0, 0)


def test_many_simultaneous_participants_get_no_error(kit) -> None:
    with serving(kit) as server:
        crowd = Crowd(server.address, 40, duration=1.0)
        crowd.start()
        crowd.wait()
    assert crowd.failures == []
    assert all(person.submitted and len(person.acknowledged) == 6 for person in crowd.people)


def test_thousand_slow_connections_do_not_block_participants(kit) -> None:
    with serving(kit) as server, ExitStack() as slow:
        port = int(server.address.rpartition(":")[2])
        for _ in range(1010):  # more than waitress takes by default, 100, and than version 0.1.0 took
            line = slow.enter_context(socket.create_connection(("127.0.0.1", port), timeout=30))
            line.sendall(b"POST /consent HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000\r\n\r\na")
        with urllib.request.urlopen(f"{server.address}/", timeout=60) as reply:  # noqa: S310 - it is http
            assert "I agree and want to take part" in reply.read().decode()
