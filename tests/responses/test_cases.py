"""Small exports in the formats of real studies, each with its confusion matrix or its error message."""

import json
from pathlib import Path
from typing import Any

import pytest

from emovid.errors import SourceError
from emovid.responses.read import read_responses
from emovid.responses.responses import Responses

CASES = Path(__file__).parent / "cases"
ALL = [
    pytest.param(folder, case, id=f"{folder.name}-{case.get('map', 'no-map')}-{case['export']}")
    for folder in sorted(CASES.iterdir())
    for case in json.loads((folder / "case.json").read_text())
]


def matrix(found: Responses) -> dict[str, dict[str, int]]:
    """The counts as {signalled: {perceived: count}}, without zeros."""
    counts = found.answers.groupby(["signalled", "perceived"]).size()
    return {
        str(signalled): {str(label): int(n) for label, n in counts[signalled].items()}
        for signalled in counts.index.get_level_values(0).unique()
    }


def read(folder: Path, case: dict[str, Any]) -> Responses:
    key, mapping = (folder / case[name] if name in case else None for name in ("key", "map"))
    return read_responses(folder / case["export"], key, mapping)


@pytest.mark.parametrize(("folder", "case"), ALL)
def test_case_gives_its_matrix_or_refusal(folder: Path, case: dict[str, Any]) -> None:
    if "refusal" in case:
        with pytest.raises(SourceError) as error:
            read(folder, case)
        assert case["refusal"] in str(error.value)
        return
    found = read(folder, case)
    if "matrix" in case:
        assert matrix(found) == case["matrix"]
    if "participants" in case:
        assert len(found.participants) == case["participants"]
    if "left_out" in case:
        assert found.dropped | found.left_out == case["left_out"]
    for name, counts in case.get("groups", {}).items():
        assert found.participants[name].value_counts().to_dict() == counts
    for person, places in case.get("positions", {}).items():
        rows = found.answers[found.answers["participant"] == person]
        assert dict(zip(rows["video"], rows["position"].tolist(), strict=True)) == places
    for person, videos in case.get("orders", {}).items():
        rows = found.answers[found.answers["participant"] == person].sort_values("position")
        assert rows["video"].tolist() == videos
        assert rows["position"].tolist() == [1, 2, 3]
