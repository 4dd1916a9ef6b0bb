import json
from pathlib import Path

import numpy as np
import pytest

from emovid.errors import InputError, SourceError
from emovid.measure.describe import describe
from emovid.scene.load import load_robot, load_scene
from emovid.scene.stage import Rectangle
from emovid.swarm.files import load_trajectory, save_trajectory
from emovid.swarm.simulate import check_start, simulate
from emovid.swarm.tracks import load_positions, load_track
from emovid.swarm.trajectory import RecordedTrajectory, Trajectory

STAGE = {"width": 1.2, "height": 0.8}
T = np.arange(31) / 10
# Two robots: one moves to the right along y = 0.1, one on a circle, in meters and y up.
X = np.stack([-0.3 + 0.1 * T, 0.2 * np.cos(T)], axis=1)
Y = np.stack([np.full_like(T, 0.1), 0.2 * np.sin(T)], axis=1)


def described(folder: Path, **keys: object) -> Path:
    """Write a description of a track with `keys`, in pixels of 2 mm from the upper left corner unless they differ."""
    every = {"scale": 0.002, "y": "down", "origin": {"x": 300, "y": 200}, "robot": "gritsbot", "stage": STAGE} | keys
    path = folder / "real.track.yaml"
    path.write_text(json.dumps({key: value for key, value in every.items() if value is not None}))
    return path


def pixels() -> tuple[np.ndarray, np.ndarray]:
    return X / 0.002 + 300, 200 - Y / 0.002


def expect_motion(run: Trajectory) -> None:
    assert isinstance(run, RecordedTrajectory)
    assert run.t == pytest.approx(T, abs=1e-9)
    assert run.poses[..., 0] == pytest.approx(X, abs=1e-6)
    assert run.poses[..., 1] == pytest.approx(Y, abs=1e-6)
    assert run.poses[5, 0, 2] == pytest.approx(0, abs=1e-6)  # heading in the direction of motion


def long_csv(path: Path, frames: bool = False) -> None:
    x, y = pixels()
    rows = [f"{i if frames else t},{who},{x[i, k]},{y[i, k]}" for i, t in enumerate(T) for k, who in enumerate("ab")]
    path.write_text("\n".join([f"{'frame' if frames else 'sec'},id,x,y", *rows]))


@pytest.mark.parametrize("frames", [False, True])
def test_long_csv_is_read(tmp_path, frames) -> None:
    long_csv(tmp_path / "real.csv", frames)
    columns = {"frame": "frame"} if frames else {"time": "sec"}
    track = described(tmp_path, file="real.csv", format="long", columns=columns, rate=10 if frames else None)
    expect_motion(load_track(track))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"scale": 2e-6}, r"within 0\.\d+ mm, and one robot is 3\d(\.\d)? mm wide"),
        ({"scale": 2.0, "origin": {"x": -300, "y": 200}}, "no position is on the stage"),
    ],
)
def test_impossible_scales_are_refused(tmp_path, keys, message) -> None:
    long_csv(tmp_path / "real.csv")
    track = described(tmp_path, file="real.csv", format="long", columns={"time": "sec"}, **keys)
    with pytest.raises(SourceError, match=message) as error:
        load_track(track)
    assert error.value.key == "scale"


@pytest.mark.parametrize(
    ("format", "text"),
    [
        ("trex", "time,X#wcentroid (cm),Y#wcentroid (cm)\n0,1,2\n0.1,1\n"),
        ("deeplabcut", "scorer,s,s,s\nbodyparts,b,b,b\ncoords,x,y,likelihood\n0,1,2,1\n1,1\n"),
        ("idtracker", "time,x1,y1\n0,1,2\n0.1,1\n"),
        ("long", "frame,id,x,y\n0,a,1,2\n1,a\n"),
    ],
)
def test_ragged_rows_are_refused_with_their_line(tmp_path, format, text) -> None:
    (tmp_path / "trajectories.csv").write_text(text)
    rate = {"rate": 10} if format in ("deeplabcut", "long") else {}
    columns = {"columns": {"frame": "frame"}} if format == "long" else {}
    track = described(tmp_path, file="trajectories.csv", format=format, **rate, **columns)
    line = len(text.splitlines())
    with pytest.raises(
        InputError, match=rf"trajectories\.csv:{line}: ragged row: [12] cells? where the header has [34]"
    ):
        load_track(track)


