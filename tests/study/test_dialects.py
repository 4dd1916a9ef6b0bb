from pathlib import Path

import pandas as pd
import pytest
from exports import ANSWERS, CODES, COUNTS, EMOTIONS, EXPORTS, GENDER, KEY, ORDER, Export, jspsych, otree_wide, psychopy

from emovid.study.read import read_responses
from emovid.study.responses import Responses


def write(export: Export, folder: Path) -> Path:
    """Write the files and return the folder, or the file where there is one."""
    target = folder / "exports"
    target.mkdir()
    for name, data in export.files.items():
        (target / name).write_bytes(data)
    (folder / "key.csv").write_text(KEY)
    (folder / "map.yaml").write_text(export.map or "labels:\n")
    return target if len(export.files) > 1 else target / next(iter(export.files))


def read(export: Export, folder: Path) -> Responses:
    source = write(export, folder)
    return read_responses(source, folder / "key.csv", folder / "map.yaml", groups=["gender"])


@pytest.mark.parametrize("make", EXPORTS, ids=lambda make: make.__name__)
def test_every_dialect_says_the_same(make, tmp_path) -> None:
    export = make()
    found = read(export, tmp_path)
    assert {source.dialect for source in found.sources} == {export.dialect}
    assert found.labels == found.signalled == EMOTIONS
    assert found.counts().tolist() == COUNTS
    assert len(found.answers) == 48
    assert [(row.row, row.cell) for row in found.rejected] == [(0, "")] * export.skipped
    assert found.dropped == export.dropped
    by_person = found.answers.pivot(index="participant", columns="video", values="perceived")[list(CODES)]
    assert sorted(map(tuple, by_person.to_numpy())) == sorted(tuple(given.values()) for given in ANSWERS.values())
    genders = dict(
        zip(map(tuple, by_person.to_numpy()), found.participants.loc[by_person.index, "gender"], strict=True)
    )
    assert genders == {tuple(ANSWERS[p].values()): GENDER[p] for p in ANSWERS}


@pytest.mark.parametrize("make", [make for make in EXPORTS if make().positions], ids=lambda make: make.__name__)
def test_the_order_of_the_videos_comes_along(make, tmp_path) -> None:
    found = read(make(), tmp_path).answers.sort_values("position")
    orders = sorted(tuple(rows["video"]) for _, rows in found.groupby("participant"))
    assert orders == sorted(tuple(order) for order in ORDER.values())
    assert sorted(found["position"].unique()) == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("make", [make for make in EXPORTS if not make().positions], ids=lambda make: make.__name__)
def test_an_order_that_no_column_tells_is_missing(make, tmp_path) -> None:
    positions = read(make(), tmp_path).answers["position"]
    assert positions.isna().all()
    assert positions.dtype == pd.Int64Dtype()


def test_what_differs_between_rounds_is_no_group(tmp_path) -> None:
    assert list(read(otree_wide(), tmp_path).participants) == ["gender"]


def test_a_key_that_was_not_pressed_is_no_answer(tmp_path) -> None:
    export = psychopy()
    export.files = {name: data.replace(b",1,1.5", b",None,None") for name, data in export.files.items()}
    found = read(export, tmp_path)
    assert found.labels == EMOTIONS
    assert [row.reason for row in found.rejected] == ["no answer"] * sum(COUNTS[0])


def test_a_trial_that_ran_out_of_time_is_no_answer(tmp_path) -> None:
    export = jspsych()
    export.files = {name: data.replace(b'.mp4""]","0"', b'.mp4""]","null"') for name, data in export.files.items()}
    found = read(export, tmp_path)
    assert [row.reason for row in found.rejected] == ["no answer"] * sum(COUNTS[0])
