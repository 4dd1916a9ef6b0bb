"""Drafts of a preregistration and a checklist: every sentence is true for ten different kits."""

import re
import shutil
from collections import Counter
from itertools import pairwise, permutations
from pathlib import Path

import pytest

from emovid.errors import InputError
from emovid.kit.export import export
from emovid.kit.exports.reporting import OPEN
from emovid.kit.folder import Kit, open_kit
from tests.helpers.tiny import LABELS, STUDY, make_kit_of_placeholders

FACTOR = "factors: {swarm: {few: {robots: 4}, many: {robots: 6}}}\n"
RATING = 'ratings: {valence: {question: "How pleasant?", low: bad, high: good, steps: 9}}\n'
OTHERS = ("surprise", "anger", "disgust", "sadness")
TWO = "".join(
    line for line in STUDY.splitlines(keepends=True) if line.removeprefix("  - scene: ").strip() not in OTHERS
)
NO_QUESTIONS = re.sub(r"demographics:\n.*\n", "", TWO)
RECORDED = STUDY.replace("scene: anger", "video: mine.mp4\n    emotion: anger")
KITS = {
    "default": (STUDY, 12),
    "unequal counts": (STUDY, 45),
    "latin": (STUDY + "orders: {scheme: latin}\n", 7),
    "random": (STUDY + "orders: {scheme: random}\nchoices: random\n", 30),
    "exemplars": (STUDY + "exemplars: 2\nhypotheses: [People see it.]\nexclusions: [Test runs.]\n", 12),
    "factor": (STUDY + FACTOR + "vary: {seed: true, turn: false, mirror: false, half_turn: false}\n", 24),
    "one of each": (STUDY + FACTOR + "exemplars: 2\norders: {shown: one_of_each}\n", 6),
    "two emotions, ratings, none": (TWO + RATING + "none_of_these: None of these\n", 100),
    "a finished video": (RECORDED + "ethics: {board: A board, approval: '17'}\nauthors: [A. Author]\n", 12),
    "one video, no questions": (
        NO_QUESTIONS.replace("  - scene: fear\n", "") + "plan: {rate: 0.9, alpha: 0.01}\n", 60
    ),
}  # fmt: skip


@pytest.fixture(scope="module", params=KITS, ids=lambda name: name.replace(" ", "-"))
def kit(request, tmp_path_factory, fresh) -> Kit:
    folder = tmp_path_factory.mktemp("kit")
    text, participants = KITS[request.param]
    (folder / "study").mkdir()
    shutil.copy(next((fresh / "public" / "videos").iterdir()), folder / "study" / "mine.mp4")
    return make_kit_of_placeholders(folder, text, participants)


def draft(kit: Kit, name: str = "preregistration.md") -> str:
    tool = "checklist" if name == "checklist.md" else "prereg"
    file = kit.folder.exports / tool / name
    if not file.exists():  # a kit keeps its drafts for all tests
        export(kit, tool)
    return file.read_text()


def fields(text: str) -> dict[str, str]:
    """Return the text under each heading, in one line."""
    parts = re.split(r"^#{2,3} (.*)\n", text, flags=re.MULTILINE)
    return {name: " ".join(body.split()) for name, body in zip(parts[1::2], parts[2::2], strict=True)}


def found(pattern: str, text: str) -> tuple[str, ...]:
    match = re.search(pattern, text)
    assert match, (pattern, text)
    return match.groups()


def spans(text: str) -> tuple[int, int]:
    numbers = [int(number) for number in re.findall(r"\d+", text)]
    return min(numbers), max(numbers)


