"""Each kind of leak is planted and found; a new kit has no findings."""

import hashlib
import json
import os
import shutil
import struct
import subprocess
from pathlib import Path

import pytest

from emovid.errors import InputError
from emovid.kit.audit import audit
from emovid.kit.build import build
from emovid.kit.export import export
from emovid.kit.folder import open_kit, set_times
from emovid.kit.load import load_study
from emovid.kit.mp4 import boxes
from emovid.scene.load import Setting, load_scene, scene_digest
from emovid.swarm.simulate import simulate
from emovid.video.render import render_video
from tests.helpers.tiny import LABELS, SEED, STUDY, Silent, make_kit, write_study


class Found(set):
    """The checks with findings, and their messages."""

    def __init__(self, kit: Path, **how) -> None:
        findings = audit(kit, **how).findings
        super().__init__(finding.check for finding in findings)
        self.text = "\n".join(finding.unblinded for finding in findings)


def a_video(kit: Path, emotion: str = "fear") -> Path:
    key = open_kit(kit).key
    return kit / "public" / "videos" / f"{next(code for code in key if key[code] == emotion)}.mp4"


def change_manifest(kit: Path, change) -> None:
    path = kit / "public" / "manifest.json"
    manifest = json.loads(path.read_text())
    change(manifest)
    path.write_text(json.dumps(manifest, indent=2))
    set_times(kit / "public")


def replace_video(kit: Path, video: Path, data: bytes) -> None:
    """Replace the bytes of a video, and update the manifest."""
    video.write_bytes(data)

    def describe(manifest) -> None:
        for entry in manifest["videos"]:
            if entry["code"] == video.stem:
                entry |= {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}

    change_manifest(kit, describe)


def test_new_kit_has_no_findings(fresh) -> None:
    result = audit(fresh)
    assert [str(finding) for finding in result.findings] == []
    assert set(result.checks.values()) == {0}
    assert len(result.checks) == 13


@pytest.mark.parametrize(("scheme", "participants"), [("random", 7), ("latin", 25), ("williams", 1), ("williams", 45)])
def test_new_kit_has_no_findings_for_any_scheme_and_number_of_participants(tmp_path, scheme, participants) -> None:
    text = STUDY + f"orders: {{scheme: {scheme}}}\n"
    make_kit(tmp_path, text, participants=participants)
    assert audit(tmp_path / "kit").findings == ()


# --- names, times, files ----------------------------------------------------------------------------------------------


def test_audit_finds_a_video_named_after_its_emotion(kit) -> None:
    video = a_video(kit)
    shutil.copy(video, video.with_name("fear.mp4"))
    set_times(kit / "public")
    found = Found(kit)
    assert found == {"files", "names"}
    assert "public/videos/fear.mp4: names an emotion: fear" in found.text


def test_audit_finds_a_folder_named_after_an_emotion(kit) -> None:
    (kit / "public" / "angry_swarm").mkdir()
    set_times(kit / "public")
    assert Found(kit) == {"files", "names"}


def test_audit_finds_codes_chosen_by_hand(kit) -> None:
    video = a_video(kit)
    video.rename(video.with_name("v1.mp4"))
    change_manifest(kit, lambda m: [
        entry.update(code="v1", file="videos/v1.mp4") for entry in m["videos"] if entry["code"] == video.stem
    ])  # fmt: skip
    assert {"names", "key", "orders"} <= Found(kit)


def test_audit_finds_a_video_with_a_different_modification_time(kit) -> None:
    os.utime(a_video(kit), (1_700_000_000, 1_700_000_000))
    assert Found(kit) == {"times"}


def test_audit_of_a_copy_with_new_times_names_working_remedies(fresh, tmp_path) -> None:
    for how in ("-r", "-a"):
        subprocess.run(["cp", how, fresh, tmp_path / how[1:]], check=True)  # noqa: S607 - whichever cp one has
    assert audit(tmp_path / "a").findings == ()
    found = Found(tmp_path / "r")
    assert found == {"times"}
    assert "copy the kit with cp -a, or build it again with its seed" in found.text
    build(load_study(fresh.parent / "study"), tmp_path / "r", 12, SEED, Silent())
    assert audit(tmp_path / "r").findings == ()


