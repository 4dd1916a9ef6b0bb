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