def test_balance_describes_the_orders(kit) -> None:
    said = fields(draft(kit))["Randomization"]
    shown = {tuple(sorted(order)) for order in kit.orders.values()}
    positions, following = [], []
    for codes in shown:
        orders = [order for order in kit.orders.values() if set(order) == set(codes)]
        places = Counter((place, code) for order in orders for place, code in enumerate(order))
        pairs = Counter(pair for order in orders for pair in pairwise(order))
        positions += [places[place, code] for place in range(len(codes)) for code in codes]
        following += [pairs[pair] for pair in permutations(codes, 2)]
    rows, counted = found(r"Over the (\d+) planned rows, each video has each position ([\d to]+) times?", said)
    assert int(rows) == len(kit.orders)
    assert spans(counted) == (min(positions), max(positions))
    if following:
        (counted,) = found(r"immediately ([\d to]+) times?\.", said)
        assert spans(counted) == (min(following), max(following))
    else:
        assert "immediately" not in said
    assert ("every video once" in said) == (len(shown) == 1)
    if len(shown) > 1:
        assert f"The videos form {len(shown)} sets" in said
    equal = re.search(r"equal after every (\d+) participants", said)
    assert bool(equal) == (kit.study.orders.scheme != "random")
    if equal and len(kit.orders) % int(equal[1]) == 0:
        assert min(positions) == max(positions)
    assert f"The order of the answers is {'random' if kit.choices else 'the same'}" in said


def test_within_and_between_participants(kit) -> None:
    said = fields(draft(kit))["Study design"]
    seen = [{kit.key[code] for code in order} for order in kit.orders.values()]
    assert all(each == set(kit.key.values()) for each in seen)
    within, _, between = said.partition("etween participants")
    assert f"emotion ({len(seen[0])} level" in within
    varies = len({frozenset(order) for order in kit.orders.values()}) > 1
    for name in kit.study.factors:
        assert (f"factor {name} (few and many)" in (between if varies else within)) is True
        assert (f"factor {name} (" in (within if varies else between)) is False
    assert ("No factor varies b" in said) is not varies
    assert f"{len(kit.manifest.videos)} video" in said


def test_emotions_and_tests_follow_the_key(kit) -> None:
    model, criteria = (fields(draft(kit))[name] for name in ("Statistical models", "Inference criteria"))
    (named,) = found(r"for each emotion \(([^)]*)\)", model)
    assert re.split(r", | and ", named) == [label for label in LABELS if label in kit.key.values()]
    level, tests = found(r"familywise level of ([\d.]+), after Holm's correction for (\d+) tests", criteria)
    assert float(level) == kit.study.plan.alpha
    assert int(tests) == len(set(kit.key.values()))


def test_each_factor_needs_a_hypothesis_and_a_test(kit) -> None:
    parts = fields(draft(kit))
    for name in ("Hypotheses", "Statistical models"):
        for factor in kit.study.factors:
            assert f"Factor {factor}: {OPEN}, direction and test" in parts[name]
        assert ("The study has no factors." in parts[name]) is (not kit.study.factors)
    for factor in kit.study.factors:
        assert f"- {factor}: few and many" in parts["Manipulated variables"]


def test_simulations_and_external_videos_are_distinguished(kit) -> None:
    scenes = [item.scene for item in kit.study.stimuli if item.scene]
    videos = [item for item in kit.study.stimuli if item.video]
    for text in (fields(draft(kit))["Study design"], draft(kit, "checklist.md")):
        assert f"simulations of {len(scenes)} scene" in text
        assert ("1 finished video (" in text) is bool(videos)
    assert "simulated swarm" not in draft(kit, "checklist.md")


def test_ratings_none_option_and_groups_follow_the_study(kit) -> None:
    parts = fields(draft(kit))
    ratings = [rating.name for rating in kit.manifest.ratings]
    assert ("does not analyze them" in parts["Statistical models"]) is bool(ratings)
    for rating in kit.manifest.ratings:
        assert f"Slider from 1 ({rating.low}) to {rating.steps} ({rating.high})" in parts["Measured variables"]
    assert ("is offered" in parts["Measured variables"]) is bool(kit.study.none_of_these)
    for item in kit.manifest.demographics:
        assert f"By {item.name}." in parts["Exploratory analysis"]
    if not kit.manifest.demographics:
        assert "Groups: None." in parts["Exploratory analysis"]


