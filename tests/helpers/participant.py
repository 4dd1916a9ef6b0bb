"""A participant of the survey in a browser, who keeps a log to compare with the recorded data."""

import re
from random import Random
from typing import Any

from tests.helpers.firefox import Firefox

PHONE = {"viewport": {"width": 360, "height": 740}, "has_touch": True, "is_mobile": True}
DESKTOP = {"viewport": {"width": 1280, "height": 800}}


class Participant:
    """One person with one browser.

    Attributes:
        page: the current page.
        gender: as answered.
        first, last: first and last answer by video code.
        errors: of the page.
    """

    def __init__(self, browser: Any, address: str, number: int) -> None:
        self._random = Random(number)  # noqa: S311 - what somebody happens to choose
        self._context = browser.new_context(**(PHONE if number % 3 == 0 else DESKTOP))
        self._address = address
        self.gender = self._random.choice(["Woman", "Man", "Another gender"])
        self.first: dict[str, str] = {}
        self.last: dict[str, str] = {}
        self.errors: list[str] = []
        self.open()

    def open(self) -> None:
        """Open the survey in a new tab; a browser with a participant continues."""
        self.page = self._context.new_page()
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.goto(f"{self._address}/")

    def begin(self) -> None:
        self.page.get_by_role("button", name="I agree and want to take part").click()
        self.page.get_by_label(self.gender, exact=True).check()
        self.page.get_by_role("button", name="Continue").click()
        self.page.wait_for_url("**/instructions")
        self.page.get_by_role("button", name="Continue").click()
        self.page.wait_for_url("**/video/1")

    def play(self) -> None:
        self.page.locator("#play").click()

    def watched(self) -> None:
        """Wait until the question can be answered."""
        self.page.locator("#gate:enabled").wait_for()

    @property
    def code(self) -> str:
        video = self.page.locator("#player video")
        source = video.get_attribute("data-source") or video.get_attribute("src") or ""
        found = re.search(r"/media/(\w+)\.mp4", source)
        assert found, source
        return found[1]

    def choose(self) -> None:
        """Answer at random, and wait for the acknowledgment."""
        code, here = self.code, self.page.url
        chosen = self.page.get_by_role("radio").nth(self._random.randrange(6))
        chosen.check()
        self.last[code] = chosen.get_attribute("value") or ""
        self.first.setdefault(code, self.last[code])
        self.page.locator("#submit").click()
        self.page.wait_for_url(lambda url: url != here)

    def go_back_to(self, place: int, link: str) -> None:
        self.page.get_by_role("link", name=link).click()
        self.page.wait_for_url(f"**/video/{place}")

    def reload(self) -> None:
        """Reload the page, which loses the played time."""
        self.page.reload()
        self.play()

    def watch_again(self) -> None:
        self.play()
        self.watched()

    def crash(self) -> None:
        """Close the tab without warning, and open the survey again."""
        self.page.close()
        self.open()
        self.play()

    def submit(self) -> None:
        self.page.get_by_role("button", name="Submit all answers").click()
        self.page.wait_for_url("**/thanks")

    def leave(self) -> None:
        self._context.close()
        assert self.errors == []


class FirefoxParticipant:
    """One person, in a window of Firefox that may have had another one before.

    Attributes:
        gender: as told.
        first, last: first and last answer by video code.
    """

    def __init__(self, window: Firefox, number: int) -> None:
        self._window = window
        self._random = Random(1000 + number)  # noqa: S311 - what somebody happens to choose
        self.gender = self._random.choice(["Woman", "Man", "Another gender"])
        self.first: dict[str, str] = {}
        self.last = self.first  # nothing is changed

    def take_part(self, address: str, language: str, country: str) -> None:
        """Go from the first page to the last one, and leave the computer to the next person."""
        window = self._window
        window.open(f"{address}/?language={language}")
        window.click("button[value=agree]")
        window.wait_for("/about")
        window.click(f"input[value='{self.gender}']")
        window.type("#about-country", country)
        window.click("main button[type=submit]")
        window.wait_for("/instructions")
        window.click("main button[type=submit]")
        for place in range(1, 7):
            window.wait_for(f"/video/{place}")
            assert window.run("return document.documentElement.scrollWidth <= window.innerWidth")
            window.click("#play")
            window.wait("return !document.getElementById('gate').disabled")
            self._choose()
        window.wait_for("/review")
        window.click("main button[type=submit]")
        window.wait_for("/thanks")
        window.open(f"{address}/new")
        window.click("main button[type=submit]")
        window.wait_for("/")

    def _choose(self) -> None:
        source = self._window.run("return document.querySelector('#player video').dataset.source")
        code = source.rpartition("/")[2].removesuffix(".mp4")
        number = self._random.randrange(6)
        self.first[code] = self._window.run(f"return document.querySelectorAll('input[name=response]')[{number}].value")
        self._window.click(f".choices label:nth-of-type({number + 1}) input")
        self._window.click("#submit")
