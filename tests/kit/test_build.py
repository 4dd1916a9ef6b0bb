import csv
import errno
import hashlib
import json
import os
import re
import stat
from pathlib import Path

import numpy as np
import pytest

from emovid.errors import EmovidError, InputError, SourceError
from emovid.kit.build import build
from emovid.kit.load import load_study
from emovid.kit.orders import balance_of
from emovid.kit.seeded_random import draw, is_code
from emovid.kit.stimuli import blinded, run_of, tinted
from emovid.responses.key import read_key
from emovid.responses.labels import Labels
from emovid.responses.mapping import read_mapping
from emovid.scene.load import load_scene
from emovid.swarm.simulate import simulate
from emovid.video.ffmpeg import count_frames
from tests.helpers.tiny import LABELS, SEED, STUDY, Silent, make_kit, write_study


def files(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of each file."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file()
    }


def rows(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def codes_in(kit: Path) -> list[str]:
    return sorted(path.stem for path in (kit / "public" / "videos").iterdir())


# --- contents of a kit ------------------------------------------------------------------------------------------------


def test_kit_has_exactly_the_documented_files(fresh) -> None:
    names = set(files(fresh))
    videos = {f"public/videos/{code}.mp4" for code in codes_in(fresh)}
    private = {f"private/{name}" for name in ("key.csv", "salt.txt", "seed.txt", "stimuli.csv", "study.json")}
    assert len(videos) == 6
    assert names == videos | private | {"public/manifest.json", "orders.csv", "map.yaml", "survey.json"}


def test_codes_are_random_and_the_key_has_each_emotion_once(fresh) -> None:
    key = rows(fresh / "private" / "key.csv")
    assert list(key[0]) == ["video_code", "true_emotion"]
    assert [row["video_code"] for row in key] == codes_in(fresh)
    assert all(map(is_code, codes_in(fresh)))
    assert sorted(row["true_emotion"] for row in key) == sorted(LABELS)
    assert read_key(fresh / "private" / "key.csv", Labels()) == {r["video_code"]: r["true_emotion"] for r in key}


def test_videos_have_equal_size_frame_count_and_modification_time(fresh) -> None:
    videos = list((fresh / "public" / "videos").iterdir())
    assert len({path.stat().st_size for path in videos}) == 1
    assert {count_frames(path) for path in videos} == {10}
    public = [fresh / "public", *(fresh / "public").rglob("*")]
    assert {path.stat().st_mtime for path in public} == {946_684_800.0}


def test_private_files_are_readable_only_by_the_owner(fresh) -> None:
    modes = {path: stat.S_IMODE(path.stat().st_mode) for path in (fresh / "private").iterdir()}
    assert stat.S_IMODE((fresh / "private").stat().st_mode) == 0o700
    assert set(modes.values()) == {0o600}


def test_manifest_describes_videos_and_page_texts(fresh) -> None:
    manifest = json.loads((fresh / "public" / "manifest.json").read_text())
    assert manifest["question"] == "Which emotion best described the movement of the robots in the video?"
    assert [answer["label"] for answer in manifest["choices"]["labels"]] == list(LABELS)
    assert manifest["demographics"][0]["choices"] == ["Woman", "Man", "Another gender"]
    assert manifest["consent"]["text"] == "You can stop at any time."
    assert manifest["texts"]["submit"] == "Submit answer"
    assert [video["code"] for video in manifest["videos"]] == codes_in(fresh)
    for video in manifest["videos"]:
        data = (fresh / "public" / video["file"]).read_bytes()
        assert (video["bytes"], video["sha256"]) == (len(data), hashlib.sha256(data).hexdigest())
        assert (video["width"], video["height"], video["fps"], video["frames"]) == (160, 90, 10, 10)
        known = {"code", "file", "type", "bytes", "sha256", "frames", "fps", "width", "height", "duration"}
        assert set(video) == known  # and nothing about the emotion


def test_commitment_is_the_hash_of_salt_and_key(fresh) -> None:
    manifest = json.loads((fresh / "public" / "manifest.json").read_text())
    data = b"".join((fresh / "private" / name).read_bytes() for name in ("salt.txt", "key.csv"))
    assert manifest["key_commitment"] == hashlib.sha256(data).hexdigest()
    assert re.fullmatch(r"[0-9a-f]{64}\n", (fresh / "private" / "salt.txt").read_text())


def test_orders_come_from_williams_squares(fresh) -> None:
    table = rows(fresh / "orders.csv")
    assert list(table[0]) == ["participant", "position", "video_code"]
    orders = {}
    for row in table:
        orders.setdefault(row["participant"], []).append(row["video_code"])
        assert int(row["position"]) == len(orders[row["participant"]])
    assert list(orders) == [f"P{i:03}" for i in range(1, 13)]
    found = balance_of(list(orders.values()), codes_in(fresh))
    assert (found.places_spread, found.pairs_spread) == (0, 0)


def test_map_gives_labels_and_answer_texts_to_the_analysis(fresh) -> None:
    said = read_mapping(fresh / "map.yaml")
    assert said.labels == LABELS
    assert said.answers["Happiness"] == "happiness"


# --- seeds ------------------------------------------------------------------------------------------------------------


def test_equal_seeds_give_identical_kits(fresh, tmp_path) -> None:
    make_kit(tmp_path)
    assert files(tmp_path / "kit") == files(fresh)


def test_two_kits_of_one_study_share_no_code_and_no_identical_file(fresh, tmp_path) -> None:
    built = make_kit(tmp_path, seed=SEED + 1)
    assert not set(built.codes) & set(codes_in(fresh))
    first, second = files(fresh), files(tmp_path / "kit")
    texts = {"map.yaml", "survey.json"}  # labels and their texts from the study
    assert not {d for n, d in first.items() if n not in texts} & {d for n, d in second.items() if n not in texts}


def test_random_seed_is_stored_and_reproduces_the_kit(tmp_path) -> None:
    text = STUDY.replace("duration: 1}", "duration: 0.2}")
    one, two = (make_kit(tmp_path / name, text, seed=None) for name in ("one", "two"))
    assert one.seed != two.seed
    assert min(one.seed, two.seed) > 2**200
    secret = int((tmp_path / "one" / "kit" / "private" / "seed.txt").read_text())
    make_kit(tmp_path / "again", text, seed=secret)
    assert files(tmp_path / "again" / "kit") == files(tmp_path / "one" / "kit")


def test_participants_can_be_added_to_an_existing_kit(kit, fresh, tmp_path) -> None:
    report = Silent()
    make_kit(tmp_path, participants=30, seed=None, report=report)
    assert (len(report.made), len(report.kept)) == (0, 6)
    assert rows(kit / "orders.csv")[:72] == rows(fresh / "orders.csv")
    assert len(rows(kit / "orders.csv")) == 180
    assert files(kit / "public" / "videos") == files(fresh / "public" / "videos")


# --- differences between stimuli and public scenes --------------------------------------------------------------------


def test_runs_differ_from_public_scenes_and_other_kits(tmp_path) -> None:
    loaded = load_study(write_study(tmp_path))
    runs = {}
    for seed in (1, 2):
        for item in blinded(loaded, seed):
            runs.setdefault(item.exemplar.emotion, []).append(run_of(item, seed).poses[:, :, :2])
    for first, second in runs.values():
        assert abs(first - second).max() > 0.01


@pytest.mark.parametrize("robots", [5, 6])
def test_ring_robots_start_away_from_public_start_positions(tmp_path, robots) -> None:
    # All robots look alike: a run turned by a whole spacing would equal the public picture. For an odd number, a
    # mirror image and a half turn move the ring by half a place.
    text = STUDY.replace("set: {robots: 6}", f"exemplars: 4\nset: {{robots: {robots}}}")
    loaded = load_study(write_study(tmp_path, text))
    rings = [item for seed in range(8) for item in blinded(loaded, seed) if item.exemplar.emotion == "sadness"]
    assert {(item.mirror, item.half_turn) for item in rings} == {(a, b) for a in (False, True) for b in (False, True)}
    public = simulate(rings[0].exemplar.scene).poses[0, :, :2]
    apart = np.linalg.norm(public[1] - public[0])
    for item in rings:
        start = run_of(item, SEED).poses[0, :, :2]
        assert np.linalg.norm(start[:, None] - public, axis=-1).min() > 0.2 * apart


def test_ring_with_random_starts_is_not_turned_and_lists_no_turn(tmp_path) -> None:
    text = STUDY.replace("scene: happiness", "scene: happiness\n    set: {start: {place: stage}}")
    found = {item.exemplar.emotion: item for item in blinded(load_study(write_study(tmp_path, text)), SEED)}
    assert found["surprise"].turn != 0.0 != found["sadness"].turn
    assert found["happiness"].facts()["turn"] == 0.0
    assert found["happiness"].seed is not None


def test_random_start_without_room_is_redrawn_a_limited_number_of_times(tmp_path, monkeypatch) -> None:
    loaded = load_study(write_study(tmp_path))
    tried = []

    def refused_until(most: int):
        def check(scene) -> None:
            tried.append(scene.seed)
            if len(tried) < most:
                raise SourceError("", "do not fit", key="robots")

        return check

    monkeypatch.setattr("emovid.kit.stimuli.check_start", refused_until(4))
    stimuli = blinded(loaded, SEED)
    (item,) = (item for item in stimuli if item.seed == tried[3])
    assert tried[:4] == [draw(SEED, "run", item.code, attempt) % 2**63 for attempt in range(4)]
    tried.clear()
    monkeypatch.setattr("emovid.kit.stimuli.check_start", refused_until(10**6))
    with pytest.raises(SourceError, match="do not fit"):
        blinded(loaded, SEED)
    assert len(set(tried)) == len(tried) == 50


def test_colors_vary_by_at_most_one_level_and_are_equal_within_a_kit(make_scene) -> None:
    plain, other = make_scene("anger"), make_scene("fear")
    one, two = tinted(plain, SEED).video.palette, tinted(other, SEED).video.palette
    assert one == two
    assert one != tinted(plain, SEED + 1).video.palette
    before = [plain.video.palette.stage, *plain.video.palette.trails]
    for old, new in zip(before, [one.stage, *one.trails], strict=True):
        levels = [(int(old[i : i + 2], 16), int(new[i : i + 2], 16)) for i in (1, 3, 5)]
        assert all(abs(a - b) <= 1 for a, b in levels)


def test_exemplars_of_one_emotion_rotate_in_both_directions(tmp_path) -> None:
    text = STUDY.replace("set: {robots", "exemplars: 4\nset: {robots")
    stimuli = blinded(load_study(write_study(tmp_path, text)), SEED)
    assert len(stimuli) == 24
    for label in LABELS:
        mirrors = [item.mirror for item in stimuli if item.exemplar.emotion == label]
        assert sorted(mirrors) == [False, False, True, True]
    assert len({item.turn for item in stimuli if item.exemplar.emotion == "sadness"}) == 4
    assert len({item.seed for item in stimuli if item.exemplar.emotion == "fear"}) == 4


def test_disabled_variations_keep_the_scene_unchanged(tmp_path) -> None:
    text = STUDY + "vary: {seed: false, turn: false, mirror: false, half_turn: false}\n"
    for item in blinded(load_study(write_study(tmp_path, text)), SEED):
        assert (item.seed, item.turn, item.mirror, item.half_turn) == (None, 0.0, False, False)
        public = load_scene(item.exemplar.emotion)
        assert item.exemplar.scene.seed == public.seed


# --- sets, choices, finished videos -----------------------------------------------------------------------------------


def test_one_of_each_scheme_shows_one_exemplar_per_emotion(tmp_path) -> None:
    text = STUDY.replace("duration: 1}", "duration: 0.2}") + "exemplars: 2\norders: {shown: one_of_each}\n"
    make_kit(tmp_path, text, participants=26)
    key = {row["video_code"]: row["true_emotion"] for row in rows(tmp_path / "kit" / "private" / "key.csv")}
    number = {row["video_code"]: row["exemplar"] for row in rows(tmp_path / "kit" / "private" / "stimuli.csv")}
    seen = {}
    for row in rows(tmp_path / "kit" / "orders.csv"):
        seen.setdefault(row["participant"], []).append(row["video_code"])
    assert len(key) == 12
    for i, order in enumerate(seen.values()):
        assert sorted(key[code] for code in order) == sorted(LABELS)
        assert {number[code] for code in order} == {str(i % 2)}
    for start in (0, 1):
        orders = list(seen.values())[start::2][:12]
        found = balance_of(orders, sorted(orders[0]))
        assert (found.places_spread, found.pairs_spread) == (0, 0)


def test_answers_in_random_order_are_recorded_with_the_orders(tmp_path) -> None:
    text = STUDY.replace("duration: 1}", "duration: 0.2}") + "choices: random\nnone_of_these: None of these\n"
    make_kit(tmp_path, text)
    table = rows(tmp_path / "kit" / "orders.csv")
    drawn = {row["participant"]: row["choices"].split("|") for row in table}
    assert all(sorted(choices) == sorted([*LABELS, "none"]) for choices in drawn.values())
    assert len({tuple(choices) for choices in drawn.values()}) > 8
    assert len({(row["participant"], row["choices"]) for row in table}) == 12


def test_external_video_is_reencoded_like_the_others(fresh, tmp_path) -> None:
    folder = write_study(tmp_path / "study", STUDY.replace("scene: anger", "video: mine.mp4\n    emotion: anger"))
    source = (fresh / "public" / "videos" / f"{codes_in(fresh)[0]}.mp4").read_bytes()
    (folder / "mine.mp4").write_bytes(source)
    loaded = load_study(folder)
    build(loaded, tmp_path / "kit", 6, SEED, Silent())
    build(loaded, tmp_path / "other", 6, SEED + 1, Silent())
    assert len({path.stat().st_size for path in (tmp_path / "kit" / "public" / "videos").iterdir()}) == 1
    made = set(files(tmp_path / "kit" / "public" / "videos").values())
    assert hashlib.sha256(source).hexdigest() not in made
    assert not made & set(files(tmp_path / "other" / "public" / "videos").values())


# --- existing files ---------------------------------------------------------------------------------------------------


def test_only_missing_or_changed_files_are_rebuilt(kit, fresh, tmp_path) -> None:
    missing, changed, *others = codes_in(kit)
    (kit / "public" / "videos" / f"{missing}.mp4").unlink()
    broken = kit / "public" / "videos" / f"{changed}.mp4"
    broken.write_bytes(broken.read_bytes()[:-1000])
    report = Silent()
    make_kit(tmp_path, seed=None, report=report)
    assert report.made == [missing, changed]
    assert report.kept == others
    assert files(kit) == files(fresh)


class Interrupted(Exception):  # noqa: N818 - stands for a signal
    pass


class Interrupting(Silent):
    """Interrupts the third video in its middle."""

    def advanced(self, frames: int) -> None:
        if len(self.made) == 2 and frames == 5:
            raise Interrupted


def test_interrupted_build_leaves_no_partial_file_and_can_be_resumed(fresh, tmp_path) -> None:
    with pytest.raises(Interrupted):
        make_kit(tmp_path, report=Interrupting())
    left = files(tmp_path / "kit")
    assert len([name for name in left if name.startswith("public/")]) == 2
    assert not [name for name in left if "part" in name or "manifest" in name]
    report = Silent()
    make_kit(tmp_path, seed=None, report=report)
    assert (len(report.kept), len(report.made)) == (2, 4)
    assert files(tmp_path / "kit") == files(fresh)


def test_kit_of_another_seed_or_study_is_not_changed(kit, fresh, tmp_path) -> None:
    with pytest.raises(InputError, match="contains a kit with another seed; expected that seed, another folder,"):
        make_kit(tmp_path, seed=1)
    with pytest.raises(InputError, match="contains a kit of another study or of an earlier version"):
        make_kit(tmp_path, STUDY.replace("Thank you.", "Thanks."), seed=None)
    assert files(kit) == files(fresh)


def test_force_replaces_the_old_kit_completely(kit, fresh, tmp_path) -> None:
    built = make_kit(tmp_path, STUDY.replace("Thank you.", "Thanks."), seed=SEED + 1, force=True)
    assert codes_in(kit) == list(built.codes)
    assert not set(codes_in(kit)) & set(codes_in(fresh))


def test_no_key_is_written_to_a_folder_that_cannot_be_made_private(tmp_path, monkeypatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(Path, "chmod", refuse)
    with pytest.raises(EmovidError, match="kit/private: cannot be made private: operation not permitted"):
        make_kit(tmp_path)
    assert files(tmp_path / "kit") == {}


@pytest.mark.parametrize("how", [{"seed": 5}, {"text": STUDY.replace("Thank you.", "Thanks.")}], ids=["seed", "study"])
def test_kit_with_answers_keeps_its_key_even_with_force(kit, fresh, tmp_path, how) -> None:
    (kit / "answers").mkdir()
    (kit / "answers" / "answers.sqlite").write_bytes(b"")
    with pytest.raises(InputError, match=r"kit/answers: contains answers to the existing kit; move them away"):
        make_kit(tmp_path, **{"seed": None, "force": True, **how})
    assert files(kit) == files(fresh) | {"answers/answers.sqlite": hashlib.sha256(b"").hexdigest()}
    (kit / "public" / "videos" / f"{codes_in(kit)[0]}.mp4").write_bytes(b"")
    make_kit(tmp_path, seed=None, force=True)  # of the same study and seed
    assert files(kit / "public") == files(fresh / "public")


@pytest.mark.parametrize("force", [False, True])
def test_folder_with_other_files_is_refused(tmp_path, force) -> None:
    (tmp_path / "kit").mkdir()
    (tmp_path / "kit" / "thesis.tex").write_text("all my work")
    with pytest.raises(InputError, match="is not empty and contains no kit; expected a new folder, or a kit"):
        make_kit(tmp_path, force=force)
    (tmp_path / "kit" / "thesis.tex").unlink()
    (tmp_path / "kit").rmdir()
    (tmp_path / "kit").write_text("a file")
    with pytest.raises(InputError, match="is a file; expected a folder"):
        make_kit(tmp_path, force=force)
