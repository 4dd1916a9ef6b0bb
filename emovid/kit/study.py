"""The keys of study.yaml, and the rules between them."""

from collections.abc import Collection, Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from emovid.errors import SourceError, nearest
from emovid.kit.orders import Scheme
from emovid.kit.texts import Language, Link, Name, Parameter, Text, TextList, Texts
from emovid.responses.labels import NONE, Labels, plain
from emovid.responses.responses import RECORDED, SURVEY_COLUMNS
from emovid.scene.fields import MAX_DURATION
from emovid.scene.video import MAX_FPS
from emovid.yaml_models import Keys, inconsistent

MAX_VIDEOS = 200
_PARAMETERS = {  # of the addresses that recruitment services make
    "prolific": ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID"),
    "sona": ("id",),
    "mturk": ("workerId", "assignmentId", "hitId"),
    "cloudresearch": ("participantId", "assignmentId", "projectId"),
}
_COMMON = ("video", "video.size", "video.fps", "video.format", "duration", "emotion")  # keys of the study itself
# Columns of stimuli.csv.
_FACTS = ("video_code", "true_emotion", "source", "exemplar", "seed", "mirror", "half_turn", "turn")
_COLUMNS = (*SURVEY_COLUMNS, *RECORDED, "participant_id", "video_code", "signalled", "perceived")  # columns of data
_PAGES = ("consent", "instructions", "end")  # questions of exported surveys
_TAKEN = dict.fromkeys(_COLUMNS, "is a column of the data") | dict.fromkeys(_PAGES, "is a page of the survey")

SceneKeys = dict[str, Any]


class NumberRange(Keys):
    """A range of whole numbers."""

    low: int = Field(description="smallest number")
    high: int = Field(description="largest number")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.low > self.high:
            raise inconsistent("high", f"{self.high}: expected at least {self.low}")
        return self


class Question(Keys):
    """A question about the participant."""

    name: Name = Field(description="name in the data")
    question: Text = Field(description="text of the question")
    choices: Annotated[tuple[Text, ...], Field(strict=False, min_length=2)] | None = Field(
        None, description="answers to choose from; null: a line of text"
    )
    several: bool = Field(False, description="whether participants may choose more than one answer")
    number: NumberRange | None = Field(None, description="instead of text: a number in this range")
    long: bool = Field(False, description="several lines of text, up to 5000 characters")
    required: bool = Field(True, description="whether an answer is required")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.several and self.choices is None:
            raise inconsistent("several", "true without choices: expected choices to choose from")
        if sum((self.choices is not None, self.number is not None, self.long)) > 1:
            raise inconsistent("name", "expected only one of choices, number and long")
        if self.choices and self.several and any("|" in choice for choice in self.choices):
            raise inconsistent("choices", "with several, the data separate answers by |: expected choices without it")
        return self


class Consent(Keys):
    """The first page: the consent of participants."""

    text: Text = Field(description="text; blank lines separate paragraphs")
    version: Text = Field(description="version of the text that the ethics board approved")
    agree: Text = Field("I agree and want to take part", description="button to agree")
    decline: Text = Field("I do not agree", description="button to decline")
    declined: Text = Field(
        "You are not taking part. Nothing was recorded. You may close this window.",
        description="page after declining",
    )


class Thanks(Keys):
    """The last page."""

    text: Text = Field(description="text of the last page")
    code: Text | None = Field(None, description="completion code for participants to copy")
    link: Link | None = Field(None, description="return address of a recruitment service")


class Rating(Keys):
    """A slider below the choice."""

    question: Text = Field(description="text of the question")
    low: Text = Field(description="label of the left end")
    high: Text = Field(description="label of the right end")
    steps: Annotated[int, Field(ge=2, le=101)] = Field(101, description="number of positions, from 1")


