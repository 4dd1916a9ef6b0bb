import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from emovid.kit.folder import set_times
from tests.helpers.tiny import make_kit


@pytest.fixture(scope="session")
def fresh(tmp_path_factory) -> Path:
    """Build a small kit, which no test may change."""
    folder = tmp_path_factory.mktemp("fresh")
    make_kit(folder)
    return folder / "kit"


@pytest.fixture
def kit(fresh, tmp_path) -> Path:
    """Copy the small kit, for a test that changes it."""
    return Path(shutil.copytree(fresh, tmp_path / "kit"))


@pytest.fixture
def touched_up() -> Callable[[Path], None]:
    """Hide when a test changed public files, as who plants a leak on purpose would."""
    return lambda kit: set_times(kit / "public")
