"""All figures and tables that a user requests: which ones, in which formats, from which runs and which study."""

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from emovid.atomic_io import make_folder
from emovid.errors import EmovidError, InputError, nearest
from emovid.figures.catalogue import CATALOGUE, MEASURES, STUDY, TEXTS, WIDTHS, Entry
from emovid.figures.run_cache import Material
from emovid.figures.study import FigureData, LevelAccuracy, figure_data
from emovid.figures.style import FORMATS
from emovid.measure.describe import describe
from emovid.responses.read import read_responses
from emovid.responses.results_files import read_results
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting
from emovid.scene.resources import STUDIES
from emovid.statistics.analyze import analyze, analyze_counts
from emovid.swarm.simulate import check_start
from emovid.workflows.gallery import GALLERY, gallery, steps
from emovid.workflows.outputs import STDOUT, write_outputs
from emovid.workflows.snapshots import CONTACT, FRAMES, Moments, figure_at_times

ALL = "all"
OF_ANY_SCENE = (FRAMES, CONTACT)
_DEFAULT_FORMATS = ("pdf", "png", "tex", "md")
_TEXT_FORMATS = {"svg", *TEXTS}
_VIDEOS = (".mp4", ".webm", ".gif")


@dataclass(frozen=True)
class FigurePlan:
    """The figures to make, after all checks.

    Attributes:
        output: the folder, or `STDOUT` for a single file of text.
        formats: of each figure of the catalog.
        page: the figures of the gallery; None without a gallery.
        width: of all figures [in]; None for each one's own.
        left_out: why each figure that the study has no data for is left out.
        material: what the figures are made from.
    """

    output: Path
    formats: Mapping[Entry, Sequence[str]]
    page: Sequence[Entry] | None
    width: float | None
    left_out: Mapping[str, str]
    material: Material

    @property
    def targets(self) -> dict[str, list[Path]]:
        """The files of each figure."""
        if self.output == STDOUT:
            return {entry.name: [STDOUT] for entry in self.formats}
        files = {
            entry.name: [self.output / f"{entry.name}.{suffix}" for suffix in suffixes]
            for entry, suffixes in self.formats.items()
        }
        return files if self.page is None else files | {GALLERY: [self.output / f"{GALLERY}.html"]}

    @property
    def steps(self) -> int:
        """How many times `make_figures` reports progress."""
        return len(self.formats) + (0 if self.page is None else steps(self.page))


def plan_figures(
    names: Sequence[str],
    formats: Sequence[str],
    style: str | None,
    study: Path | None,
    moments: Moments,
    settings: Sequence[Setting],
    output: Path,
) -> FigurePlan:
    """Return which figures to make; all errors of the request, its scenes and its study are raised here.

    Args:
        names: of the catalog; "all", "gallery"; or "frames" or "contact-sheet" and a source.
        formats: to write; none for the default ones. A figure has only some of them.
        style: a name of `WIDTHS`, or None.
        study: results of a study; None for the reference study.
        moments: the times of frames or of a contact sheet.
        settings: keys of all scenes to replace.
        output: the folder for the figures.
    """
    if style is not None and style not in WIDTHS:
        raise InputError(f"--style {style}: expected {' or '.join(WIDTHS)}{nearest(style, WIDTHS)}")
    _check_formats(formats)
    asked = _in_formats(_entries(names, moments, settings), formats, strict=ALL not in names)
    on_page = list(CATALOGUE.values()) if GALLERY in names else []
    material = Material(settings, {STUDY: lambda _: study_results(study), MEASURES: measures_of})
    faults = _faults({**asked, **dict.fromkeys(on_page)}, material)
    if ALL not in names:
        for entry in asked:
            if entry.name in faults:
                raise InputError(f"{entry.name}: {faults[entry.name]}")
    plan = FigurePlan(
        output=output,
        formats={entry: suffixes for entry, suffixes in asked.items() if entry.name not in faults},
        page=[entry for entry in on_page if entry.name not in faults] if on_page else None,
        width=WIDTHS[style] if style else None,
        left_out=faults,
        material=material,
    )
    targets = [target for group in plan.targets.values() for target in group]
    if output != STDOUT:
        _check_output(output, targets)
    elif plan.page is not None or len(asked) != 1 or len(formats) != 1 or formats[0] not in _TEXT_FORMATS:
        raise InputError(f"-o -: prints one figure in one --format of {', '.join(sorted(_TEXT_FORMATS))}")
    return plan


def make_figures(plan: FigurePlan, done: Callable[[str], None], *, force: bool) -> None:
    """Make the figures of a plan and write them all at the end; call `done` with the name of each one made.

    Raises:
        InputError: for an existing file with other content, unless with `force`; nothing is written then.
    """
    files: dict[Path, bytes] = {}
    for entry, suffixes in plan.formats.items():
        made = entry.files(plan.material, suffixes, plan.width)
        files.update(zip(plan.targets[entry.name], made, strict=True))
        done(f"{plan.output / entry.name}: {', '.join(suffixes)}")
    if plan.page is not None:
        page = gallery(plan.material, plan.page, lambda part: done(f"{plan.output / GALLERY}: {part}"))
        files[plan.output / f"{GALLERY}.html"] = page
    write_outputs(files, force=force)


