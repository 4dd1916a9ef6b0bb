import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from flask import Flask
from small_survey import STUDY
from visitor import Clock, Visitor

from emovid.kit.build import build
from emovid.kit.load import load_study
from emovid.kit.read import Kit, open_public
from emovid.survey.app import create_app
from emovid.survey.store import Store
from emovid.survey.visit import Survey


class _Silent:
    def advanced(self, frames: int) -> None:
        pass

    def finished(self, video: Path, number: int, count: int, *, made: bool) -> None:
        pass


@pytest.fixture(scope="session")
def fresh(tmp_path_factory) -> Path:
    """Build a kit of six very small videos, which no test may change."""
    folder = tmp_path_factory.mktemp("survey")
    (folder / "study.yaml").write_text(STUDY)
    build(load_study(folder / "study.yaml"), folder / "kit", 12, 2**80 + 7, _Silent())
    return folder / "kit"


@pytest.fixture
def kit(fresh, tmp_path) -> Path:
    """Copy that kit, for answers and changes."""
    return Path(shutil.copytree(fresh, tmp_path / "kit"))


@pytest.fixture
def opened(fresh) -> Kit:
    return open_public(fresh)


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def store(opened, tmp_path, clock):
    made = Store(tmp_path / "answers.sqlite", opened.manifest.key_commitment, clock)
    yield made
    made.close()


@pytest.fixture(scope="session")
def pages(fresh, tmp_path_factory) -> Flask:
    """Make the application once: its templates are compiled when they are first shown."""
    opened = open_public(fresh)
    store = Store(tmp_path_factory.mktemp("pages") / "none.sqlite", opened.manifest.key_commitment)
    store.close()
    return create_app(opened, store)


@pytest.fixture
def app(pages, opened, store) -> Flask:
    pages.extensions["survey"] = Survey(opened, store, https=False, release=7200.0)
    return pages


@pytest.fixture
def visitor(app, clock) -> Callable[[], Visitor]:
    """Open a browser of its own for a participant."""
    return lambda: Visitor(app, clock)