class Ratings(Keys):
    """The sliders, in the order of the page."""

    confidence: Rating | None = Field(None, description="how sure participants are of their choice")
    valence: Rating | None = Field(None, description="how unpleasant or pleasant the emotion is")
    arousal: Rating | None = Field(None, description="how calm or excited it is")

    @property
    def asked(self) -> dict[str, Rating]:
        """The sliders of the study by name."""
        return {name: rating for name, rating in self if rating is not None}


class StimulusKeys(Keys):
    """A scene to make videos of, or a finished video."""

    scene: Text | None = Field(None, description="one of the six emotions, or a scene file relative to study.yaml")
    video: Text | None = Field(None, description="instead: a video in the folder of study.yaml")
    emotion: Text | None = Field(None, description="the label that it signals; by default the scene's emotion")
    set: SceneKeys = Field({}, description="keys of the scene to replace, as in robot.l: 0.002")


class Vary(Keys):
    """Random differences between a run and the public scene's, and between exemplars of one emotion."""

    seed: bool = Field(True, description="new random starting positions")
    turn: bool = Field(True, description="contours rotated about their center: another starting phase")
    mirror: bool = Field(True, description="mirror images: contours run in the other direction")
    half_turn: bool = Field(True, description="videos upside down")


class Look(Keys):
    """Size, frame rate and duration of all videos."""

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
    """Which videos each participant sees, and in which order."""

    scheme: Scheme = Field("williams", description="williams, latin or random")
    shown: Literal["all", "one_of_each"] = Field(
        "all",
        description="all videos for everyone; or one_of_each emotion: exemplars and factors between participants",
    )


class AttentionCheck(StimulusKeys):
    """A video of something that every viewer can name, with its own question."""

    name: Name = Field(description="name in the data")
    question: Text = Field(description="text of the question")
    choices: Annotated[tuple[Text, ...], Field(strict=False, min_length=2)] = Field(description="answers")
    answer: Text = Field(description="the right answer")
    after: Annotated[int, Field(ge=0)] = Field(description="number of videos that are shown before it")


class Requirements(Keys):
    """Devices and browsers that the study is for."""

    text: Text | None = Field(None, description="text about them on the first page")
    devices: Annotated[tuple[Literal["desktop", "tablet", "phone"], ...], Field(strict=False, min_length=1)] = Field(
        ("desktop", "tablet", "phone"), description="some of desktop, tablet, phone"
    )
    min_width: Annotated[int, Field(ge=0, le=10_000)] = Field(0, description="least width of the window [CSS pixels]")
    browsers: Annotated[tuple[Literal["chrome", "edge", "firefox", "safari"], ...], Field(strict=False)] = Field(
        (), description="some of chrome, edge, firefox, safari; none: all"
    )


class Return(Keys):
    """Code and link that a participant takes back to a recruitment service."""

    code: Text | None = Field(None, description="completion code to copy")
    link: Link | None = Field(None, description="return address; {NAME} stands for the value of a parameter")


