import os
import shutil
from collections.abc import Callable
from typing import Any, NoReturn

import pytest
from hypothesis import settings

# Like the command line, and before numpy is imported: with several test processes, threads of OpenBLAS wait for each
# other far longer than they calculate.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
from emovid.scene.load import Setting, load_scene
from emovid.scene.model import Scene

# The duration of an example depends more on the machine than on the code.
settings.register_profile("emovid", deadline=None)
settings.register_profile("repeatable", deadline=None, derandomize=True)  # the same examples each time
settings.load_profile("emovid")

MakeScene = Callable[..., Scene]


@pytest.fixture(scope="session")
def make_scene() -> MakeScene:
    """Make a shipped scene with keys replaced: make_scene("fear", {"robots": 3})."""

    def make(emotion: str = "happiness", keys: dict[str, Any] | None = None) -> Scene:
        return load_scene(emotion, [Setting(key, value, f"test {key}") for key, value in (keys or {}).items()])

    return make


BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="module")  # a running playwright would occupy the event loop of the thread
def browser():
    """Start Chromium. Without it, browser tests are skipped, or fail if the environment requires it."""
    path = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if path is None:
        _left_out("no Chromium: its pages were NOT TRIED in a browser")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _left_out("no playwright: its pages were NOT TRIED in a browser")
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-gpu"])
        yield running
        running.close()


def _left_out(reason: str) -> NoReturn:
    if os.environ.get("EMOVID_TESTS_NEED_BROWSER"):
        pytest.fail(reason)
    pytest.skip(reason)
