"""The source archive (sdist): it has every file of the repository, so that its own make targets run."""

import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory) -> Path:
    """Build the archive and unpack it."""
    folder = tmp_path_factory.mktemp("sdist")
    command = [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(folder)]
    subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
    (archive,) = folder.glob("*.tar.gz")
    with tarfile.open(archive) as file:
        file.extractall(folder, filter="data")
    return folder / archive.name.removesuffix(".tar.gz")


def test_source_archive_has_every_file_of_the_repository(unpacked) -> None:
    git = shutil.which("git")
    if not git or not (ROOT / ".git").exists():
        pytest.skip("this is not a repository")
    tracked = subprocess.run([git, "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    assert [name for name in tracked if name and not (unpacked / name).exists()] == []


@pytest.mark.parametrize("target", ["all-videos", "test", "figures", "docs"])
def test_make_targets_of_the_source_archive_have_their_files(unpacked, target) -> None:
    make = shutil.which("make")
    assert make
    subprocess.run([make, target, "--dry-run"], cwd=unpacked, capture_output=True, check=True)
