from pathlib import Path

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from emovid.errors import SourceError
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import parse_scene, scene_text
from emovid.yaml_source import read_value, read_yaml

CONFIGS = Path(__file__).parents[2] / "configs"
SHIPPED = {emotion: (CONFIGS / f"{emotion}.yaml").read_text(encoding="utf-8") for emotion in EMOTIONS}


def value_of(text):
    return read_yaml(f"key: {text}\n", "scene.yaml")[0]["key"]


def scene_or_error(text):
    try:
        return parse_scene(text, "scene.yaml")
    except SourceError as error:
        return error


def assert_scene_or_one_line(text):
    found = scene_or_error(text)
    if isinstance(found, SourceError):
        assert str(found).startswith("scene.yaml")
        assert len(str(found).splitlines()) == 1
    else:
        assert parse_scene(scene_text(found), "again.yaml").resolved() == found.resolved()


# --- values ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("15", 15), ("+2", 2), ("-3", -3), ("-0", 0), ("007", 7), ("08", 8), ("0x10", 16), ("0xfF", 255), ("0o17", 15),
        ("1e-3", 0.001), ("1E3", 1000.0), ("1e+3", 1000.0), ("+1e3", 1000.0), ("6.5", 6.5), (".5", 0.5), ("-.5", -0.5),
        ("5.", 5.0), ("5.e2", 500.0), ("1.0", 1.0), ("-0.0", -0.0), ("00.5", 0.5), ("1e999", float("inf")),
        (".inf", float("inf")), ("-.Inf", float("-inf")), ("+.INF", float("inf")), (".nan", float("nan")),
        (".NaN", float("nan")),
    ],
)  # fmt: skip
def test_numbers_are_read(text, number):
    assert repr(value_of(text)) == repr(number)  # by repr: 1 is not 1.0, -0.0 not 0.0, and nan is nan


@pytest.mark.parametrize(
    "text",
    [
        "on", "On", "off", "OFF", "yes", "Yes", "no", "NO", "y", "n", "1:30", "1:30.5", "2020-01-01",
        "2020-01-01 10:00:00", "1_000", "0b11", "=", "<<", "nan", "inf", "None", "nil", "1e", "e3", "0,275", "15s",
        "1280x720", "+", "-.", "0x", "١٥",
    ],
)  # fmt: skip
def test_quoted_and_plain_text_stays_text(text):
    assert value_of(text) == text


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True), ("True", True), ("TRUE", True), ("false", False), ("False", False), ("null", None),
        ("Null", None), ("~", None), ("", None), ("# nothing", None), ("#112233", None), ('"15"', "15"),
        ("'true'", "true"), ('"#112233"', "#112233"), ('""', ""),
    ],
)  # fmt: skip
def test_words_and_quoted_text_are_read(text, value):
    assert value_of(text) is value if value in (True, False, None) else value_of(text) == value


@pytest.mark.parametrize("key", ["on", "no", "1", "null", "1e3", "2020-01-01", "<<", "="])
def test_keys_are_read_as_text(key):
    assert read_yaml(f"{key}: 1\n", "scene.yaml")[0] == {key: 1}


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-3", 0.001), ("#112233", "#112233"), ("", None), ("  ", None), ("[1, 2]", [1, 2]), ("{a: b}", {"a": "b"})],
)
def test_single_values_are_read(text, value):
    assert read_value(text, "--set x") == value


@pytest.mark.parametrize("text", ["[", "a: b: c", "*a", "!x 1", "1\n---\n2"])
def test_an_invalid_single_value_names_the_option_without_a_line(text):
    with pytest.raises(SourceError) as caught:
        read_value(text, "--set x")
    assert caught.value.where == "--set x"


# --- lines -----------------------------------------------------------------------------------------------------------

PLACED = """\
# a comment

emotion: fear
behaviour:  # another

  density:
    kind: uniform
start:
  poses:
    - x: 1
      y: 2
    -
      x: 3
stage: {width: 1,
  height: 2}
"""
LINES = {
    (): 3,
    ("emotion",): 3,
    ("behaviour",): 4,
    ("behaviour", "density"): 6,
    ("behaviour", "density", "kind"): 7,
    ("start",): 8,
    ("start", "poses"): 9,
    ("start", "poses", 0): 10,
    ("start", "poses", 0, "x"): 10,
    ("start", "poses", 0, "y"): 11,
    ("start", "poses", 1): 13,
    ("start", "poses", 1, "x"): 13,
    ("stage",): 14,
    ("stage", "width"): 14,
    ("stage", "height"): 15,
}