def study_results(source: Path | None) -> FigureData:
    """Return the data of a study for figures: from results in a file or folder, or of the reference study.

    Raises:
        InputError: if the file holds no results.
    """
    if source is None:
        reference = STUDIES / "santos-egerstedt" / "responses.csv"
        return figure_data(analyze(read_responses([reference]), ["gender", "robotics_background"]))
    counts, labels, signalled = read_results(source)  # raises an error for a file that has none
    file = source / "results.json" if source.is_dir() else source
    if file.suffix.lower() != ".json":
        return figure_data(analyze_counts(counts, labels, signalled))
    results = json.loads(file.read_bytes())
    try:
        groups = {
            column: {level: _level(block, signalled) for level, block in levels.items()}
            for column, levels in results["groups"].items()
        }
    except (AttributeError, LookupError, TypeError, ValueError):
        raise InputError(f"{file}: not results; expected the results.json of emovid study analyze") from None
    return FigureData(counts, signalled, labels, groups)


def _level(block: Any, signalled: Sequence[str]) -> LevelAccuracy:
    found = [[block["recognition"][name][key] for key in ("rate", "ci_low", "ci_high")] for name in signalled]
    answers = [block["recognition"][name]["n"] for name in signalled]
    return LevelAccuracy(int(block["n_participants"]), np.array(found, dtype=float), np.array(answers, dtype=np.int64))


def measures_of(material: Material) -> dict[str, dict[str, float]]:
    """Return the descriptors of the six emotions."""
    return {emotion: describe(material.run(emotion)) for emotion in EMOTIONS}


def _entries(names: Sequence[str], moments: Moments, settings: Sequence[Setting]) -> list[Entry]:
    """Return the requested figures: the one of any scene or video, or those of the catalog."""
    kinds = [name for name in dict.fromkeys(names) if name in (*OF_ANY_SCENE, ALL, GALLERY)]
    if set(kinds) & set(OF_ANY_SCENE):
        if len(kinds) > 1:
            raise InputError(f"{' and '.join(kinds)}: expected one of them at a time")
        return [figure_at_times(kinds[0], [name for name in names if name != kinds[0]], moments, settings)]
    if not names:
        raise InputError(f"expected names of figures, {ALL}, {GALLERY}, or --list to see them")
    for name in names:
        if name not in (*CATALOGUE, ALL, GALLERY):
            close = _hint_for_file(name) or nearest(name, [*CATALOGUE, ALL, GALLERY, *OF_ANY_SCENE])
            raise InputError(f"{name}: no such figure{close}; --list shows them")
    chosen = CATALOGUE if ALL in names else dict.fromkeys(name for name in names if name != GALLERY)
    return [CATALOGUE[name] for name in chosen]


def _hint_for_file(name: str) -> str:
    """Return the figure that can be made of a scene or a file, as a hint; "" for another name."""
    if name in EMOTIONS:
        return f" (did you mean {name}-frames?)"
    suffix = Path(name).suffix.lower()
    kind = FRAMES if suffix in (".yaml", ".yml", ".npz") else CONTACT if suffix in _VIDEOS else ""
    return kind and f" (did you mean {kind} {name}?)"


def _check_formats(formats: Sequence[str]) -> None:
    known = (*FORMATS, *TEXTS)
    for format in formats:
        if format not in known:
            raise InputError(f"--format {format}: expected one of {', '.join(known)}{nearest(format, known)}")


def _in_formats(entries: Sequence[Entry], formats: Sequence[str], *, strict: bool) -> dict[Entry, list[str]]:
    """Return the figures with the formats to write, those of `formats` that a figure has; leave out figures of none.

    Raises:
        InputError: in strict mode, for a figure that has none of the formats.
    """
    wanted = list(dict.fromkeys(formats or _DEFAULT_FORMATS))
    chosen = {entry: [format for format in wanted if format in entry.formats] for entry in entries}
    for entry, suffixes in chosen.items():
        if strict and not suffixes:
            asked = " or ".join(formats)
            raise InputError(f"{entry.name}: cannot be written as {asked}; expected one of {', '.join(entry.formats)}")
    return {entry: suffixes for entry, suffixes in chosen.items() if suffixes}


def _faults(asked: Iterable[Entry], material: Material) -> dict[str, str]:
    """Return the figures that the study has too little data for, and why.

    Scenes that cannot start and studies that cannot be read raise their errors here, before anything is written.
    """
    for emotion in dict.fromkeys(emotion for entry in asked for emotion in entry.emotions):
        check_start(material.scene(emotion))
    faults = {}
    for entry in asked:
        for table in entry.tables:
            material.table(table)
            try:
                entry.parts(material)
            except InputError as error:
                faults[entry.name] = str(error)
    return faults


def _check_output(folder: Path, targets: Sequence[Path]) -> None:
    """Create the folder, and check that the figures can be written into it."""
    try:
        make_folder(folder)
    except EmovidError as error:
        raise InputError(f"-o {error}") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise EmovidError(f"-o {folder}: cannot be written to")
    for target in targets:
        if target.is_dir():
            raise InputError(f"{target}: is a folder; expected a file that can be replaced")
