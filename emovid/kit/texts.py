"""The survey's own words, and their translations."""

import re
from functools import cache
from importlib.resources import files
from typing import Annotated, TypeVar

import yaml
from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from emovid.yaml_models import Keys

Words = TypeVar("Words", bound=Keys)
TRANSLATED = ("ar", "de", "es", "fr", "it", "ja", "pt", "zh")  # besides English


def _spelled(pattern: str, words: str) -> AfterValidator:
    """Return a check that a text matches a pattern; `words` describe the pattern in the message."""

    def check(text: str) -> str:
        if not re.fullmatch(pattern, text):
            raise PydanticCustomError("spelling", "{words}", {"words": words})
        return text

    return AfterValidator(check)


Text = Annotated[str, Field(min_length=1, max_length=20_000)]
TextList = Annotated[tuple[Text, ...], Field(strict=False)]
Name = Annotated[
    str,
    _spelled("[a-z][a-z0-9_]{0,19}", "at most 20 lowercase letters, digits and underscores, beginning with a letter"),
]
Parameter = Annotated[
    str, _spelled("[A-Za-z][A-Za-z0-9_-]{0,39}", "the name of a parameter of an address, as in PROLIFIC_PID")
]
Language = Annotated[str, _spelled("[a-z]{2,3}(-[A-Za-z0-9]{2,8})*", "a language code such as en or pt-BR")]
Link = Annotated[str, _spelled(r"https?://\S+", "an address such as https://example.org")]


_FORMER = {  # defaults of version 0.1.0, which its studies repeat
    "withdraw_text": "All that was recorded of you will be deleted. This cannot be undone.",
    "no_script": "This page needs JavaScript to show the video. Please turn it on and reload the page.",
    "out_of_date": "This page was out of date; what it sent was not recorded. Please go on from here.",
}


class Texts(Keys):
    """The words of the pages."""

    next: Text = Field("Continue", description="button to the next page")
    submit: Text = Field("Submit answer", description="button that ends a video's page")
    play: Text = Field("Play the video", description="button")
    again: Text = Field("Watch again", description="button")
    watch_first: Text = Field("Watch the video to its end; then choose.", description="under the video, at first")
    choose: Text = Field("You can watch it again as often as you like.", description="under the video, when watched")
    progress: Text = Field("Progress", description="beside the bar on top")
    loading: Text = Field("The videos are being loaded.", description="before the first page")
    load_error: Text = Field("The videos could not be loaded. Please reload this page.")
    about_you: Text = Field("About you", description="above the questions about the participant")
    optional: Text = Field("(optional)", description="after a question that may be left out")
    save: Text = Field("Save the answers", description="button at the end, where no server keeps them")
    code: Text = Field("Your completion code:", description="before the code")
    back: Text = Field("Return to the recruitment service", description="of the link at the end")
    # Of the survey that emovid serves, besides most of the above.
    place: Text = Field("Video {place} of {count}", description="heading of a video's page")
    skip: Text = Field("Skip to the content", description="link that the keyboard meets first")
    pause: Text = Field("Pause", description="button, while a video plays")
    earlier: Text = Field("Back", description="link to the page before")
    motion: Text = Field(
        "The videos show many small shapes that move, some of them fast. If this makes you feel unwell, pause the "
        "video or stop.",
        description="notice of motion, before the first video",
    )
    keep_code: Text = Field(
        "Keep this code to continue later or on another device, or to have your answers deleted:",
        description="before the participant's own code",
    )
    resume: Text = Field("Continue with your code", description="link and heading")
    your_code: Text = Field("Your code", description="of the field for it")
    unknown_code: Text = Field("This code is not known. Please check it.")
    missing: Text = Field("Please answer this question.", description="at a question without an answer")
    review: Text = Field("Your answers", description="heading, after the last video")
    review_text: Text = Field("You can change your answers until you submit them.", description="under it")
    change: Text = Field("Change", description="link to a video's page, from there")
    finish: Text = Field("Submit all answers", description="button that ends the survey")
    withdraw: Text = Field("Delete my answers", description="link, heading and button")
    withdraw_text: Text = Field("All data recorded about you will be deleted. This cannot be undone.")
    withdrawn: Text = Field("Your answers were deleted. You may close this window.")
    another: Text = Field("Start for another person", description="button, where several share a computer")
    wait: Text = Field("One moment.", description="while the server is asked")
    offline: Text = Field("No connection to the survey. Trying again.")
    no_script: Text = Field(
        "This page needs JavaScript to show the video. Please turn on JavaScript and reload the page."
    )
    out_of_date: Text = Field("This page was out of date; what it sent was not recorded. Please continue from here.")
    not_found: Text = Field("There is no such page.")
    failed: Text = Field("Something went wrong. All answers submitted before are kept. Please try again.")
    # Added after version 0.1.0.
    video_error: Text = Field(
        "The video could not be loaded. Check your connection, then press the button to try again.",
        description="under a video that failed to load",
    )
    cookies: Text = Field(
        "This survey needs cookies to remember your place. Please allow cookies for this website, then load this page "
        "again.",
        description="where the browser blocks cookies",
    )
    busy: Text = Field("The survey is busy. Trying again.", description="while another program locks the database")
    too_long: Text = Field("Your answers are too long to be sent. Please shorten them.")
    erasing: Text = Field(
        "Your answers are no longer part of the study. The last copy of them will be erased shortly. You may close "
        "this window.",
        description="after a withdrawal, while another program still reads the database",
    )
    pilot: Text = Field("This is a test run. Your answers will not be counted.", description="on top, in a pilot")
    choose_language: Text = Field("Language", description="before the languages of the study")
    unsuitable: Text = Field(
        "This study cannot be shown on this device or in this browser. Please open it on another one.",
        description="where the requirements of the study are not met",
    )
    practice: Text = Field("Practice video", description="heading of its page")
    practice_note: Text = Field(
        "This video is for practice. Your answer to it is not counted.", description="under that heading"
    )
    more_questions: Text = Field("Last questions", description="heading of the questions after the videos")
    several: Text = Field("You can choose more than one answer.", description="at such a question")
    number_range: Text = Field("Please enter a number from {low} to {high}.", description="at a question for a number")
    returning: Text = Field("You will be taken back in a few seconds.", description="before an automatic return")


@cache
def words_of(language: str) -> dict[str, str]:
    """Return the survey's own words in a language, by key of `Texts` or `Consent`; empty where there are none.

    Args:
        language: as in de or pt-BR; a variety has the words of its language.
    """
    name = language.split("-", maxsplit=1)[0]
    if name not in TRANSLATED:
        return {}
    text = (files("emovid.kit") / "languages" / f"{name}.yaml").read_text(encoding="utf-8")
    words: dict[str, str] = yaml.safe_load(text)
    return words


def in_language(words: Words, language: str) -> Words:
    """Return words in a language: the study's own where it has them, else the translation of the English default."""
    translated = words_of(language)
    fields = type(words).model_fields
    changed = {
        name: translated[name]
        for name, value in words
        if name in translated and value in (fields[name].default, _FORMER.get(name))
    }
    return words.model_copy(update=changed)
