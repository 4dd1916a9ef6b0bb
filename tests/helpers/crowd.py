"""Many parallel participants without browsers, from consent to submission, with retries if a reply is missing."""

import http.client
import json
import re
import secrets
import threading
import time
from random import Random
from urllib.parse import urlencode, urlsplit


class RefusedError(Exception):
    """An unexpected reply to a participant."""


class Person:
    """One participant, with the behavior of the page of the survey.

    Attributes:
        acknowledged: the answer to each position that the server acknowledged.
        seconds: the time of each reply, without missing replies.
        submitted: whether the server accepted the submission.
    """

    def __init__(self, address: str, number: int, duration: float) -> None:
        self._where, self._duration = urlsplit(address), duration
        self._random = Random(number)  # noqa: S311 - what somebody happens to choose
        self._cookie = self._token = ""
        self._line: http.client.HTTPConnection | None = None
        self.acknowledged: dict[int, str] = {}
        self.seconds: list[float] = []
        self.submitted = False

    @property
    def code(self) -> str:
        """The code of the participant, from the cookie."""
        return self._cookie.partition("=")[2]

    def take_part(self) -> None:
        """Take part, from consent to submission."""
        page = self._ask("GET", "/")
        self._token = re.search(r'name="form-token" value="([0-9a-f]+)"', page)[1]
        self._post("/consent", consent="agree")
        self._post("/about", gender="Woman")
        self._post("/instructions")
        for place in range(1, 7):
            self._see(place)
        self._post("/submit")
        self.submitted = True

    def hang_up(self) -> None:
        if self._line is not None:
            self._line.close()
        self._line = None

    def _see(self, place: int) -> None:
        page = self._ask("GET", f"/video/{place}")
        labels = re.findall(r'name="response" value="([^"]*)"', page)
        self._ask("GET", re.search(r'src="(/media/\w+\.mp4)"', page)[1])
        play = secrets.token_hex(8)
        self._report(f"/video/{place}/play", play=play, device="desktop", width=640, height=360)
        reply = {"open": False, "wait": self._duration}
        while not reply["open"]:
            time.sleep(reply["wait"])
            reply = self._report(f"/video/{place}/watched", play=play, share=1.0, frames=10, dropped=0)
        for chosen in self._random.sample(labels, self._random.choice([1, 1, 2])):  # some change their answer
            self._post(f"/video/{place}", response=chosen)
            self.acknowledged[place] = chosen

    def _post(self, path: str, **form: str) -> None:
        body = urlencode({"form-token": self._token, **form})
        self._ask("POST", path, body, {"Content-Type": "application/x-www-form-urlencoded"}, expected=303)

    def _report(self, path: str, **facts: object) -> dict:
        headers = {"Content-Type": "application/json", "X-Form-Token": self._token}
        return json.loads(self._ask("POST", path, json.dumps(facts), headers))

    def _ask(self, method: str, path: str, body: str = "", headers: dict | None = None, expected: int = 200) -> str:
        """Return the reply; repeat the request until there is one."""
        while True:
            try:
                return self._asked_once(method, path, body, headers or {}, expected)
            except (OSError, http.client.HTTPException):
                self.hang_up()
                time.sleep(0.05)

    def _asked_once(self, method: str, path: str, body: str, headers: dict, expected: int) -> str:
        if self._line is None:
            self._line = http.client.HTTPConnection(self._where.hostname, self._where.port, timeout=30)
        started = time.perf_counter()
        cookies = {"Cookie": self._cookie} if self._cookie else {}
        self._line.request(method, path, body or None, headers | cookies)
        reply = self._line.getresponse()
        text = reply.read().decode(errors="replace")
        self.seconds.append(time.perf_counter() - started)
        for line in reply.headers.get_all("Set-Cookie") or ():
            self._cookie = line.split(";")[0]
        if reply.status != expected:
            raise RefusedError(f"{method} {path}: {reply.status} {text[:200]}")
        return text


class Crowd:
    """Parallel participants.

    Attributes:
        people: all of them.
        failures: unexpected replies.
    """

    def __init__(self, address: str, count: int, duration: float) -> None:
        self.people = [Person(address, number, duration) for number in range(count)]
        self.failures: list[str] = []
        self._threads = [threading.Thread(target=self._run, args=(person,), daemon=True) for person in self.people]

    def start(self) -> None:
        for thread in self._threads:
            thread.start()

    def is_there(self) -> bool:
        return any(thread.is_alive() for thread in self._threads)

    def wait(self) -> None:
        for thread in self._threads:
            thread.join()

    def _run(self, person: Person) -> None:
        try:
            person.take_part()
        except Exception as error:
            self.failures.append(repr(error))
        finally:
            person.hang_up()
