"""The keys of study.yaml for what participants read and are asked besides the question of the study."""

import re
from typing import Annotated

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from emovid.scene.fields import Keys


def _spelled(pattern: str, words: str) -> AfterValidator:
    """Check that a text matches a pattern, and say in words what that is."""

    def check(text: str) -> str:
        if not re.fullmatch(pattern, text):
            raise PydanticCustomError("spelling", "{words}", {"words": words})
        return text

    return AfterValidator(check)


Text = Annotated[str, Field(min_length=1, max_length=20_000)]
Name = Annotated[
    str, _spelled("[a-z][a-z0-9_]{0,19}", "at most 20 lower-case letters, digits and underscores, a letter first")
]
Language = Annotated[str, _spelled("[a-z]{2,3}(-[A-Za-z0-9]{2,8})*", "a language, as in en or pt-BR")]
Link = Annotated[str, _spelled(r"https?://\S+", "an address, as in https://example.org")]


class Item(Keys):
    """A question about the participant."""

    name: Name = Field(description="its name in the data")
    question: Text = Field(description="as participants read it")
    choices: Annotated[tuple[Text, ...], Field(strict=False, min_length=2)] | None = Field(
        None, description="the answers to choose from; null: a line of text"
    )
    required: bool = Field(True, description="whether an answer is needed")


class Consent(Keys):
    """What participants agree to before anything else."""

    text: Text = Field(description="what they agree to; blank lines part paragraphs")
    version: Text = Field(description="of the text, as the ethics board knows it")
    agree: Text = Field("I agree and want to take part", description="the button of who agrees")
    decline: Text = Field("I do not agree", description="the button of who does not")
    declined: Text = Field("You are not taking part. Nothing was recorded. You may close this window.")


class Thanks(Keys):
    """The last page."""

    text: Text = Field(description="what participants read at the end")
    code: Text | None = Field(None, description="a completion code to be copied")
    link: Link | None = Field(None, description="where they return to, as given by a recruitment service")


class Rating(Keys):
    """A slider beside the choice."""

    question: Text = Field(description="as participants read it")
    low: Text = Field(description="what the left end means")
    high: Text = Field(description="what the right end means")
    steps: Annotated[int, Field(ge=2, le=101)] = Field(101, description="places of the slider, 1 to this")


class Ratings(Keys):
    """The sliders that a study has, in the order of the page."""

    confidence: Rating | None = Field(None, description="how sure participants are of their choice")
    valence: Rating | None = Field(None, description="how unpleasant or pleasant the emotion is")
    arousal: Rating | None = Field(None, description="how calm or excited it is")

    @property
    def asked(self) -> dict[str, Rating]:
        """The sliders by name."""
        return {name: rating for name, rating in self if rating is not None}


class Texts(Keys):
    """The words of the pages: all that a translation replaces."""

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
    withdraw_text: Text = Field("All that was recorded of you will be deleted. This cannot be undone.")
    withdrawn: Text = Field("Your answers were deleted. You may close this window.")
    another: Text = Field("Start for another person", description="button, where several share a computer")
    wait: Text = Field("One moment.", description="while the server is asked")
    offline: Text = Field("No connection to the survey. Trying again.")
    no_script: Text = Field("This page needs JavaScript to show the video. Please turn it on and reload the page.")
    out_of_date: Text = Field("This page was out of date; what it sent was not recorded. Please go on from here.")
    not_found: Text = Field("There is no such page.")
    failed: Text = Field("Something went wrong. All answers submitted before are kept. Please try again.")
