"""Small and incomplete studies are analyzed, written and reported."""

import json

import pandas as pd
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from jsonschema import validate

from emovid.report.page import report_html
from emovid.report.results_json import as_json, results_schema
from emovid.report.tables import result_files
from emovid.responses.responses import EMOTIONS, Responses
from emovid.statistics.analyze import analyze, analyze_counts

NAMES = (*EMOTIONS, "pride", "shame", "calm", "boredom", "envy", "none")


@st.composite
def studies(draw: st.DrawFn) -> Responses:
    size = draw(st.integers(1, 11))
    signalled = NAMES[:size]
    labels = NAMES[: draw(st.integers(max(size, 2), 11))] + (("none",) if draw(st.booleans()) else ())
    people = [f"p{i}" for i in range(draw(st.integers(1, 6)))]
    answer = st.tuples(
        st.sampled_from(people), st.sampled_from(signalled), st.sampled_from(labels), st.integers(1, size)
    )
    rows = draw(st.lists(answer, min_size=1, max_size=40, unique_by=lambda row: row[:2]))
    answers = pd.DataFrame(
        [(who, f"v-{video}", video, said, place) for who, video, said, place in rows],
        columns=["participant", "video", "signalled", "perceived", "position"],
    ).astype({"position": "Int64"})
    if draw(st.booleans()):
        answers["position"] = pd.array([pd.NA] * len(answers), dtype="Int64")
    level = st.sampled_from(["a", "b", "c", "", None])
    groups = {f"g{i}": [draw(level) for _ in people] for i in range(draw(st.integers(0, 2)))}
    return Responses(signalled, labels, answers, pd.DataFrame(groups, index=people, dtype=object))


@given(studies())
@settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow])
def test_any_small_study_gives_results(study: Responses) -> None:
    results = analyze(study)
    assert results.counts.sum() == len(study.answers)
    files = result_files(results, study)
    found = json.loads(files["results.json"])
    assert {"schema_version": 2, **as_json(results)} == found
    validate(found, results_schema())
    assert report_html(results, study, {}).endswith("</html>\n")
    assert as_json(analyze(study)) == as_json(results)


@given(studies())
@settings(max_examples=15, suppress_health_check=[HealthCheck.too_slow])
def test_any_matrix_gives_results(study: Responses) -> None:
    results = analyze_counts(study.counts(), study.labels, study.signalled)
    assert result_files(results, None)["tests.csv"].count("\n") == 1 + len(study.signalled)
    assert report_html(results, None, {}).endswith("</html>\n")