def test_kit_in_a_folder_named_like_a_protocol_is_audited(fresh, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(fresh, "10:30")
    assert audit(Path("10:30")).findings == ()


def test_audit_finds_a_foreign_file(kit) -> None:
    (kit / "public" / "key.csv").write_bytes((kit / "private" / "key.csv").read_bytes())
    set_times(kit / "public")
    assert Found(kit) == {"files", "pages"}


def test_audit_finds_a_link_into_the_private_folder(kit) -> None:
    (kit / "public" / "videos.txt").symlink_to(kit / "private" / "map")
    assert "files" in Found(kit)


def test_audit_finds_a_private_folder_readable_by_others(kit) -> None:
    (kit / "private" / "key.csv").chmod(0o644)
    assert Found(kit) == {"permissions"}
    (kit / "private").chmod(0o755)
    assert len(audit(kit).findings) == 2


def test_audit_finds_a_missing_video(kit) -> None:
    a_video(kit).unlink()
    set_times(kit / "public")
    assert Found(kit) == {"files"}


# --- text -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "page",
    [
        '<video src="videos/CODE.mp4" data-emotion="fear"></video>',
        "<!-- CODE is the fear one -->",
        "videos = {'CODE': 'Fear'}",
        '[{"code": "CODE",\n  "class": "sc\\u0061red", "n": 1, "label": "scared"}]',
        "const answer = {\n  stimulus: 'CODE',\n  correct: 'fear',\n};",
        "CODE;afraid\n",
        '{"code": "CODE",\n "tags": ["a", "b"],\n "emotion": "fear"}',
        '<a title="fearful swarm" href="CODE.mp4">watch</a>',
    ],
    ids=["attribute", "comment", "object", "json", "lines", "table", "nested", "synonym"],
)
def test_audit_finds_an_emotion_next_to_a_code(kit, page) -> None:
    path = kit / "exports" / "jspsych" / "index.html"
    path.parent.mkdir(parents=True)
    path.write_text(page.replace("CODE", a_video(kit).stem))
    found = Found(kit)
    assert found == {"pages"}
    assert f"names an emotion next to {a_video(kit).stem}: fear" in found.text


def test_list_of_answers_on_a_page_is_not_a_leak(kit) -> None:
    path = kit / "exports" / "mine" / "page.html"
    path.parent.mkdir(parents=True)
    answers = "".join(f"<option>{label}</option>" for label in LABELS)
    path.write_text(f'<video src="videos/{a_video(kit).stem}.mp4"></video><select>{answers}</select>')
    assert Found(kit) == set()


def test_audit_finds_a_preload_list_in_emotion_order(kit) -> None:
    key = open_kit(kit).key
    in_order = sorted(key, key=lambda code: LABELS.index(key[code]))
    assert in_order != sorted(in_order)
    path = kit / "exports" / "jspsych" / "preload.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps([f"videos/{code}.mp4" for code in in_order]))
    assert Found(kit) == {"pages"}
    path.write_text(json.dumps([f"videos/{code}.mp4" for code in sorted(in_order)]))
    assert Found(kit) == set()


def test_audit_finds_a_manifest_in_emotion_order(kit) -> None:
    key = open_kit(kit).key
    change_manifest(kit, lambda m: m["videos"].sort(key=lambda entry: LABELS.index(key[entry["code"]])))
    assert Found(kit) == {"names", "pages"}


def test_audit_finds_emotions_in_the_manifest(kit) -> None:
    key = open_kit(kit).key
    change_manifest(kit, lambda m: [entry.update(emotion=key[entry["code"]]) for entry in m["videos"]])
    assert Found(kit) == {"manifest", "pages"}


def test_audit_finds_numbers_that_identify_emotions_in_the_manifest(kit) -> None:
    change_manifest(kit, lambda m: [entry.update(group=i) for i, entry in enumerate(m["videos"])])
    found = Found(kit)
    assert found == {"manifest"}
    assert "unknown key videos.0.group" in found.text


@pytest.mark.parametrize("what", ["seed", "salt", "scene", "run"])
def test_audit_finds_secrets_and_digests_in_public_text(kit, what) -> None:
    texts = {
        "seed": (kit / "private" / "seed.txt").read_text,
        "salt": (kit / "private" / "salt.txt").read_text,
        "scene": lambda: scene_digest(load_scene("fear")),
        "run": lambda: simulate(load_scene("fear")).digest(),
    }
    change_manifest(kit, lambda m: m.update(instructions=f"Watch. {texts[what]().strip()}"))
    assert Found(kit) == {"secrets"}


