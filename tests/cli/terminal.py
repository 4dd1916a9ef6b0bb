"""A terminal to run commands on."""

import os
import pty
import select
import subprocess
import sys


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
