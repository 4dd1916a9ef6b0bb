"""A study: what study.yaml may say, and what its keys demand of each other."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from emovid.errors import SourceError
from emovid.kit.orders import Scheme
from emovid.kit.pages import Consent, Item, Language, Name, Ratings, Text, Texts, Thanks
from emovid.responses.dialects.own import FIRST, RECORDED
from emovid.responses.labels import NONE, Labels, plain
from emovid.scene.fields import MAX_DURATION, Keys, inconsistent
from emovid.scene.video import MAX_FPS

MAX_VIDEOS = 200
_COMMON = ("video", "video.size", "video.fps", "video.format", "duration", "emotion")  # the study's to say
_FACTS = ("video_code", "true_emotion", "source", "exemplar", "seed", "mirror", "half_turn", "turn")  # of a stimulus
_COLUMNS = (*FIRST, *RECORDED, "participant_id", "video_code", "signalled", "perceived")  # of the data
_PAGES = ("consent", "instructions", "end")  # of exported surveys, each a question by this name
_TAKEN = dict.fromkeys(_COLUMNS, "is a column of the answers") | dict.fromkeys(_PAGES, "is a page of the survey")

SceneKeys = dict[str, Any]


class Stimulus(Keys):
    """Something to show: a scene, or a finished video."""

    scene: Text | None = Field(None, description="one of the six emotions, or a scene file beside study.yaml")
    video: Text | None = Field(None, description="instead: a finished video beside study.yaml")
    emotion: Text | None = Field(None, description="the label it stands for; by default the scene's emotion")
    set: SceneKeys = Field({}, description="keys of the scene to replace, as in robot.l: 0.002")


class Vary(Keys):
    """How a run may differ from the public scene's, and the exemplars of an emotion from each other."""

    seed: bool = Field(True, description="random starts are drawn anew")
    turn: bool = Field(True, description="a contour is turned about its centre by an angle: another start phase")
    mirror: bool = Field(True, description="mirror images: they run the other way round")
    half_turn: bool = Field(True, description="the picture upside down")


class Look(Keys):
    """What all videos have in common."""

    size: Annotated[str, Field(pattern=r"^[1-9][0-9]{0,3}[02468]x[1-9][0-9]{0,3}[02468]$")] = Field(
        "1280x720", description="width x height [pixels], both even"
    )
    fps: Annotated[int, Field(ge=1, le=MAX_FPS)] = Field(30, description="frames per second")
    duration: Annotated[float, Field(gt=0, le=MAX_DURATION)] = Field(15.0, description="of each video [s]")

    @property
    def frames(self) -> int:
        """Frames of each video."""
        return max(1, round(self.duration * self.fps))


class Orders(Keys):
    """Who sees what, in which order."""

    scheme: Scheme = Field("williams", description="williams, latin or random")
    shown: Literal["all", "one_of_each"] = Field(
        "all", description="all videos to everybody, or one of each emotion: exemplars and factors between participants"
    )


class Ethics(Keys):
    """Under which approval."""

    board: Text | None = Field(None, description="who approved")
    approval: Text | None = Field(None, description="the approval's number")


class Planned(Keys):
    """What the number of participants was planned for."""

    rate: Annotated[float, Field(gt=0, le=1)] = Field(0.5, description="the hit rate to be found, above chance")
    alpha: Annotated[float, Field(gt=0, lt=1)] = Field(0.05, description="level of the whole")
    power: Annotated[float, Field(gt=0, lt=1)] = Field(0.8, description="wished power")


