"""Kill the server at random times while a crowd takes part, and compare acknowledged with stored answers."""

import time
from collections import Counter
from pathlib import Path
from random import Random
from typing import NamedTuple

import pandas as pd

from emovid.cli.main import main
from tests.helpers.crowd import Crowd
from tests.helpers.served import serving


class Outcome(NamedTuple):
    """The result of a run.

    Attributes:
        kills: how often the server was killed.
        acknowledged: answers that the server acknowledged.
        lost, twice: of these, the numbers missing or different in the export, and stored more than once.
        failures: unexpected replies to participants.
    """

    kills: int
    acknowledged: int
    lost: int
    twice: int
    failures: list[str]


def kill_under_load(kit: Path, duration: float, kills: int, people: int, seed: int) -> Outcome:
    """Run `people` participants repeatedly until the server was killed `kills` times."""
    random, done, everybody, failures = Random(seed), 0, [], []  # noqa: S311 - moments, not secrets
    with serving(kit) as server:
        while done < kills:
            crowd = Crowd(server.address, people, duration)
            crowd.start()
            while crowd.is_there():
                time.sleep(random.uniform(0.02, 0.6))
                if done < kills:
                    server.kill()
                    server.start()
                    done += 1
            crowd.wait()
            everybody += crowd.people
            failures += crowd.failures
        target = kit.parent / "after-kills.csv"
        assert main(["study", "responses", str(kit), "-o", str(target), "--quiet"]) == 0
    return compared(everybody, pd.read_csv(target), done, failures)


def compared(everybody: list, table: pd.DataFrame, kills: int, failures: list[str]) -> Outcome:
    """Compare acknowledged answers with the rows of the export; the answers themselves identify participants."""
    rows = {
        person: dict(zip(part["position"], part["response"], strict=True))
        for person, part in table.groupby("participant")
    }
    kept = Counter(tuple(sorted(answers.items())) for answers in rows.values())
    told = Counter(tuple(sorted(person.acknowledged.items())) for person in everybody)
    missing = told - kept
    lost = sum(len(answers) * count for answers, count in missing.items())
    twice = int(table.duplicated(["participant", "position"]).sum()) + sum((kept - told).values())
    return Outcome(kills, sum(len(person.acknowledged) for person in everybody), lost, twice, failures)