# --- inside videos ----------------------------------------------------------------------------------------------------


def test_audit_finds_tags_in_a_video(kit) -> None:
    video = a_video(kit)
    data = video.read_bytes()
    place = data.index(b"udta") - 4
    size = struct.unpack_from(">I", data, place)[0]
    name = b"\xa9nam" + b"my fearful swarm".ljust(size - 16, b"\0")
    tagged = data[: place + 8] + struct.pack(">I", size - 8) + name + data[place + size :]
    replace_video(kit, video, tagged)
    assert Found(kit) == {"metadata", "strings"}


def test_audit_finds_a_track_name_and_foreign_boxes(kit) -> None:
    video = a_video(kit)
    data = video.read_bytes().replace(b"VideoHandler", b"crowd swarm!").replace(b"vmhd", b"gmhd")
    replace_video(kit, video, data)
    found = Found(kit)
    assert "metadata" in found
    assert f"metadata: videos/{video.name}: name of a track\n" in found.text
    assert f"metadata: videos/{video.name}: unexpected box 'gmhd'\n" in found.text


def test_audit_finds_a_date_in_a_video(kit) -> None:
    video = a_video(kit)
    data = bytearray(video.read_bytes())
    (header,) = (box for box in boxes(bytes(data)) if box.kind == "mvhd")
    struct.pack_into(">I", data, header.start + 12, 3_800_000_000)
    replace_video(kit, video, bytes(data))
    found = Found(kit)
    assert found == {"metadata"}
    assert "time stamp in mvhd" in found.text


def test_audit_finds_words_in_the_padding_of_a_video(kit) -> None:
    video = a_video(kit, "sadness")
    data = video.read_bytes()
    replace_video(kit, video, data[:-30] + b"a sad swarm".ljust(30, b"\0"))
    assert Found(kit) == {"metadata", "strings"}


def test_audit_finds_an_encoder_message_in_the_stream(kit) -> None:
    video = a_video(kit)
    data = bytearray(video.read_bytes())
    (stream,) = (box for box in boxes(bytes(data)) if box.kind == "mdat")
    data[stream.start + 8 + 4] = 6  # the first unit becomes supplemental information
    replace_video(kit, video, bytes(data))
    found = Found(kit)
    assert {"metadata"} <= found
    assert "units of kind 6 in the stream" in found.text


def test_audit_finds_a_file_that_is_not_a_video(kit) -> None:
    replace_video(kit, a_video(kit), b"fear " * 1000)
    assert {"metadata", "videos", "alike"} <= Found(kit)


def test_audit_finds_a_truncated_video(kit) -> None:
    video = a_video(kit)
    video.write_bytes(video.read_bytes()[:-2000])
    set_times(kit / "public")
    assert "videos" in Found(kit)


@pytest.mark.parametrize(("keys", "check"), [({"duration": 2}, "videos"), ({"video.fps": 20}, "alike")])
def test_audit_finds_a_video_of_another_length_or_rate(kit, tmp_path, keys, check) -> None:
    settings = {"video.size": "160x90", "video.fps": 10, "duration": 1, "robots": 6, "seed": 99} | keys
    scene = load_scene("fear", [Setting(key, value, "test") for key, value in settings.items()])
    render_video(simulate(scene), tmp_path / "other.mp4")
    replace_video(kit, a_video(kit), (tmp_path / "other.mp4").read_bytes())
    assert {check, "alike"} <= Found(kit)


def test_audit_finds_a_wrong_video_size_in_the_manifest(kit) -> None:
    change_manifest(kit, lambda m: m["videos"][0].update(width=80))
    found = Found(kit)
    assert found == {"videos", "alike"}
    assert "not 80x90 pixels large" in found.text


def test_audit_handles_a_kit_without_valid_videos(kit) -> None:
    for video in (kit / "public" / "videos").iterdir():
        video.write_bytes(video.stem.encode())
    assert {"metadata", "videos"} <= Found(kit)


def test_audit_finds_a_copy_of_another_stimulus(kit) -> None:
    replace_video(kit, a_video(kit, "fear"), a_video(kit, "anger").read_bytes())
    assert Found(kit) == {"alike"}


