import shutil
from functools import cache
from pathlib import Path

import pytest

from emovid.atomic_io import file_digest
from emovid.kit.checks import videos
from tests.helpers.tiny import make_kit


@pytest.fixture(scope="session")
def fresh(tmp_path_factory) -> Path:
    """Build a small kit that tests must not change."""
    folder = tmp_path_factory.mktemp("fresh")
    make_kit(folder)
    return folder / "kit"


@pytest.fixture
def kit(fresh, tmp_path) -> Path:
    """Copy the small kit, for a test that changes it."""
    return Path(shutil.copytree(fresh, tmp_path / "kit"))


def once_per_content(function):
    """Cache a function of a video file by content, since audits of many kits decode the same videos."""
    paths: dict[str, Path] = {}

    @cache
    def of_content(digest: str, like):
        return function(paths[digest], like)

    def of_path(path: Path, like):
        paths[digest := file_digest(path)] = path
        return of_content(digest, like)

    return of_path


@pytest.fixture(scope="session", autouse=True)
def decode_each_video_once():
    """Cache decoded videos for the session."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("_decoded", "_decoding_problem"):
            patch.setattr(videos, name, once_per_content(getattr(videos, name)))
        yield
