"""What `emovid figures` makes figures from, besides runs of the shipped scenes: a study's results, and descriptors."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emovid.errors import InputError

if TYPE_CHECKING:
    from emovid.figures.run_cache import Material


def study_results(source: Path | None) -> Any:
    """Return the results of a study: those in a file or folder, or an analysis of the reference study."""
    from emovid.figures.study import recognition_of
    from emovid.responses.read import read_responses
    from emovid.responses.results_files import read_results
    from emovid.scene.resources import STUDIES
    from emovid.statistics.analyze import analyze, analyze_counts

    if source is None:
        reference = STUDIES / "santos-egerstedt" / "responses.csv"
        return analyze(read_responses([reference]), ["gender", "robotics_background"])
    counts, labels, signalled = read_results(source)  # says what is wrong with it
    file = source / "results.json" if source.is_dir() else source
    if file.suffix.lower() != ".json":
        return analyze_counts(counts, labels, signalled)
    results = json.loads(file.read_bytes())
    try:
        for column, levels in results["groups"].items():
            if levels:
                recognition_of(results, column)
    except (AttributeError, LookupError, TypeError, ValueError):
        raise InputError(f"{file}: no results; expected the results.json of emovid study analyze") from None
    return results


def measures_of(material: "Material") -> dict[str, dict[str, float]]:
    """Return the descriptors of the six emotions."""
    from emovid.measure.describe import describe
    from emovid.scene.emotions import EMOTIONS

    return {emotion: describe(material.run(emotion)) for emotion in EMOTIONS}