def test_audit_finds_runs_of_public_scenes_as_stimuli(tmp_path) -> None:
    make_kit(tmp_path, STUDY.replace("set: {robots: 6}\n", ""))
    kit = tmp_path / "kit"
    assert Found(kit) == set()
    for emotion in LABELS:
        keys = {"video.size": "160x90", "video.fps": 10, "duration": 1, "video.colours.stage": "#fafaf8"}
        scene = load_scene(emotion, [Setting(key, value, "test") for key, value in keys.items()])
        render_video(simulate(scene), tmp_path / "public.mp4")
        replace_video(kit, a_video(kit, emotion), (tmp_path / "public.mp4").read_bytes())
    found = Found(kit)
    assert found == {"alike", "scenes"}  # they were not padded to equal length, either
    for emotion in LABELS:
        assert f"{a_video(kit, emotion).name}: shows the run of a public scene: {emotion}" in found.text


def test_study_without_variation_is_reported_as_public_scenes(tmp_path) -> None:
    text = STUDY.replace("set: {robots: 6}\n", "vary: {seed: false, turn: false, mirror: false, half_turn: false}\n")
    make_kit(tmp_path, text)
    found = audit(tmp_path / "kit").findings
    assert [finding.check for finding in found] == 6 * ["scenes"]


# --- key and orders ---------------------------------------------------------------------------------------------------


def test_audit_finds_a_key_that_contradicts_the_commitment(kit) -> None:
    key = kit / "private" / "key.csv"
    key.write_text(key.read_text().replace("fear", "x").replace("anger", "fear").replace("x", "anger"))
    assert "not the key to which the manifest commits" in Found(kit).text


def test_a_published_key_is_checked_without_the_private_folder(kit, tmp_path) -> None:
    published = tmp_path / "published"
    published.mkdir()
    for name in ("key.csv", "salt.txt"):
        (kit / "private" / name).rename(published / name)
    shutil.rmtree(kit / "private")
    assert Found(kit) == set()
    assert Found(kit, key=published / "key.csv") == set()
    (published / "salt.txt").write_text("0" * 64 + "\n")
    assert Found(kit, key=published / "key.csv") == {"key"}


def test_audit_finds_a_key_without_its_salt(kit) -> None:
    (kit / "private" / "salt.txt").unlink()
    assert "salt.txt: missing: the commitment to the key cannot be checked without it" in Found(kit).text


def test_audit_finds_missing_orders(kit) -> None:
    (kit / "orders.csv").unlink()
    found = audit(kit)
    assert [str(finding) for finding in found.findings] == ["orders: orders.csv: missing"]
    assert found.orders is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: lines[:-1], "P012 sees 5 videos in 5 positions, not 6"),
        (lambda lines: lines[:-6], "11 participants; the manifest has 12"),
        (lambda lines: [*lines[:-1], lines[-1][:7] + "zzzzzz"], "P012 sees zzzzzz, which is not in the kit"),
        (lambda lines: lines[:7] * 1 + [f"P{i:03}{row[4:]}" for i in range(2, 13) for row in lines[1:7]],
         "counts of positions differ by 12; expected at most 0 for williams"),
        (lambda lines: [*lines, "P012,7" + lines[-1][6:]], "P012 sees 6 videos in 7 positions, not 6"),
    ],
    ids=["a video missing", "a participant missing", "an unknown code", "one order for all", "a video twice"],
)  # fmt: skip
def test_audit_finds_orders_that_differ_from_the_plan(kit, change, message) -> None:
    path = kit / "orders.csv"
    path.write_text("\n".join(change(path.read_text().splitlines())) + "\n")
    found = Found(kit)
    assert found == {"orders"}
    assert message in found.text


def test_audit_finds_orders_without_neighbor_balance(kit) -> None:
    codes = sorted(open_kit(kit).manifest.codes)
    cyclic = [codes[i:] + codes[:i] for i in range(6)] * 2
    rows = [f"P{p:03},{i},{code}" for p, order in enumerate(cyclic, 1) for i, code in enumerate(order, 1)]
    (kit / "orders.csv").write_text("\n".join(["participant,position,video_code", *rows, ""]))
    assert Found(kit).text == "orders: orders.csv: counts of neighbors differ by 10; expected at most 0 for williams"