def test_position_without_a_time_is_refused(tmp_path) -> None:
    (tmp_path / "gap.csv").write_text("time,robot,x,y\n0,0,0,0\n,0,0.1,0\n1,0,0.2,0\n")
    with pytest.raises(InputError, match="robot 0 has a position without a time"):
        load_positions(tmp_path / "gap.csv", load_scene("anger"))


def test_csv_with_semicolons_or_a_missing_position_gets_a_remedy(tmp_path) -> None:
    scene = load_scene("anger")
    (tmp_path / "semi.csv").write_text("time;robot;x;y\n0;0;0;0\n")
    with pytest.raises(InputError, match=r"semi\.csv: no column 'time'; expected commas between columns"):
        load_positions(tmp_path / "semi.csv", scene)
    (tmp_path / "gap.csv").write_text("time,robot,x,y\n0,0,0,0\n1,0,0,0\n1,1,0.1,0\n")
    with pytest.raises(InputError, match=r"^\S*gap\.csv: robot 1 has no position at 0 s; .*NAME\.track\.yaml$"):
        load_positions(tmp_path / "gap.csv", scene)


def test_deeplabcut_files_with_one_body_part_or_several_individuals_are_read(tmp_path) -> None:
    x, y = pixels()
    heads = [
        "scorer,s,s,s,s,s,s",
        "individuals,a,a,a,b,b,b",
        "bodyparts" + 6 * ",body",
        "coords" + 2 * ",x,y,likelihood",
    ]
    rows = [f"{i},{x[i, 0]},{y[i, 0]},1,{x[i, 1]},{y[i, 1]},0.9" for i in range(len(T))]
    (tmp_path / "dlc.csv").write_text("\n".join([*heads, *rows]))
    expect_motion(load_track(described(tmp_path, file="dlc.csv", format="deeplabcut", rate=10)))
    unsure = described(tmp_path, file="dlc.csv", format="deeplabcut", rate=10, likelihood=0.95)
    with pytest.raises(InputError, match=r"robot b has no position at 0 s; expected all positions, or gaps"):
        load_track(unsure)
    wrong = described(tmp_path, file="dlc.csv", format="deeplabcut", rate=10, bodypart="bodi")
    with pytest.raises(InputError, match=r"bodypart: bodi: expected one of body .*did you mean body"):
        load_track(wrong)


def test_trex_files_with_missing_positions(tmp_path) -> None:
    folder = tmp_path / "data"
    folder.mkdir()
    for k in range(2):
        x, y = 100 * X[:, k], -100 * Y[:, k]  # cm, y down
        if k:
            x[7] = np.inf
        np.savez(folder / f"video_fish{k}.npz", **{"X#wcentroid": x, "Y#wcentroid": y, "time": T})
    keys = {"file": "data", "format": "trex", "scale": 0.01, "origin": None}
    with pytest.raises(InputError, match=r"robot video_fish1 has no position at 0\.7 s"):
        load_track(described(tmp_path, **keys))
    run = load_track(described(tmp_path, **keys, gaps="interpolate"))
    assert run.poses[7, 1, 0] == pytest.approx((X[6, 1] + X[8, 1]) / 2)
    assert run.poses[3, 1, :2] == pytest.approx([X[3, 1], Y[3, 1]])


