"""A participant of the survey without a browser: cookies, form tokens, and reports as the player sends them."""

import html
import re
import secrets
from dataclasses import dataclass

from flask import Flask
from werkzeug.test import TestResponse


@dataclass
class Clock:
    """A clock that advances on request."""

    now: float = 1_800_000_000.0

    def __call__(self) -> float:
        return self.now


class Visitor:
    """One browser."""

    def __init__(self, app: Flask, clock: Clock) -> None:
        self.client, self.clock = app.test_client(), clock
        self.tokens: dict[str, str] = {}

    def get(self, path: str, **how) -> TestResponse:
        return self.client.get(path, buffered=True, **how)

    @property
    def token(self) -> str:
        """The token of this browser's forms, which is valid as long as the cookie."""
        if self.client.get_cookie("emovid") is None or self.cookie not in self.tokens:
            found = re.search(r'name="form-token" value="([0-9a-f]+)"', self.get("/new").text)
            assert found is not None
            self.tokens[self.cookie] = found[1]
        return self.tokens[self.cookie]

    @property
    def cookie(self) -> str:
        found = self.client.get_cookie("emovid")
        assert found is not None
        return found.value

    def post(self, path: str, **form) -> TestResponse:
        return self.client.post(path, data={"form-token": self.token, **form})

    def report(self, path: str, **facts) -> TestResponse:
        return self.client.post(path, json=facts, headers={"X-Form-Token": self.token})

    def begin(self) -> "Visitor":
        """Give consent, answer the questions and read the instructions."""
        assert self.post("/consent", consent="agree").location == "/about"
        assert self.post("/about", gender="Woman").location == "/instructions"
        assert self.post("/instructions").location == "/video/1"
        return self

    def watch(self, place: int, seconds: float = 1.0, share: float = 1.0) -> TestResponse:
        assert self.get(f"/video/{place}").status_code == 200
        play = secrets.token_hex(8)
        assert self.report(f"/video/{place}/play", play=play, device="phone", width=343, height=193).status_code == 200
        self.clock.now += seconds
        return self.report(f"/video/{place}/watched", play=play, share=share, frames=10, dropped=1)

    def answer(self, place: int, response: str, **ratings) -> TestResponse:
        return self.post(f"/video/{place}", response=response, **ratings)

    def go_through(self, responses: list[str], *, submit: bool = True) -> "Visitor":
        self.begin()
        for place, response in enumerate(responses, start=1):
            assert self.watch(place).json == {"open": True, "wait": 0}
            assert self.answer(place, response).status_code == 303
        if submit:
            assert self.post("/submit").location == "/"
            assert self.get("/").location == "/thanks"
        return self

    def chosen(self, place: int) -> str:
        """Return the answer preselected on the page of a video."""
        found = re.findall(r'name="response" value="([^"]*)" checked', self.get(f"/video/{place}").text)
        return html.unescape(found[0]) if found else ""
