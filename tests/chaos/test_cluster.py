"""A sweep in one process, in shards and on a Dask cluster that loses a worker: the same table and bytes.

`make chaos` does so with 500 videos.
"""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

import emovid
from emovid.batch import cluster
from emovid.cli.main import main
from tests.helpers.dask_cluster import dask_cluster, dask_scheduler

PACKAGE = Path(emovid.__file__).parent
SWEEP = """
only: trajectory
scenes: [happiness, surprise, sadness, fear, anger]
set: {duration: 0.2, robots: 4}
grid: {robot.l: {from: 0.005, to: 0.02, count: 5}}
seeds: 4
"""
ITEMS = 5 * 5 * 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return a folder with a sweep of a hundred items, and its results in this process in `here`."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "s.yaml").write_text(SWEEP)
    assert main(["sweep", str(folder / "s.yaml"), "-o", str(folder / "here"), "--jobs", "1", "--quiet"]) == 0
    assert len((folder / "here" / "results.csv").read_text().splitlines()) == ITEMS + 1
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_shards_give_the_same_table_and_bytes(folder) -> None:
    for shard in (3, 1, 2):
        arguments = ["-o", str(folder / "shards"), "--shard", f"{shard}/3", "--jobs", "1", "--quiet"]
        assert main(["sweep", str(folder / "s.yaml"), *arguments]) == 0
    assert contents(folder / "shards") == contents(folder / "here")


def test_dask_cluster_that_loses_a_worker_gives_the_same_table_and_bytes(folder, tmp_path) -> None:
    target = folder / "dask"
    with dask_cluster(tmp_path, 2) as (address, workers):
        command = ["sweep", str(folder / "s.yaml"), "-o", str(target), "--scheduler", address]
        with subprocess.Popen([sys.executable, "-m", "emovid", *command], stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr
            for line in process.stderr:
                if line.startswith(f"[{ITEMS // 3}/"):
                    workers[0].kill()
                    break
            said = process.stderr.read()
    assert process.returncode == 0, said
    assert f"results.csv: {ITEMS} of {ITEMS} items" in said
    assert contents(target) == contents(folder / "here")


def test_run_ends_when_the_scheduler_stops_and_the_next_run_completes_it(folder, tmp_path) -> None:
    target, arguments = folder / "gone", ["sweep", str(folder / "s.yaml"), "-o", str(folder / "gone")]
    with dask_cluster(tmp_path, 1) as (address, _):
        command = [sys.executable, "-m", "emovid", *arguments, "--scheduler", address]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        assert process.stderr
        while not process.stderr.readline().startswith("[5/"):
            time.sleep(0)
    said = process.communicate(timeout=120)[1].splitlines()
    assert process.returncode == 1
    assert said[-1] == f"--scheduler {address}: the scheduler is gone: run again to make what is missing"
    assert main([*arguments, "--jobs", "1", "--quiet"]) == 0
    assert contents(target) == contents(folder / "here")


def test_cluster_option_without_dask_gives_an_installation_hint(folder, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["sweep", str(folder / "s.yaml"), "-o", str(tmp_path / "x"), "--scheduler", "tcp://127.0.0.1:9"]) == 2
    assert capsys.readouterr().err == "--scheduler needs Dask: pip install 'emovid[dask]'\n"
    assert not (tmp_path / "x").exists()


def test_tls_address_without_certificates_gives_a_one_line_message(folder, tmp_path) -> None:
    arguments = ["sweep", str(folder / "s.yaml"), "-o", str(tmp_path / "x"), "--scheduler", "tls://127.0.0.1:9"]
    done = subprocess.run([sys.executable, "-m", "emovid", *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("--scheduler tls://127.0.0.1:9: TLS expects a `ssl_context`")
    assert done.stderr.count("\n") == 1


def test_unreachable_scheduler_gives_a_one_line_message(folder, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(cluster, "_PATIENCE", 0.5)
    arguments = ["sweep", str(folder / "s.yaml"), "-o", str(tmp_path / "x"), "--scheduler", "tcp://127.0.0.1:9"]
    assert main(arguments) == 1
    assert capsys.readouterr().err == "--scheduler tcp://127.0.0.1:9: no Dask scheduler answers there\n"
    assert not (tmp_path / "x").exists()


def test_run_waits_for_workers_and_refuses_those_with_other_code(folder, tmp_path) -> None:
    def sweep(*arguments: str) -> tuple[int, list[str]]:
        command = ["sweep", "s.yaml", "-o", "elsewhere", *arguments]  # relative to the folder of the command
        done = subprocess.run(
            [sys.executable, "-m", "emovid", *command],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )
        return done.returncode, done.stderr.splitlines()

    shutil.copytree(folder / "here", folder / "elsewhere")
    copy = tmp_path / "other"
    shutil.copytree(PACKAGE, copy / "emovid", ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "configs").symlink_to(PACKAGE.parent / "configs")
    with (copy / "emovid" / "swarm" / "unicycle.py").open("a") as file:
        file.write("edited = True\n")
    with dask_scheduler(tmp_path) as (address, start_worker):
        code, said = sweep("--scheduler", address, "--force", "--wait", "0.5")
        assert code == 1
        assert said[0] == f"no workers yet at {address}: waiting (at most 0.5 s)"
        assert said[-1] == f"--scheduler {address}: no worker within 0.5 s: start some and run again"

        start_worker(PYTHONPATH=str(copy))
        code, said = sweep("--scheduler", address, "--force")
        assert code == 1
        assert any(re.fullmatch(r"worker \S+ is not used: code \w+, here \w+", line) for line in said)
        assert said[-1] == f"--scheduler {address}: no worker can be used: install the same versions there"
        assert contents(folder / "elsewhere") == contents(folder / "here")

        next((folder / "elsewhere").glob("*.npz")).write_bytes(b"damaged")
        start_worker()
        code, said = sweep("--scheduler", address, "--wait", "60")
    assert code == 0, said
    assert contents(folder / "elsewhere") == contents(folder / "here")