def test_audit_reports_the_balance_after_dropouts(kit, tmp_path) -> None:
    lines = (kit / "orders.csv").read_text().splitlines()[1:]
    kept = [line for line in lines if not line.startswith(("P003", "P004"))][:-2]
    answers = ["participant,video,position,response"]
    for line in kept:
        participant, position, code = line.split(",")
        answers.append(f"{participant},{code},{position},fear")
    (tmp_path / "responses.csv").write_text("\n".join(answers) + "\n")
    left = audit(kit, responses=[tmp_path / "responses.csv"]).left
    assert (left.participants, left.complete, left.answers) == (10, 9, 58)
    assert left.balance.places.sum() == 58
    assert left.balance.places_range[1] == 2


def test_balance_of_answers_without_positions_uses_the_orders(kit, tmp_path) -> None:
    code = open_kit(kit).orders["P001"][2]
    (tmp_path / "responses.csv").write_text(f"participant,video,response\nP001,{code},fear\nsomebody,{code},fear\n")
    left = audit(kit, responses=[tmp_path / "responses.csv"]).left
    assert (left.participants, left.complete, left.answers_without_position) == (2, 0, 1)
    assert left.balance.places[left.balance.videos.index(code)].tolist() == [0, 0, 1, 0, 0, 0]
    (kit / "private").rename(tmp_path / "elsewhere")
    with pytest.raises(
        InputError, match=r"private/key\.csv: no such file; expected the key, to read the responses with"
    ):
        audit(kit, responses=[tmp_path / "responses.csv"])
    assert audit(kit, tmp_path / "elsewhere" / "key.csv", [tmp_path / "responses.csv"]).left.facts() == left.facts()


# --- reports, and folders that are not kits ---------------------------------------------------------------------------


def test_video_sizes_are_listed_by_content_size(fresh) -> None:
    rows = audit(fresh).sizes
    assert len({row.bytes for row in rows}) == 1
    needed = [row.content_bytes for row in rows]
    assert needed == sorted(needed)
    assert needed[-1] == rows[0].bytes - 8
    assert {row.emotion for row in rows} == set(LABELS)
    assert rows[0].kbit_per_s == pytest.approx(needed[0] * 8 / 1000, abs=0.1)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (shutil.rmtree, "no such folder; expected a kit"),
        (lambda kit: (kit / "public/manifest.json").unlink(), "expected the manifest of a finished kit"),
        (lambda kit: (kit / "public/manifest.json").write_text("{"), "not JSON; expected the manifest of a kit"),
        (lambda kit: (kit / "public/manifest.json").write_text("[]"), "not the manifest of a kit"),
        (lambda kit: change_manifest(kit, lambda m: m.pop("question")), "question: missing"),
        (
            lambda kit: change_manifest(kit, lambda m: m.update(format="other")),
            "format: 'other': expected emovid kit 1",
        ),
        (lambda kit: change_manifest(kit, lambda m: m["videos"].clear()), "videos: []: expected at least 1"),
        (lambda kit: change_manifest(kit, lambda m: m["videos"][0].update(duration=0)), "expected more than 0"),
        (lambda kit: (kit / "orders.csv").write_text("a,b\n1,2\n"), "orders.csv:2: expected participant,position"),
        (lambda kit: (kit / "orders.csv").write_bytes(b"participant\xff\n"), "orders.csv: not CSV; expected partic"),
        (lambda kit: (kit / "orders.csv").unlink() or (kit / "orders.csv").mkdir(), "orders.csv: cannot be read: is"),
        (lambda kit: (kit / "private/study.json").write_text("{}"), "study.json: not the study of a kit"),
        (lambda kit: (kit / "private/key.csv").write_text("a\n"), "key.csv:1: no column video_code"),
    ],
    ids=["folder", "no manifest", "no json", "a list", "no question", "format", "no videos", "no duration", "orders",
         "orders in Latin-1", "orders a folder", "study", "key"],
)  # fmt: skip
def test_folder_that_is_not_a_kit_gives_a_one_line_message(kit, spoil, message) -> None:
    spoil(kit)
    with pytest.raises(InputError, match=r".") as caught:
        audit(kit)
    assert message in str(caught.value)


def test_external_video_named_with_a_digit_gives_no_finding(fresh, tmp_path) -> None:
    folder = write_study(tmp_path / "study", STUDY.replace("scene: anger", "video: 1.mp4\n    emotion: anger"))
    shutil.copy(a_video(fresh), folder / "1.mp4")
    make_kit(tmp_path, (folder / "study.yaml").read_text())
    kit = tmp_path / "kit"
    export(open_kit(kit), "psychopy")
    assert [str(finding) for finding in audit(kit).findings] == []
