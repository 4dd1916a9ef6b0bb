"""The public manifest: everything that the pages of a survey need, and nothing that reveals an emotion."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal

from pydantic import Field, PositiveFloat, PositiveInt, ValidationError

from emovid.atomic_io import file_digest
from emovid.errors import InputError, reason
from emovid.kit.orders import Scheme
from emovid.kit.study import Consent, Ethics, Question, Rating, Study, Thanks
from emovid.kit.texts import Texts, in_language
from emovid.yaml_models import Keys, source_error


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

    @property
    def codes(self) -> list[str]:
        """The codes of the videos."""
        return [video.code for video in self.videos]

    def text(self) -> str:
        """Return the manifest as JSON text."""
        return json.dumps(self.model_dump(mode="json"), indent=2, ensure_ascii=False) + "\n"

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


def manifest_of(study: Study, videos: Sequence[Path], participants: int, shown: int, commitment: str) -> Manifest:
    """Return the manifest of a kit.

    Args:
        study: the study.
        videos: the stimuli, in the order of their codes.
        participants: number of orders.
        shown: number of videos that each participant sees.
        commitment: to the key, see `seeded_random.commitment`.
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
        thanks=study.thanks,
        texts=in_language(study.texts, study.language),
        ethics=study.ethics,
        order_scheme=study.orders.scheme,
        participants=participants,
        videos_shown=shown,
        key_commitment=commitment,
        videos=tuple(_video(study, video) for video in videos),
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
