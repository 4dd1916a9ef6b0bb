"""Load the survey: 200 participants at once, fifty kills, and one participant at full length in a real browser.

    python benchmarks/survey.py

prints a Markdown table, and exits with 1 if an answer was lost, came twice, or a participant saw an error.
"""

import shutil
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT))

from tests.helpers.crowd import Crowd  # noqa: E402 - the crowd of the tests
from tests.helpers.killing import kill_under_load  # noqa: E402
from tests.helpers.participant import Participant  # noqa: E402
from tests.helpers.served import serving  # noqa: E402
from tests.helpers.small_survey import STUDY, small_kit  # noqa: E402

PEOPLE, ORDERS, KILLS, LENGTH = 200, 240, 50, 2.0  # s
Row = tuple[str, str, bool]


def crowded(kit: Path) -> Row:
    """Simulate 200 participants at once."""
    with serving(kit) as server:
        crowd = Crowd(server.address, PEOPLE, LENGTH)
        started = time.monotonic()
        crowd.start()
        crowd.wait()
        took = time.monotonic() - started
    seconds = np.concatenate([person.seconds for person in crowd.people])
    middle, high, most = 1000 * np.quantile(seconds, [0.5, 0.99, 1])
    replies = f"replies within {middle:.0f} ms (median), {high:.0f} ms (99 %), {most:.0f} ms (all)"
    said = f"{len(crowd.failures)} errors; {len(seconds)} requests in {took:.0f} s; {replies}"
    return f"{PEOPLE} participants at once, all six videos of {LENGTH:g} s", said, not crowd.failures


def killed(kit: Path) -> Row:
    """Kill the server at 50 random moments while 40 participants take part."""
    found = kill_under_load(kit, LENGTH, KILLS, people=40, seed=3)
    said = f"{found.acknowledged} answers acknowledged; {found.lost} lost, {found.twice} twice"
    said += f", {len(found.failures)} errors"
    return f"{found.kills} kills (SIGKILL) under load", said, not (found.lost or found.twice or found.failures)


def watched(folder: Path) -> Row:
    """Simulate one participant of the example study in a real browser, at full length."""
    kit = small_kit(folder / "full", (ROOT / "studies" / "example" / "study.yaml").read_text(), ORDERS)
    with serving(kit) as server, sync_playwright() as playwright:
        path = shutil.which("chromium") or shutil.which("google-chrome")
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-gpu"])
        person = Participant(browser, server.address, 1)
        started = time.monotonic()
        person.page.get_by_role("button", name="I agree and want to take part").click()
        person.page.wait_for_url("**/about")
        for group in person.page.locator("fieldset").all():
            group.get_by_role("radio").last.check()
        person.page.get_by_role("button", name="Continue").click()
        person.page.wait_for_url("**/instructions")
        person.page.get_by_role("button", name="Continue").click()
        person.page.wait_for_url("**/video/1")
        for _ in range(6):
            person.play()
            person.watched()
            person.choose()
        person.submit()
        took = time.monotonic() - started
        browser.close()
    return (
        "one participant in Chromium, six videos of 15 s",
        f"submitted after {took:.0f} s; {len(person.errors)} errors",
        True,
    )


def main() -> int:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        kit = small_kit(folder / "small", STUDY.replace("duration: 1}", f"duration: {LENGTH:g}}}"), ORDERS)
        other = shutil.copytree(kit, folder / "killed" / "kit")
        print("| what | outcome |\n|---|---|")
        held = True
        for what, said, good in (crowded(kit), killed(other), watched(folder)):
            print(f"| {what} | {said} |")
            held &= good
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
