import numpy as np
import pandas as pd

from emovid import simulate, to_dataframe
from emovid.swarm.files import save_trajectory


def test_dataframe_has_a_row_for_each_sample_and_robot(make_scene) -> None:
    run = simulate(make_scene("fear", {"duration": 1.1, "robots": 4}))
    table = to_dataframe(run)
    assert list(table.columns) == ["time", "robot", "x", "y", "heading", "v", "omega"]
    assert len(table) == len(run.t) * 4
    for k, t in enumerate(run.t):
        rows = table[table["time"] == t].set_index("robot")
        assert list(rows.index) == [1, 2, 3, 4]
        assert np.array_equal(rows[["x", "y", "heading"]], run.poses[k])
        if k < len(run.commands):
            assert np.array_equal(rows[["v", "omega"]], run.commands[k])
        else:
            assert rows[["v", "omega"]].isna().all(axis=None)


def test_commands_in_the_dataframe_lead_from_pose_to_pose(make_scene) -> None:
    table = to_dataframe(simulate(make_scene("happiness", {"duration": 2.0})))
    for _, rows in table.groupby("robot"):
        seconds = rows["time"].diff().shift(-1)
        turned = (rows["omega"] * seconds)[:-1]
        change = rows["heading"].diff().shift(-1)[:-1]
        assert np.allclose(np.exp(1j * turned), np.exp(1j * change))


def test_dataframe_equals_the_csv(make_scene, tmp_path) -> None:
    run = simulate(make_scene("sadness", {"duration": 1.0}))
    save_trajectory(run, tmp_path / "run.csv")
    written = pd.read_csv(tmp_path / "run.csv")
    pd.testing.assert_frame_equal(to_dataframe(run), written, check_exact=True)