class Study(Keys):
    """All of a study.yaml."""

    title: Text = Field(description="of the study, as participants may read it")
    language: Language = Field("en", description="of the texts")
    authors: Annotated[tuple[Text, ...], Field(strict=False)] = Field((), description="for the exports")
    question: Text = Field(description="asked about each video")
    labels: dict[str, Text] = Field(description="the answers: the label in data and key, and its text on the page")
    none_of_these: Text | None = Field(None, description="text of a further answer for none of them; null: not offered")
    choices: Literal["fixed", "random"] = Field(
        "fixed", description="order of the answers: as listed, or drawn for each participant and recorded"
    )
    ratings: Ratings = Field(Ratings(), description="sliders beside the choice")
    stimuli: Annotated[tuple[Stimulus, ...], Field(strict=False, min_length=1)] = Field(description="what is shown")
    set: SceneKeys = Field({}, description="keys to replace in all scenes")
    exemplars: Annotated[int, Field(ge=1, le=50)] = Field(1, description="videos made of each scene")
    vary: Vary = Field(Vary(), description="how they differ from the public scenes and from each other")
    factors: dict[Name, dict[str, SceneKeys]] = Field(
        {}, description="further things that vary, each with its levels, each level with the keys of scenes it sets"
    )
    video: Look = Field(Look(), description="what all videos have in common")
    orders: Orders = Field(Orders(), description="who sees what, in which order")
    participants: Annotated[int, Field(ge=1, le=100_000)] = Field(45, description="how many orders are made")
    demographics: Annotated[tuple[Item, ...], Field(strict=False)] = Field((), description="asked before the videos")
    consent: Consent = Field(description="asked before anything else")
    instructions: Text = Field(description="read before the first video")
    thanks: Thanks = Field(description="the last page")
    texts: Texts = Field(Texts(), description="the words of the pages")
    ethics: Ethics = Field(Ethics(), description="under which approval")
    hypotheses: Annotated[tuple[Text, ...], Field(strict=False)] = Field((), description="for the preregistration")
    exclusions: Annotated[tuple[Text, ...], Field(strict=False)] = Field(
        (), description="whose answers are left out, decided before they are seen"
    )
    plan: Planned = Field(Planned(), description="what the number of participants was planned for")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for key, message in _faults(self):
            raise inconsistent(key, message)
        return self

    @property
    def answers(self) -> dict[str, str]:
        """All answers: label and text."""
        return self.labels | ({NONE: self.none_of_these} if self.none_of_these else {})

    def resolved(self) -> dict[str, Any]:
        """Every key with its value, defaults included, in plain types."""
        return self.model_dump(mode="json")


def _faults(study: Study) -> Iterator[tuple[str, str]]:
    """Yield (key, message) for what no key shows alone."""
    yield from _label_faults(study)
    for i, stimulus in enumerate(study.stimuli):
        yield from _stimulus_faults(study, stimulus, f"stimuli.{i}")
    yield from _setting_faults(study)
    names = [item.name for item in study.demographics]
    for i, name in enumerate(names):
        if why := "stands twice" if name in names[:i] else _TAKEN.get(name):
            yield f"demographics.{i}.name", f"{name!r} {why}: expected another name"
    if study.plan.rate * len(study.answers) <= 1:
        yield "plan.rate", f"{study.plan.rate:g}: expected more than chance, 1 in {len(study.answers)}"


def _stimulus_faults(study: Study, stimulus: Stimulus, at: str) -> Iterator[tuple[str, str]]:
    if (stimulus.scene is None) == (stimulus.video is None):
        yield at, "expected either a scene or a video"
    if stimulus.video is None:
        return
    if stimulus.emotion is None:
        yield f"{at}.emotion", "missing: a finished video does not say which label it stands for"
    if stimulus.set:
        yield f"{at}.set", "a finished video has no keys to set"
    if study.factors or study.exemplars > 1:
        yield f"{at}.video", "a finished video cannot be varied: expected no factors and one exemplar"


def _setting_faults(study: Study) -> Iterator[tuple[str, str]]:
    settable = {"set": study.set} | {f"stimuli.{i}.set": stimulus.set for i, stimulus in enumerate(study.stimuli)}
    for name, levels in study.factors.items():
        settable |= {f"factors.{name}.{level}": keys for level, keys in levels.items()}
        if name in _FACTS:
            yield f"factors.{name}", "is the name of something else in the list of stimuli: expected another one"
        if len(levels) < 2:
            yield f"factors.{name}", f"{len(levels)} given: expected at least 2 levels"
    for at, keys in settable.items():
        for key in keys:
            if key in _COMMON:
                yield f"{at}.{key}", "is the same for all stimuli: expected it among the study's own keys"


def _label_faults(study: Study) -> Iterator[tuple[str, str]]:
    try:
        labels = Labels(list(study.labels))
    except SourceError as error:
        yield "labels", error.message
    else:
        if labels.offers_none:
            yield "labels", "'none' is no emotion: expected it as none_of_these"
    for label in study.labels:
        if "|" in label or not label.isprintable():  # orders.csv has labels in one line, with | between them
            yield "labels", f"{label!r}: expected a label in one line, without |"
    words = {label: plain(text) or text for label, text in study.answers.items()}  # of an emoji plain leaves nothing
    for label, text in study.answers.items():
        if list(words.values()).count(words[label]) > 1:
            yield (f"labels.{label}" if label in study.labels else "none_of_these"), f"{text!r} stands twice"