def test_trex_csv_with_units_in_its_names_and_other_files_in_the_folder(tmp_path) -> None:
    folder = tmp_path / "data"
    folder.mkdir()
    for k in range(2):
        rows = [
            f"{i},{x},{y},{i},{t}" for i, (t, x, y) in enumerate(zip(T, 100 * X[:, k], -100 * Y[:, k], strict=True))
        ]
        head = "frame,X#wcentroid (cm),Y#wcentroid (cm),frame,time"
        (folder / f"video_fish{k}.csv").write_text("\n".join([head, *rows]))
    for other in ("posture_fish0", "recognition_fish0", "statistics", "tracklet_images"):
        np.savez(folder / f"video_{other}.npz", frames=T)
    keys = {"file": "data", "format": "trex", "scale": 0.01, "origin": None}
    expect_motion(load_track(described(tmp_path, **keys)))
    expect_motion(load_track(described(tmp_path, **keys, rate=10)))  # by frames
    (folder / "video_fish1.csv").write_text("frame,X#wcentroid (cm),time\n0,1,0\n1,2,0.1")
    with pytest.raises(
        InputError, match=r"video_fish1.csv: not an individual of TRex: no Y#wcentroid; it has frame, X"
    ):
        load_track(described(tmp_path, **keys))


def test_start_and_end_leave_out_the_parts_in_which_a_robot_is_missing(tmp_path) -> None:
    x, y = pixels()
    rows = [
        f"{t},{x[i, 0]},{y[i, 0]},{x[i, 1] if i > 1 else 'nan'},{y[i, 1] if i > 1 else 'nan'}" for i, t in enumerate(T)
    ]
    (tmp_path / "trajectories.csv").write_text("\n".join(["seconds,x1,y1,x2,y2", *rows]))
    keys = {"file": "trajectories.csv", "format": "idtracker", "gaps": "interpolate"}
    with pytest.raises(InputError, match=r"robot 2 has no position at 0 s; .*expected start and end .* 0.2 and 3 s"):
        load_track(described(tmp_path, **keys))
    run = load_track(described(tmp_path, **keys, start=0.2, end=2))
    assert run.t == pytest.approx(T[2:21] - 0.2, abs=1e-9)
    assert run.poses[:, 1, 0] == pytest.approx(X[2:21, 1], abs=1e-6)
    with pytest.raises(InputError, match=r"fewer than two samples in trajectories.csv from start to end"):
        load_track(described(tmp_path, **keys, start=2.95, end=9))


@pytest.mark.parametrize("timed", [True, False])
def test_idtracker_session_is_read(tmp_path, timed) -> None:
    folder = tmp_path / "session" / "trajectories" / "trajectories_csv"
    folder.mkdir(parents=True)
    x, y = pixels()
    first = [f"{t}," if timed else "" for t in T]
    rows = [f"{first[i]}{x[i, 0]},{y[i, 0]},{x[i, 1]},{y[i, 1]}" for i in range(len(T))]
    (folder / "trajectories.csv").write_text("\n".join([("time," if timed else "") + "x1,y1,x2,y2", *rows]))
    (folder / "attributes.json").write_text('{"frames_per_second": 10}')
    track = described(tmp_path, file="session", format="idtracker", rate=None if timed else 10)
    expect_motion(load_track(track))
    if not timed:
        with pytest.raises(InputError, match=r"expected rate in the track; attributes.json says 10"):
            load_track(described(tmp_path, file="session", format="idtracker"))


def test_ros_bag_of_pose_arrays_is_read(tmp_path) -> None:
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = "geometry_msgs/msg/PoseArray"
    types = store.types
    point, quaternion, pose = (types[f"geometry_msgs/msg/{name}"] for name in ("Point", "Quaternion", "Pose"))
    heading = np.array([0.0, 0.5])
    bag = tmp_path / "bag"
    with rosbag2.Writer(bag, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/poses", kind, typestore=store)
        for t, x, y in zip(T, X, Y, strict=True):
            stamp = types["builtin_interfaces/msg/Time"](sec=5 + int(t + 1e-9), nanosec=round(1e9 * (t % 1)) % 10**9)
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="map")
            poses = [
                pose(point(a, b, 0.0), quaternion(0.0, 0.0, np.sin(h / 2), np.cos(h / 2)))
                for a, b, h in zip(x, y, heading, strict=True)
            ]
            writer.write(connection, round(1e9 * (5 + t)), store.serialize_cdr(types[kind](header, poses), kind))
    run = load_track(described(tmp_path, file="bag", format="mcap", scale=1, y="up", origin=None))
    assert run.t == pytest.approx(T, abs=1e-6)
    assert run.poses[..., 0] == pytest.approx(X)
    assert run.poses[:, 1, 2] == pytest.approx(0.5)
    with pytest.raises(InputError, match="topic: expected one of /poses"):
        load_track(described(tmp_path, file="bag", format="mcap", scale=1, y="up", origin=None, topic="/odom"))


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"scale": None}, r"real.track.yaml:1: scale: missing \(meters in one unit"),
        ({"y": None}, r"y: missing \(direction of the file's y axis"),
        ({"rate": None}, "rate: missing: a file that counts frames needs its frames per second"),
        ({"columns": {"time": "frame"}}, "rate: 10: the file has times in seconds; expected no rate"),
        ({"start": 2, "end": 1}, "end: 1: expected a time after the start, 2"),
        ({"format": "dlc"}, r"format: 'dlc': expected one of emovid, long"),
        ({"robot": "gritsbit"}, "did you mean gritsbot"),
        ({"columns": {"frame": "frame", "robot": "who"}}, "no column 'who'"),
    ],
)
def test_description_without_required_keys_is_refused(tmp_path, keys, words) -> None:
    long_csv(tmp_path / "real.csv", frames=True)
    every = {"file": "real.csv", "format": "long", "columns": {"frame": "frame"}, "rate": 10} | keys
    with pytest.raises((SourceError, InputError), match=words):
        load_track(described(tmp_path, **every))