@pytest.mark.parametrize("line_break", ["\n", "\r\n"])
def test_values_have_file_and_line(line_break):
    places = read_yaml(PLACED.replace("\n", line_break), "a/b.yaml")[1]
    assert places == {path: f"a/b.yaml:{line}" for path, line in LINES.items()}


# --- refusals --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "f.yaml: empty: expected a scene"),
        ("# only a comment\n", "f.yaml: empty: expected a scene"),
        ("a: 1\nb: 2\na: 3\n", "f.yaml:3: a: given twice (first on line 1)"),
        ("a:\n  b: 1\n  c: 2\n  b: 3\n", "f.yaml:4: a.b: given twice (first on line 2)"),
        ("a: 1\n? [b]\n: 2\n", "f.yaml:2: a key must be a word"),
        ("a: !b 1\n", "f.yaml:1: a: tags such as !b are not supported"),
        ("a: !!python/name:os.system ''\n", "f.yaml:1: a: tags such as !!python/name:os.system are not supported"),
        ("a: 1\n<<: *b\n", "f.yaml:2: not YAML: anchors and aliases are not supported"),
        ("a: 1\n--- \nb: 2\n", "f.yaml:2: not YAML: found another document"),
        ("a: " + "9" * 41, f"f.yaml:1: a: '{'9' * 40}' is not a valid int"),
        ("a: \x00", "f.yaml: not YAML: unacceptable character #x0000: special characters are not allowed"),
        ("[" * 5000, "f.yaml: not a scene: nested too deeply"),
    ],
)
def test_unsupported_yaml_is_refused(text, message):
    with pytest.raises(SourceError) as caught:
        read_yaml(text, "f.yaml")
    assert str(caught.value) == message


@pytest.mark.parametrize(
    "text", ["a: !!float 15", "a: !!str b", "a: ! b", "a: !!map {}", "a: !!seq []", "!!map {a: 1}"]
)
def test_tags_are_refused_even_where_they_change_nothing(text):
    with pytest.raises(SourceError, match="tags"):
        read_yaml(text, "f.yaml")


@pytest.mark.parametrize("text", ["a: &b 1", "a: &b {}", "a: &b []", "&b {a: 1}", "a: &b 1\nc: *b", "a: &b [*b]"])
def test_anchors_are_refused_used_or_not(text):
    with pytest.raises(SourceError, match="anchors"):
        read_yaml(text, "f.yaml")


def test_key_with_a_line_break_gives_a_one_line_message():
    with pytest.raises(SourceError) as caught:
        parse_scene(SHIPPED["fear"] + '"a\\nb\\u2028c": 1\n', "f.yaml")
    assert len(str(caught.value).splitlines()) == 1
    assert "unknown key" in str(caught.value)


@pytest.mark.parametrize("text", ['"\\U00110000": 1', 'a: "\\UFFFFFFFF"', f"%YAML {'9' * 5000}.1\n---\na: 1"])
def test_numbers_beyond_python_limits_are_refused(text):
    with pytest.raises(SourceError, match=r"^f\.yaml.*not YAML: "):
        read_yaml(text, "f.yaml")


# --- arbitrary input -------------------------------------------------------------------------------------------------

PUNCTUATION = " \n\t:-#[]{}&*!|>'\"%@`,?\\~.=<ax01eEUu"


@given(st.text() | st.text(alphabet=PUNCTUATION))
@example('"\\ud800": 1')  # an unpaired surrogate
@example("\ud800")
@example("? ")
@settings(max_examples=300)
def test_any_text_gives_a_scene_or_a_one_line_error(text):
    assert_scene_or_one_line(text)


