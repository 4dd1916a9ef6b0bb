import pytest

from emovid.errors import SourceError
from emovid.responses.labels import Labels, number
from emovid.responses.responses import EMOTIONS


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("happiness", "happiness"),
        ("  HAPPY ", "happiness"),
        ("Surprised!", "surprise"),
        ("angry;", "anger"),
        ("afraid", "fear"),
        ("Scared", "fear"),
        ("fearful", "fear"),
        ("disgusted\u00a0", "disgust"),
        ("Sad", "sadness"),
        ("1. Sadness", "sadness"),
        ("Anger / angry", "anger"),
        ("😊 Happiness", "happiness"),
        ("None of these", "none"),
        ("none of the above.", "none"),
        ("", ""),
        ("  ", ""),
        ("not happy", None),
        ("happy or sad", None),
        ("happyness", None),
        ("3", None),
        ("=1+1", None),
    ],
)
def test_each_answer_matches_at_most_one_label(text, label) -> None:
    assert Labels().find(text) == label


def test_labels_and_adjectives_are_found_in_every_spelling() -> None:
    for label in EMOTIONS:
        for spelled in (label.upper(), f" {label.title()} ", f'"{label}"', f"{label}?"):
            assert Labels().find(spelled) == label


def test_custom_labels_take_over_their_synonyms() -> None:
    labels = Labels(["Joy", "calm", "None of these"])
    assert labels.signalled == ("Joy", "calm")
    assert labels.offers_none
    assert [labels.find(word) for word in ("happy", "CALM", "none", "sad")] == ["Joy", "calm", "none", None]


def test_emotions_have_their_standard_spelling() -> None:
    assert Labels(["FEAR", " Anger ", "Joy", "Mild  fear"]).signalled == ("fear", "anger", "Joy", "Mild fear")


def test_two_synonymous_labels_share_no_further_synonyms() -> None:
    labels = Labels(["joy", "happiness"])
    assert [labels.find(word) for word in ("joy", "happiness", "happy")] == ["joy", "happiness", None]


def test_answers_of_the_map_take_precedence() -> None:
    labels = Labels(
        EMOTIONS, {"1": "happy", "A2": "none", "Freude": "happiness", "sad": "fear", "-": None, "-1": "anger"}
    )
    words = ("1", "1.000", "a2", "FREUDE", "sad", "-", "-1", "2")
    assert [labels.find(word) for word in words] == [
        "happiness", "happiness", "none", "happiness", "fear", "", "anger", None,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("names", "answers", "message"),
    [
        (["joy"], {}, "labels: 1 given; expected 2 to 12"),
        ([f"l{i}" for i in range(13)], {}, "labels: 13 given; expected 2 to 12"),
        (["joy", "JOY "], {}, "labels: 'joy' is given twice; expected words"),
        (["joy", "!"], {}, "labels: '!' is not a word; expected words"),
        (["joy", "fear"], {"1": "sad"}, "answers: 1: 'sad' is not a label; expected joy, fear or none"),
    ],
)
def test_invalid_labels_are_refused(names, answers, message) -> None:
    with pytest.raises(SourceError) as error:
        Labels(names, answers)
    assert str(error.value) == message


def test_trailing_zero_decimals_are_removed() -> None:
    assert [number(text) for text in ("24.0000000000", " 3 ", "3.5", "x.0")] == ["24", "3", "3.5", "x.0"]


def test_zero_decimals_after_a_comma_are_removed_but_not_thousands() -> None:
    texts = ("24,0", "24,00", "1,0000000000", "1,000", "3,5", "1,000,000")
    assert [number(text) for text in texts] == ["24", "24", "1", "1,000", "3,5", "1,000,000"]