def test_simulated_csv_is_read_as_recorded_motion(tmp_path) -> None:
    scene = load_scene("fear", {"duration": 3})
    run = simulate(scene)
    save_trajectory(run, tmp_path / "fear.csv")
    back = load_positions(tmp_path / "fear.csv", scene)
    assert back.poses == pytest.approx(run.poses, abs=1e-12)
    found, exact = describe(back), describe(run)
    missing = {name for name, value in found.items() if np.isnan(value)}
    assert {"speed_p95", "speed_peak", "cost_ratio", "overshoot_share", "recurrence", "sparc"} <= missing
    for name in ("radius_of_gyration_end", "nearest_neighbour_mean", "distance_to_boundary_end"):
        assert found[name] == pytest.approx(exact[name], rel=0.02)


def test_recorded_motion_is_saved_loaded_and_never_simulated(tmp_path) -> None:
    run = Trajectory.from_poses(T, np.stack([X, Y], axis=-1), body=load_robot("e_puck2"), stage=Rectangle(**STAGE))
    save_trajectory(run, tmp_path / "real.npz")
    back = load_trajectory(tmp_path / "real.npz")
    assert isinstance(back, RecordedTrajectory)
    assert back.at(np.array([0.05]))[0, 0, 0] == pytest.approx(-0.295)
    with pytest.raises(SourceError, match="recorded: motion that was recorded elsewhere cannot be simulated"):
        check_start(back.scene)


@pytest.mark.parametrize(
    ("t", "poses", "words"),
    [
        ([0.0], np.zeros((1, 2, 2)), "T at least 2"),
        ([0.0, 1.0], np.zeros((2, 2)), "expected"),
        ([0.0, 0.0], np.zeros((2, 1, 2)), "expected rising ones; sample 1 is not later"),
        ([0.0, 1.0], np.full((2, 1, 3), np.nan), "expected finite numbers"),
    ],
)
def test_invalid_poses_are_refused(t, poses, words) -> None:
    with pytest.raises(InputError, match=words):
        Trajectory.from_poses(np.array(t), poses, body=load_robot("e_puck2"), stage=Rectangle(**STAGE))


def test_divider_method_measures_speed_despite_noise() -> None:
    # 0.18 mm of noise at 30 Hz adds 20 % to the length of a slow path between samples, and 2 % with the divider method.
    t = np.arange(0, 10, 1 / 30)
    x = np.stack([0.01 * t, np.zeros_like(t)], axis=-1)[:, None]
    noisy = x + np.random.default_rng(1).normal(0, 0.00018, x.shape)
    run = Trajectory.from_poses(t, noisy, body=load_robot("gritsbot"), stage=Rectangle(**STAGE))
    assert describe(run)["speed_mean"] == pytest.approx(0.01, rel=0.06)
    assert np.abs(run.commands[..., 0]).mean() > 0.011