ODD_SCALARS = [
    "", "null", "true", "false", ".nan", ".inf", "-.inf", "-1", "0", "-0.0", "1e-320", "1e999", "1e9", "0.5", "15.0",
    "0x10", "007", '""', '"15"', '"a\\nb"', '"\\U00110000"', '"#112233"', "#112233", "text", "[]", "{}", "[[]]",
    "[1]", "{x: 1}", "- x", "? x", "*a", "&a 1", "!!float 1", "!", "|", ">", "%", "@", "`", '"', "'", ",", ":", "]",
    "}", "\t", "\x07", "\x85", "\u2028", "\U0001f916", "contour", "coverage", "circle", "uniform", "gaussian",
    "boundary", "stage", "region", "poses", "single_integrator", "64x64", "0x0",
]  # fmt: skip
ODD_LINES = [
    "",
    "---",
    "...",
    "- 1",
    "  ",
    "\t",
    "x",
    "x: 1",
    "  x: 1",
    "    - x: 1",
    '"a\\nb": 1',
    "<<: *a",
    "%YAML 1.1",
]


@st.composite
def edited_scenes(draw):
    lines = SHIPPED[draw(st.sampled_from(sorted(SHIPPED)))].splitlines()
    lines = [line for line in lines if line and not line.startswith("#")]
    for _ in range(draw(st.integers(1, 3))):
        i = draw(st.integers(0, len(lines) - 1))
        match draw(st.sampled_from(["delete", "duplicate", "replace", "indent", "move", "value", "value", "value"])):
            case "delete":
                del lines[i]
            case "duplicate":
                lines.insert(draw(st.integers(0, len(lines))), lines[i])
            case "replace":
                lines[i] = draw(st.sampled_from(ODD_LINES) | st.text(max_size=20))
            case "indent":
                lines[i] = draw(st.sampled_from(["", " ", "  ", "    ", "\t"])) + lines[i].lstrip()
            case "move":
                lines.append(lines.pop(i))
            case "value":
                key, colon, _ = lines[i].partition(":")
                odd = draw(st.sampled_from(ODD_SCALARS) | st.integers().map(str) | st.floats().map(str) | st.text())
                lines[i] = f"{key}{colon or ':'} {odd}"
    return "\n".join(lines)


@given(edited_scenes())
@settings(max_examples=200)
def test_any_edit_of_a_shipped_scene_gives_a_scene_or_a_one_line_error(text):
    assert_scene_or_one_line(text)


KEYS = [
    "emotion", "behaviour", "law", "shape", "kind", "density", "centre", "x", "y", "robot", "model", "l", "K",
    "limits", "stage", "start", "place", "poses", "video",
]  # fmt: skip
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.sampled_from(KEYS) | st.dates()
NESTED = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS) | st.text(), inner, max_size=4),
    max_leaves=8,
)


@given(NESTED)
@settings(max_examples=150)
def test_any_data_gives_a_scene_or_a_one_line_error(data):
    assert_scene_or_one_line(yaml.safe_dump(data, allow_unicode=True))


def groups_in(data):
    return [data, *(group for item in data.values() if isinstance(item, dict) for group in groups_in(item))]


@given(st.sampled_from(sorted(SHIPPED)), st.data(), NESTED)
@settings(max_examples=150)
def test_any_data_in_a_shipped_scene_gives_a_scene_or_a_one_line_error(emotion, choice, odd):
    data = read_yaml(SHIPPED[emotion], "scene.yaml")[0]
    group = choice.draw(st.sampled_from(groups_in(data)))
    group[choice.draw(st.sampled_from(sorted(group)) | st.text(max_size=5))] = odd
    assert_scene_or_one_line(yaml.safe_dump(data, allow_unicode=True, sort_keys=False))


def test_tabs_are_accepted_before_comments_at_line_ends_and_between_words() -> None:
    text = 'a: 1\t# one\nb:\t2\nc: "x"\t\n\t\nd: {e:\t1,\tf: 2}\t# both\n'
    assert read_yaml(text, "x")[0] == {"a": 1, "b": 2, "c": "x", "d": {"e": 1, "f": 2}}


@pytest.mark.parametrize("text", ["a:\n\t- 1\n", "a:\n\tb: 1\n", "a:\n  -\tb: 1\n", "\ta: 1\n"])
def test_tab_as_indentation_is_named(text) -> None:
    with pytest.raises(SourceError, match=r"^x:\d: not YAML: a tab; expected spaces$"):
        read_yaml(text, "x")


def test_question_mark_inside_braces_is_reported_with_its_remedy() -> None:
    with pytest.raises(
        SourceError, match=r"^x:1: not YAML: .*text with a question mark inside \{ \} or \[ \] needs quotes$"
    ):
        read_yaml("a: {b: Why?, c: d}\n", "x")
