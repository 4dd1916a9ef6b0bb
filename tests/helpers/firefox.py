"""Firefox, driven through its built-in Marionette: JSON over a socket, with the commands of WebDriver."""

import base64
import json
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

NAMES = ("firefox", "firefox-esr")
_ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # key of a reference to an element, as WebDriver defines it
_PREFERENCES = {
    "marionette.port": 0,
    "browser.shell.checkDefaultBrowser": False,
    "browser.startup.homepage_override.mstone": "ignore",
    "datareporting.policy.dataSubmissionEnabled": False,
    "toolkit.telemetry.reportingpolicy.firstRun": False,
    "app.update.auto": False,
    "app.normandy.enabled": False,
}


class CommandError(Exception):
    """A command that Firefox refused."""


class Firefox:
    """A window of Firefox."""

    def __init__(self, line: socket.socket) -> None:
        self._line, self._buffer, self._number = line, b"", 0
        self._receive()  # the greeting
        self.command("WebDriver:NewSession", capabilities={"alwaysMatch": {"unhandledPromptBehavior": "accept"}})

    def command(self, name: str, **parameters: Any) -> Any:
        """Run a command and return its result."""
        self._number += 1
        body = json.dumps([0, self._number, name, parameters]).encode()
        self._line.sendall(str(len(body)).encode() + b":" + body)
        _, _, error, result = self._receive()
        if error:
            raise CommandError(f"{name}: {error['error']}: {error['message']}")
        return result.get("value", result) if isinstance(result, dict) else result

    def open(self, url: str) -> None:
        self.command("WebDriver:Navigate", url=url)

    def resize(self, width: int, height: int) -> None:
        self.command("WebDriver:SetWindowRect", width=width, height=height)

    @property
    def url(self) -> str:
        return self.command("WebDriver:GetCurrentURL")

    def run(self, script: str, *arguments: Any) -> Any:
        """Run a JavaScript function body with `arguments`, and return its result."""
        return self.command("WebDriver:ExecuteScript", script=script, args=list(arguments))

    def click(self, selector: str) -> None:
        """Click on the first matching element once it is enabled."""
        self.wait(f"const e = document.querySelector({json.dumps(selector)}); return e && !e.disabled")
        found = self.command("WebDriver:FindElement", using="css selector", value=selector)
        self.command("WebDriver:ElementClick", id=found[_ELEMENT])

    def type(self, selector: str, text: str) -> None:
        found = self.command("WebDriver:FindElement", using="css selector", value=selector)
        self.command("WebDriver:ElementSendKeys", id=found[_ELEMENT], text=text)

    def wait(self, script: str, seconds: float = 60) -> None:
        """Wait until a JavaScript expression is true."""
        end = time.monotonic() + seconds
        while not self._is_true(script):
            if time.monotonic() > end:
                raise TimeoutError(f"{self.url}: {script}")
            time.sleep(0.05)

    def wait_for(self, path: str) -> None:
        self.wait(f"return document.readyState === 'complete' && location.pathname.endsWith({json.dumps(path)})")

    def screenshot(self, path: Path) -> None:
        path.write_bytes(base64.b64decode(self.command("WebDriver:TakeScreenshot", full=True, hash=False)))

    def _is_true(self, script: str) -> bool:
        try:
            return bool(self.run(script))
        except CommandError as error:  # during a page load
            if "javascript error" in str(error):
                raise
            return False

    def _receive(self) -> Any:
        while b":" not in self._buffer:
            self._buffer += self._more()
        size, _, self._buffer = self._buffer.partition(b":")
        while len(self._buffer) < int(size):
            self._buffer += self._more()
        body, self._buffer = self._buffer[: int(size)], self._buffer[int(size) :]
        return json.loads(body)

    def _more(self) -> bytes:
        data = self._line.recv(1 << 20)
        if not data:
            raise CommandError("Firefox has ended")
        return data


def path_of_firefox() -> str | None:
    return next((found for name in NAMES if (found := shutil.which(name))), None)


@contextmanager
def firefox() -> Iterator[Firefox]:
    """Start a Firefox with a new profile."""
    path = path_of_firefox()
    assert path is not None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in _PREFERENCES.items()]
        (Path(profile) / "user.js").write_text("\n".join(lines))
        command = [path, "--headless", "--no-remote", "--marionette", "--profile", profile, "about:blank"]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                with socket.create_connection(("127.0.0.1", _port_of(Path(profile))), timeout=120) as line:
                    yield Firefox(line)
            finally:
                process.terminate()


def _port_of(profile: Path) -> int:
    """Wait for the file in which Firefox writes its port."""
    for _ in range(600):
        file = profile / "MarionetteActivePort"
        if file.is_file() and (text := file.read_text().strip()):
            return int(text)
        time.sleep(0.1)
    raise TimeoutError("Firefox does not listen")
