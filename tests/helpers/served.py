"""The survey, served by the real command on a free port."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

COMMAND = (sys.executable, "-m", "emovid", "study", "serve")


class Server:
    """A server that can be killed and restarted at the same address.

    Attributes:
        address: as "http://127.0.0.1:8000".
    """

    def __init__(self, kit: Path, *options: str) -> None:
        self._kit, self._options, self._port = kit, options, "0"
        self._process: subprocess.Popen[str] | None = None
        self.start()

    def start(self) -> None:
        """Start the server, and return once it accepts connections."""
        command = [*COMMAND, str(self._kit), "--port", self._port, "--quiet", *self._options]
        self._process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ | {"NO_COLOR": "1"})
        assert self._process.stderr
        said = self._process.stderr.readline()
        found = re.match(r"(http://127\.0\.0\.1:(\d+))/: ", said)
        assert found, said
        self.address, self._port = found[1], found[2]

    def kill(self) -> None:
        """Kill the server, like a power cut."""
        self._process.kill()
        self._process.wait()
        self._process.stderr.close()

    def stop(self) -> int:
        """Stop the server like an experimenter, and return the exit code."""
        self._process.terminate()
        code = self._process.wait()
        self._process.stderr.close()
        return code


@contextmanager
def serving(kit: Path, *options: str) -> Iterator[Server]:
    server = Server(kit, *options)
    try:
        yield server
    finally:
        server.kill()
