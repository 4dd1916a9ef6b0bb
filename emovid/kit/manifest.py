"""The public manifest: everything that the pages of a survey need, and nothing that reveals an emotion."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, PositiveFloat, PositiveInt, ValidationError

from emovid.atomic_io import file_digest
from emovid.errors import InputError, reason
from emovid.kit.orders import Scheme
from emovid.kit.study import (
    Consent,
    Counting,
    Ethics,
    Question,
    Rating,
    Recruitment,
    Requirements,
    Return,
    Study,
    Thanks,
    Translation,
)
from emovid.kit.texts import Texts, in_language
from emovid.responses.labels import NONE
from emovid.yaml_models import Keys, source_error

Asked = TypeVar("Asked", Question, "PublicCheck")


class PublicVideo(Keys):
    """The public facts about a stimulus."""

    code: str
    file: str
    type: Literal["video/mp4"]
    bytes: int
    sha256: str
    frames: PositiveInt
    fps: PositiveInt
    width: PositiveInt
    height: PositiveInt
    duration: PositiveFloat


class Choice(Keys):
    """An answer: its label in the data, and its text on the page."""

    label: str
    text: str


class Choices(Keys):
    """The answers, and whether their order is random for each participant."""

    order: Literal["fixed", "random"]
    labels: tuple[Choice, ...]


class NamedRating(Rating):
    """A slider with its name in the data."""

    name: str


class PublicCheck(Keys):
    """An attention check, without its right answer."""

    name: str
    question: str
    choices: tuple[str, ...]
    after: int
    video: PublicVideo


class ServerKeys(Keys):
    """The contents of survey.json: the data of the survey server that participants must not read."""

    format: Literal["emovid survey 1"] = "emovid survey 1"
    complete: Return = Return()
    declined: Return = Return()
    failed: Return = Return()
    answers: dict[str, str] = Field({})  # right answers of attention checks, by name


class Manifest(Keys):
    """The contents of manifest.json; videos in the order of their codes."""

    format: Literal["emovid kit 1"]
    title: str
    language: str
    authors: tuple[str, ...]
    question: str
    choices: Choices
    ratings: tuple[NamedRating, ...]
    demographics: tuple[Question, ...]
    consent: Consent
    instructions: str
    thanks: Thanks
    texts: Texts
    ethics: Ethics
    order_scheme: Scheme
    participants: int
    videos_shown: int
    key_commitment: str
    videos: Annotated[tuple[PublicVideo, ...], Field(min_length=1)]
    version: PositiveInt = 1  # of the texts: each `study update` counts up
    requirements: Requirements = Requirements()
    practice: PublicVideo | None = None
    checks: tuple[PublicCheck, ...] = ()
    questions_after: tuple[Question, ...] = ()
    debriefing: str | None = None
    recruitment: Recruitment | None = None
    counting: Counting = Counting()
    translations: dict[str, Translation] = Field({})

    @property
    def codes(self) -> list[str]:
        """The codes of the videos."""
        return [video.code for video in self.videos]

    @property
    def all_videos(self) -> dict[str, PublicVideo]:
        """All videos by code: the stimuli, the practice video and those of attention checks."""
        extra = [*([self.practice] if self.practice else []), *(check.video for check in self.checks)]
        return {video.code: video for video in (*self.videos, *extra)}

    def text(self) -> str:
        """Return the manifest as JSON text."""
        return json_text(self)

    def map_yaml(self, codes: Mapping[str, str] = MappingProxyType({})) -> str:
        """Return the map for `study analyze --map`: the labels, and their texts.

        Args:
            codes: other words that a tool writes, with the label of each.
        """
        labels = [json.dumps(answer.label, ensure_ascii=False) for answer in self.choices.labels]
        meant = {answer.text: answer.label for answer in self.choices.labels} | dict(codes)
        answers = [
            f"  {json.dumps(k, ensure_ascii=False)}: {json.dumps(v, ensure_ascii=False)}" for k, v in meant.items()
        ]
        return "\n".join([f"labels: [{', '.join(labels)}]", "answers:", *answers, ""])


def localized(manifest: Manifest, language: str) -> Manifest:
    """Return a manifest in one of its languages; the labels and the names of questions stay."""
    found = manifest.translations.get(language)
    if found is None:
        return manifest
    texts = found.labels | ({NONE: found.none_of_these} if found.none_of_these else {})
    labels = tuple(Choice(label=item.label, text=texts[item.label]) for item in manifest.choices.labels)
    consent = in_language(Consent(text=found.consent, version=manifest.consent.version), language)
    return manifest.model_copy(
        update={
            "language": language,
            "title": found.title,
            "question": found.question,
            "choices": manifest.choices.model_copy(update={"labels": labels}),
            "ratings": tuple(item.model_copy(update=dict(found.ratings[item.name])) for item in manifest.ratings),
            "demographics": tuple(_translated(item, found) for item in manifest.demographics),
            "questions_after": tuple(_translated(item, found) for item in manifest.questions_after),
            "checks": tuple(_translated(item, found) for item in manifest.checks),
            "consent": consent,
            "instructions": found.instructions,
            "thanks": manifest.thanks.model_copy(update={"text": found.thanks}),
            "debriefing": found.debriefing,
            "requirements": manifest.requirements.model_copy(update={"text": found.requirements}),
            "texts": in_language(found.texts, language),
        }
    )


def _translated(item: Asked, translation: Translation) -> Asked:
    return item.model_copy(update=dict(translation.questions[item.name]))


def json_text(keys: Keys) -> str:
    """Return keys as JSON text."""
    return json.dumps(keys.model_dump(mode="json"), indent=2, ensure_ascii=False) + "\n"


def server_keys_of(study: Study) -> ServerKeys:
    """Return the data known only to the survey server."""
    recruitment = study.recruitment or Recruitment()
    return ServerKeys(
        complete=Return(code=study.thanks.code, link=study.thanks.link),
        declined=recruitment.declined,
        failed=recruitment.failed,
        answers={check.name: check.answer for check in study.checks},
    )


def read_server_keys(path: Path) -> ServerKeys | None:
    """Return the contents of a survey.json; None for a kit of version 0.1.0, which has none.

    Raises:
        InputError: if the file cannot be read, or has other keys.
    """
    try:
        return ServerKeys.model_validate_json(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason(error)}") from None
    except ValueError:
        raise InputError(f"{path}: not the file that emovid study build wrote; build the kit again") from None


def manifest_of(
    study: Study,
    videos: Sequence[Path],
    participants: int,
    shown: int,
    commitment: str,
    practice: Path | None = None,
    checks: Sequence[Path] = (),
) -> Manifest:
    """Return the manifest of a kit.

    Args:
        study: the study.
        videos: the stimuli, in the order of their codes.
        participants: number of orders.
        shown: number of videos that each participant sees.
        commitment: to the key, see `seeded_random.commitment`.
        practice: the practice video.
        checks: the videos of the attention checks.
    """
    labels = tuple(Choice(label=label, text=text) for label, text in study.answers.items())
    return Manifest(
        format="emovid kit 1",
        title=study.title,
        language=study.language,
        authors=study.authors,
        question=study.question,
        choices=Choices(order=study.choices, labels=labels),
        ratings=tuple(NamedRating(name=name, **dict(rating)) for name, rating in study.ratings.asked.items()),
        demographics=study.demographics,
        consent=in_language(study.consent, study.language),
        instructions=study.instructions,
        thanks=Thanks(text=study.thanks.text),  # code and link are in survey.json
        texts=in_language(study.texts, study.language),
        ethics=study.ethics,
        order_scheme=study.orders.scheme,
        participants=participants,
        videos_shown=shown,
        key_commitment=commitment,
        videos=tuple(_video(study, video) for video in videos),
        requirements=study.requirements,
        practice=_video(study, practice) if practice else None,
        checks=tuple(
            PublicCheck(
                name=check.name,
                question=check.question,
                choices=check.choices,
                after=check.after,
                video=_video(study, video),
            )
            for check, video in zip(study.checks, checks, strict=True)
        ),
        questions_after=study.questions_after,
        debriefing=study.debriefing,
        recruitment=study.recruitment
        and study.recruitment.model_copy(update={"declined": Return(), "failed": Return()}),
        counting=study.counting,
        translations=study.translations,
    )


def read_manifest(path: Path) -> tuple[Manifest, list[str]]:
    """Return a manifest, and the keys in it that do not belong there.

    Raises:
        InputError: if there is none, or if one of its keys is missing or has another kind of value.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        message = f"{path}: {reason(error)}; expected the manifest of a finished kit: run emovid study build again"
        raise InputError(message) from None
    except ValueError:
        raise InputError(f"{path}: not JSON; expected the manifest of a kit") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: not the manifest of a kit")
    unknown: list[str] = []
    while True:
        try:
            return Manifest.model_validate_json(json.dumps(data)), unknown
        except ValidationError as error:
            extra = [item["loc"] for item in error.errors() if item["type"] == "extra_forbidden"]
            if not extra:
                raise InputError(str(source_error(error, {(): str(path)}, Manifest))) from None
            for location in extra:
                unknown.append(".".join(map(str, location)))
                _without(data, location)


def _without(data: Any, location: Sequence[int | str]) -> None:
    for part in location[:-1]:
        data = data[part]
    del data[location[-1]]


def _video(study: Study, video: Path) -> PublicVideo:
    width, height = map(int, study.video.size.split("x"))
    return PublicVideo(
        code=video.stem,
        file=f"videos/{video.name}",
        type="video/mp4",
        bytes=video.stat().st_size,
        sha256=file_digest(video),
        frames=study.video.frames,
        fps=study.video.fps,
        width=width,
        height=height,
        duration=study.video.frames / study.video.fps,
    )