def test_a_sample_below_the_plan_is_marked(kit) -> None:
    text = fields(draft(kit))["Sample size rationale"]
    (need,) = found(r"the study needs (\d+) participants", text)
    assert ("**BELOW THE PLAN**" in text) is (kit.manifest.participants < int(need))
    assert fields(draft(kit))["Sample size"] == f"{kit.manifest.participants} participants."


def test_blinding_text_names_the_variations_of_the_study(kit) -> None:
    text = fields(draft(kit))["Blinding"]
    for key, words in (("seed", "random starting positions"), ("turn", "starting phases"), ("mirror", "mirror images")):
        assert (words in text) is getattr(kit.study.vary, key)
    assert kit.manifest.key_commitment in text


def test_facts_known_only_to_the_researcher_are_left_open(kit) -> None:
    parts = fields(draft(kit))
    for name in ("Existing Data", "Stopping rule", "Is there any additional blinding in this study?"):
        assert parts[name].startswith(OPEN)
    for name, known in (
        ("Authors", kit.manifest.authors),
        ("Data exclusion", kit.study.exclusions),
        ("Hypotheses", kit.study.hypotheses or None),
    ):
        assert parts[name].startswith(OPEN) is not bool(known)
    assert (f"Approved by {OPEN}" in parts["Data collection procedures"]) is (kit.study.ethics.board is None)


def test_drafts_contain_no_video_code(kit) -> None:
    for name in ("preregistration.md", "aspredicted.md", "checklist.md"):
        text = draft(kit, name)
        assert not [code for code in kit.manifest.codes if code in text]
        assert "$" not in text


OSF = (
    "Title", "Authors", "Description", "Hypotheses", "Study type", "Blinding",
    "Is there any additional blinding in this study?", "Study design", "Randomization", "Existing Data",
    "Explanation of existing data", "Data collection procedures", "Sample size", "Sample size rationale",
    "Stopping rule", "Manipulated variables", "Measured variables", "Indices", "Statistical models", "Transformations",
    "Inference criteria", "Data exclusion", "Missing data", "Exploratory analysis",
)  # fmt: skip


def test_draft_has_the_fields_of_the_forms(fresh, tmp_path) -> None:
    export(open_kit(fresh), "prereg", tmp_path)
    headings = re.findall(r"^### (.*)$", (tmp_path / "preregistration.md").read_text(), re.MULTILINE)
    assert tuple(headings) == OSF
    numbered = re.findall(r"^## (\d)\) ", (tmp_path / "aspredicted.md").read_text(), re.MULTILINE)
    assert numbered == list("12345678")


def test_checklist_checks_only_known_facts(kit) -> None:
    items = re.findall(r"^- \[(.)\] \*\*(.*?)\.\*\* (.*)$", draft(kit, "checklist.md"), re.MULTILINE)
    assert len(items) > 20
    for mark, name, answer in items:
        assert (mark == "x") == (OPEN not in answer), name
    marks = {name: mark for mark, name, _ in items}
    assert marks["Order and counterbalancing"] == marks["Blinding"] == marks["Design"] == "x"
    assert marks["Recruitment, place and dates"] == marks["Payment"] == " "
    assert (marks["Analysis of ratings"] == "x") is not bool(kit.manifest.ratings)
    assert (marks["Ethics and consent"] == "x") is (kit.study.ethics.board is not None)
    below = "**BELOW THE PLAN**" in draft(kit)
    assert (marks["Number and its justification"] == " ") is below


def test_drafts_need_the_study_and_the_key(kit, tmp_path) -> None:
    copy = Path(shutil.copytree(kit.folder.path, tmp_path / "kit"))
    for name in ("key.csv", "study.json"):
        (copy / "private" / name).unlink()
        with pytest.raises(InputError, match=f"{name}: no such file; expected the kit's private folder"):
            export(open_kit(copy), "prereg")