class Recruitment(Keys):
    """A service that sends participants and pays them."""

    service: Literal["prolific", "sona", "mturk", "cloudresearch"] | None = Field(
        None, description="prolific, sona, mturk or cloudresearch, whose parameters are known; null: another one"
    )
    parameters: Annotated[tuple[Parameter, ...], Field(strict=False)] = Field(
        (), description="further parameters of the survey's address to store, apart from the answers"
    )
    automatic: Annotated[int, Field(ge=0, le=600)] | None = Field(
        None, description="seconds until the last page goes to the return link by itself; null: a link to press"
    )
    declined: Return = Field(Return(), description="code or link for participants who do not give consent")
    failed: Return = Field(Return(), description="code or link for participants who fail an attention check")

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters to store."""
        return tuple(dict.fromkeys((*_PARAMETERS.get(self.service or "", ()), *self.parameters)))


class Counting(Keys):
    """Which answers the analysis counts, decided before the data are seen."""

    unsubmitted: bool = Field(False, description="count participants who answered all videos and did not submit")
    failed_checks: bool = Field(True, description="count participants who failed an attention check")
    max_stalled_ms: Annotated[int, Field(ge=0)] | None = Field(
        None, description="leave out an answer to a video that stood still for longer [ms]; null: count it"
    )
    max_dropped: Annotated[float, Field(ge=0, le=1)] | None = Field(
        None, description="leave out an answer to a video of which a larger share of frames was dropped; null: count it"
    )
    min_watched: Annotated[float, Field(ge=0, le=1)] | None = Field(
        None, description="leave out an answer to a video of which a smaller share was watched; null: count it"
    )
    min_response_ms: Annotated[int, Field(ge=0)] | None = Field(
        None, description="leave out a participant whose median time to answer is shorter [ms]; null: count everybody"
    )
    straightliners: bool = Field(
        True, description="count participants who gave one label to all of three or more videos"
    )


class QuestionTranslation(Keys):
    """A question in another language."""

    question: Text = Field(description="text of the question")
    choices: Annotated[tuple[Text, ...], Field(strict=False)] | None = Field(
        None, description="the choices in the same order, if there are any"
    )


class RatingTranslation(Keys):
    """A slider in another language."""

    question: Text = Field(description="text of the question")
    low: Text = Field(description="label of the left end")
    high: Text = Field(description="label of the right end")


class Translation(Keys):
    """The study's texts in another language."""

    title: Text = Field(description="title that participants read")
    question: Text = Field(description="question about each video")
    labels: dict[str, Text] = Field(description="text of each label")
    none_of_these: Text | None = Field(None, description="text of the answer for none of them, if it is offered")
    ratings: dict[str, RatingTranslation] = Field({}, description="the sliders by name")
    questions: dict[str, QuestionTranslation] = Field(
        {}, description="demographics, questions after the videos and attention checks, by name"
    )
    consent: Text = Field(description="text of the first page")
    instructions: Text = Field(description="text before the first video")
    thanks: Text = Field(description="text of the last page")
    debriefing: Text | None = Field(None, description="text after the submission, if there is one")
    requirements: Text | None = Field(None, description="text about devices and browsers, if there is one")
    texts: Texts = Field(Texts(), description="words of the pages that differ from the translation of emovid")


class Ethics(Keys):
    """Approval by an ethics board."""

    board: Text | None = Field(None, description="name of the board")
    approval: Text | None = Field(None, description="number of the approval")


class Planned(Keys):
    """Effect that the number of participants is planned to detect."""

    rate: Annotated[float, Field(gt=0, le=1)] = Field(0.5, description="hit rate to detect, above chance")
    alpha: Annotated[float, Field(gt=0, lt=1)] = Field(0.05, description="familywise error rate")
    power: Annotated[float, Field(gt=0, lt=1)] = Field(0.8, description="desired power")


