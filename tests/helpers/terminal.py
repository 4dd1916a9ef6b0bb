"""Terminals to run commands on."""

import io
import os
import pty
import re
import select
import subprocess
import sys

import pytest

from emovid.cli.main import main


def on_a_terminal(*arguments: str, **environment: str) -> bytes:
    """Return what a command that succeeds writes to a terminal of 100 columns."""
    left_out = ("NO_COLOR", "FORCE_COLOR", "CI")
    plain = {key: value for key, value in os.environ.items() if key not in left_out}
    env = plain | {"TERM": "xterm-256color", "COLUMNS": "100"} | environment
    master, slave = pty.openpty()
    command = [sys.executable, "-m", "emovid", *arguments]
    with subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=env) as process:
        os.close(slave)
        said = b""
        while select.select([master], [], [], 60)[0]:
            try:
                chunk = os.read(master, 65536)
            except OSError:  # the other end has closed
                break
            if not chunk:
                break
            said += chunk
    os.close(master)
    assert process.returncode == 0
    return said


class _Screen(io.StringIO):
    def isatty(self) -> bool:
        return True


def on_a_screen(columns: int, arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> str:
    """Return what a command prints to stdout on a terminal without colors, so many columns wide."""
    with monkeypatch.context() as patch:
        for name, value in {"COLUMNS": str(columns), "TERM": "xterm"}.items():
            patch.setenv(name, value)
        for name in ("FORCE_COLOR", "TTY_COMPATIBLE"):
            patch.delenv(name, raising=False)
        screen = _Screen()
        patch.setattr(sys, "stdout", screen)
        main(arguments)
    return re.sub(r"\x1b\[[0-9;]*m", "", screen.getvalue())
