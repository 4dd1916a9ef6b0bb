import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from flask import Flask

from emovid.kit.folder import Kit, open_public
from emovid.survey.app import create_app
from emovid.survey.session import Survey
from emovid.survey.store import Store
from tests.helpers.small_survey import small_kit
from tests.helpers.visitor import Clock, Visitor


@pytest.fixture(scope="session")
def fresh(tmp_path_factory) -> Path:
    """Build a kit of six very small videos that tests must not change."""
    return small_kit(tmp_path_factory.mktemp("survey"))


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
    """Make the application once: its templates are compiled at their first use."""
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
    """Open a separate browser for a participant."""
    return lambda: Visitor(app, clock)