class Study(Keys):
    """All keys of a study.yaml."""

    title: Text = Field(description="title that participants read")
    language: Language = Field("en", description="language of the texts")
    translations: dict[Language, Translation] = Field(
        {}, description="further languages, of which participants choose one at the start"
    )
    authors: TextList = Field((), description="authors, for the exports")
    question: Text = Field(description="question about each video")
    labels: dict[str, Text] = Field(description="answers: label in data and key, and its text on the page")
    none_of_these: Text | None = Field(None, description="text of one more answer, for none of them; null: not offered")
    choices: Literal["fixed", "random"] = Field(
        "fixed", description="order of the answers: as listed, or random for each participant and recorded"
    )
    ratings: Ratings = Field(Ratings(), description="sliders below the choice")
    stimuli: Annotated[tuple[StimulusKeys, ...], Field(strict=False, min_length=1)] = Field(
        description="scenes and finished videos"
    )
    set: SceneKeys = Field({}, description="keys to replace in all scenes")
    exemplars: Annotated[int, Field(ge=1, le=50)] = Field(1, description="videos made of each scene")
    vary: Vary = Field(Vary(), description="random differences between videos of one scene")
    factors: dict[Name, dict[str, SceneKeys]] = Field(
        {}, description="experimental factors: levels, and the keys of scenes that each level sets"
    )
    video: Look = Field(Look(), description="size, frame rate and duration of all videos")
    orders: Orders = Field(Orders(), description="which videos each participant sees, and in which order")
    participants: Annotated[int, Field(ge=1, le=100_000)] = Field(45, description="number of orders")
    demographics: Annotated[tuple[Question, ...], Field(strict=False)] = Field(
        (), description="questions before the videos"
    )
    requirements: Requirements = Field(Requirements(), description="devices and browsers suitable for the study")
    consent: Consent = Field(description="first page")
    instructions: Text = Field(description="text before the first video")
    practice: StimulusKeys | None = Field(None, description="video for practice before the others; not in the data")
    checks: Annotated[tuple[AttentionCheck, ...], Field(strict=False, max_length=10)] = Field(
        (), description="attention checks between the videos"
    )
    questions_after: Annotated[tuple[Question, ...], Field(strict=False)] = Field(
        (), description="questions after the videos, such as comments"
    )
    debriefing: Text | None = Field(None, description="text after the submission, such as the purpose of the study")
    recruitment: Recruitment | None = Field(None, description="recruitment service; null: parameters are not stored")
    counting: Counting = Field(Counting(), description="which answers the analysis counts")
    thanks: Thanks = Field(description="last page")
    texts: Texts = Field(Texts(), description="words of the pages")
    ethics: Ethics = Field(Ethics(), description="approval by an ethics board")
    hypotheses: TextList = Field((), description="hypotheses, for the preregistration")
    exclusions: TextList = Field((), description="rules for leaving out participants, decided before the data are seen")
    plan: Planned = Field(Planned(), description="effect that the number of participants is planned to detect")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for key, message in _faults(self):
            raise inconsistent(key, message)
        return self

    @property
    def answers(self) -> dict[str, str]:
        """The labels and texts of all answers, none_of_these included."""
        return self.labels | ({NONE: self.none_of_these} if self.none_of_these else {})

    def resolved(self) -> dict[str, Any]:
        """Return every key with its value, defaults included, in plain types."""
        return self.model_dump(mode="json")


def _faults(study: Study) -> Iterator[tuple[str, str]]:
    """Yield (key, message) for each contradiction between keys."""
    yield from _label_faults(study)
    for i, stimulus in enumerate(study.stimuli):
        yield from _stimulus_faults(study, stimulus, f"stimuli.{i}")
    yield from _setting_faults(study)
    yield from _name_faults(study)
    for language, translation in study.translations.items():
        for key, message in _translation_faults(study, translation):
            yield f"translations.{language}.{key}".removesuffix("."), message
    if study.plan.rate * len(study.answers) <= 1:
        yield "plan.rate", f"{study.plan.rate:g}: expected more than chance, which is 1 in {len(study.answers)}"


def _translation_faults(study: Study, translation: Translation) -> Iterator[tuple[str, str]]:
    """Yield the gaps of a translation."""
    asked: list[Question | AttentionCheck] = [*study.demographics, *study.questions_after, *study.checks]
    question = {item.name: "{question: ..., choices: [...]}" if item.choices else "{question: ...}" for item in asked}
    groups: list[tuple[str, Mapping[str, str], Collection[str]]] = [
        ("labels", dict.fromkeys(study.labels, "..."), translation.labels),
        ("ratings", dict.fromkeys(study.ratings.asked, "{question: ..., low: ..., high: ...}"), translation.ratings),
        ("questions", question, translation.questions),
    ]
    missing = [
        f"{key}.{name} ({name}: {form})"
        for key, forms, given in groups
        for name, form in forms.items()
        if name not in given
    ]
    if missing:
        yield "", f"missing texts in this language: {', '.join(missing)}"
    for key, wanted, given in groups:
        for name in given:
            if name not in wanted:
                yield f"{key}.{name}", f"unknown name{nearest(name, wanted)}; expected {', '.join(wanted)}"
    for item in asked:
        count, found = len(item.choices or ()), translation.questions.get(item.name)
        if found and len(found.choices or ()) != count:
            yield (
                f"questions.{item.name}.choices",
                f"{len(found.choices or ())} given; expected {count}, as in the study",
            )
    for name, text in (
        ("none_of_these", study.none_of_these),
        ("debriefing", study.debriefing),
        ("requirements", study.requirements.text),
    ):
        if (text is None) != (getattr(translation, name) is None):
            yield name, "expected a text in both languages or in none"


