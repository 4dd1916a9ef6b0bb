"""What a sweep leaves besides its items' files: its plan, the table of results and the contact sheet."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from emovid.atomic_io import make_folder, replace_if_changed
from emovid.batch.job import Record, is_by_recipe
from emovid.batch.ledger import is_growing, read_ledger
from emovid.batch.sheet import write_sheet
from emovid.batch.sweep import PLAN, Item, axes
from emovid.batch.sweep_file import SweepFile
from emovid.batch.table import write_results


def write_plan(folder: Path, sweep: SweepFile) -> None:
    """Write `plan.json`: the sweep without need of any other file, for `emovid status` and for those who repeat it."""
    make_folder(folder)
    replace_if_changed(folder / PLAN, sweep.plan().encode())


def write_summary(folder: Path, sweep: SweepFile, items: Sequence[Item], threads: int) -> int:
    """Write the table of what is finished, by this run or another, and the contact sheet once that is all.

    Args:
        folder: of the results.
        sweep: what they are of.
        items: all of them.
        threads: to read videos with.

    Returns:
        How many items are finished.
    """
    known, before = read_ledger(folder), None
    while known != before:
        records = _finished(folder, sweep, items, known)
        write_results(folder, items, records)
        # A run that has ended meanwhile may have written its table before ours; one that has not will write it after.
        known, before = known if is_growing(folder) else read_ledger(folder), known
    if len(records) == len(items) and sweep.only != "measure":
        write_sheet(folder, items, axes(sweep), records, threads)
    return len(records)


def _finished(
    folder: Path, sweep: SweepFile, items: Sequence[Item], known: Mapping[str, Record]
) -> Mapping[str, Record]:
    finished = {}
    for item in items:
        record, job = known.get(item.name), item.job(folder, sweep.only)
        if record and is_by_recipe(record, job) and (sweep.only == "measure" or job.target.exists()):
            finished[item.name] = record
    return finished