def _name_faults(study: Study) -> Iterator[tuple[str, str]]:
    """Yield faults of the names that questions and checks have in the data."""
    items = [(f"demographics.{i}", item.name) for i, item in enumerate(study.demographics)]
    items += [(f"questions_after.{i}", item.name) for i, item in enumerate(study.questions_after)]
    items += [(f"checks.{i}", check.name) for i, check in enumerate(study.checks)]
    known: set[str] = set()
    for at, name in items:
        if why := "occurs twice" if name in known else _TAKEN.get(name):
            yield f"{at}.name", f"{name!r} {why}: expected another name"
        known.add(name)
    for i, check in enumerate(study.checks):
        if (check.scene is None) == (check.video is None):
            yield f"checks.{i}", "expected either a scene or a video"
        if check.answer not in check.choices:
            yield f"checks.{i}.answer", f"{check.answer!r} is not one of the choices; expected one of them"
    if study.practice and (study.practice.scene is None) == (study.practice.video is None):
        yield "practice", "expected either a scene or a video"


def _stimulus_faults(study: Study, stimulus: StimulusKeys, at: str) -> Iterator[tuple[str, str]]:
    if (stimulus.scene is None) == (stimulus.video is None):
        yield at, "expected either a scene or a video"
    if stimulus.video is None:
        return
    if stimulus.emotion is None:
        yield f"{at}.emotion", "missing: expected the label that the finished video signals"
    if stimulus.set:
        yield f"{at}.set", "a finished video has no keys to set"
    if study.factors or study.exemplars > 1:
        yield f"{at}.video", "a finished video cannot be varied: expected no factors and one exemplar"


def _setting_faults(study: Study) -> Iterator[tuple[str, str]]:
    settable = {"set": study.set} | {f"stimuli.{i}.set": stimulus.set for i, stimulus in enumerate(study.stimuli)}
    for name, levels in study.factors.items():
        settable |= {f"factors.{name}.{level}": keys for level, keys in levels.items()}
        if name in _FACTS:
            yield f"factors.{name}", "is a column of stimuli.csv: expected another name"
        if len(levels) < 2:
            yield f"factors.{name}", f"{len(levels)} given: expected at least 2 levels"
    for at, keys in settable.items():
        for key in keys:
            if key in _COMMON:
                yield f"{at}.{key}", "is the same for all stimuli: expected it under video: or as a key of the study"


def _label_faults(study: Study) -> Iterator[tuple[str, str]]:
    try:
        labels = Labels(list(study.labels))
    except SourceError as error:
        yield "labels", error.message
    else:
        if labels.offers_none:
            yield "labels", "'none' is not an emotion: expected none_of_these for it"
    for label in study.labels:
        if "|" in label or not label.isprintable():  # orders.csv separates labels by |
            yield "labels", f"{label!r}: expected one line without |"
    words = {label: plain(text) or text for label, text in study.answers.items()}  # plain() of an emoji is empty
    for label, text in study.answers.items():
        if list(words.values()).count(words[label]) > 1:
            yield (f"labels.{label}" if label in study.labels else "none_of_these"), f"{text!r} occurs twice"


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a study, for editors."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Study.model_json_schema()} | {
        "title": "emovid study"
    }
