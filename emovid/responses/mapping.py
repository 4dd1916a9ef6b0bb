"""map.yaml: facts about an export that cannot be detected from its columns."""

from collections.abc import Mapping as Map
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Self, TypeAlias

import yaml
from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from emovid.csv_reader import read_bytes, utf8
from emovid.errors import SourceError, quoted
from emovid.responses.key import code_of
from emovid.responses.responses import Repeats
from emovid.yaml_models import Keys, inconsistent, source_error
from emovid.yaml_source import KeyPath, Places, read_yaml

EACH_ROW = "each row"  # value of `participant` if every row belongs to another participant
EACH_FILE = "each file"  # value of `participant` if every file belongs to another participant


def _words(value: Any) -> Any:
    """Return a single word as a list of one."""
    return [value] if isinstance(value, str) else value


def _codes(value: Any) -> Any:
    """Return the codes of videos, cleaned; for columns (a group of keys) or for columns in order (a list)."""
    if not isinstance(value, dict | list):
        raise PydanticCustomError("codes", "column: code, or a list of codes")
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, code in items:
        if not isinstance(code, str) or not code_of(code):
            raise inconsistent(str(key), "no code; expected the code of a video")
    return {key: code_of(code) for key, code in value.items()} if isinstance(value, dict) else list(map(code_of, value))


Words: TypeAlias = Annotated[tuple[str, ...], BeforeValidator(_words), Field(strict=False)]
Codes: TypeAlias = Annotated[dict[str, str] | list[str], BeforeValidator(_codes)]


class Rows(Keys):
    """Rows that count, by the values of columns."""

    keep: dict[str, Words] = Field({}, description="column: values of the rows to keep; all others are left out")
    leave_out: dict[str, Words] = Field({}, description="column: values of the rows to leave out")


class ExportMap(Keys):
    """All keys of a map.yaml; columns are named by their header or their question text."""

    participant: str = Field("", description=f"column that names the participants; or {EACH_ROW}, or {EACH_FILE}")
    video: str = Field("", description="column of videos, in a table with one row for each answer")
    response: Words = Field((), description="column of answers in such a table, or a list of columns that share them")
    truth: str = Field("", description="column of the true emotion in such a table; replaces a key")
    videos: Codes = Field({}, description="column: code of its video; or a list of codes, in the order of the columns")
    answers: dict[str, str | None] = Field(
        {}, description="text of a cell: its label, none for none of these, nothing for a missing answer"
    )
    groups: dict[str, str] = Field({}, description="name of a group: its column")
    drop: dict[str, Words] = Field({}, description="column: values of participants to leave out")
    rows: Rows = Field(Rows(), description="rows to keep or to leave out, such as practice trials")
    repeats: Repeats | None = Field(
        None, description="which of several answers of a participant to one video count: first, last or all"
    )
    labels: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        (), description="labels, if they are not the six emotions"
    )

    _places: Places = PrivateAttr({})

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.video and self.videos:
            message = (
                "given together with videos; expected video for a row for each answer, or videos for a column for each"
            )
            raise inconsistent("video", message)
        for key, titles in (("response", self.response), ("truth", (self.truth,))):
            if self.video and self.video in titles:
                raise inconsistent(key, "also the column of videos; expected another column")
        return self

    @property
    def codes_of_columns(self) -> Map[str, str]:
        """The code of each column that the map names."""
        return self.videos if isinstance(self.videos, dict) else {}

    @property
    def codes_in_order(self) -> tuple[str, ...]:
        """The codes of columns that ask one question, in the order of the file."""
        return tuple(self.videos) if isinstance(self.videos, list) else ()

    def place(self, *path: str | int) -> str:
        """Return ``file:line`` of a key, or of the innermost group around it."""
        return next((self._places[path[:n]] for n in range(len(path), -1, -1) if path[:n] in self._places), "map.yaml")


def read_mapping(path: Path) -> ExportMap:
    """Return the content of a map.yaml.

    Raises:
        SourceError: for an invalid map, with file, line and key.
    """
    text = utf8(read_bytes(path), str(path)).decode()
    if not text.strip():
        raise SourceError(str(path), f"empty; expected some of {', '.join(ExportMap.model_fields)}")
    values, places = read_yaml(text, str(path), "map", as_words=True)
    if not isinstance(values, dict):
        raise SourceError(str(path), f"not a map; expected some of {', '.join(ExportMap.model_fields)}")
    try:
        found = ExportMap.model_validate(
            {key: _filled(key, value) for key, value in values.items() if value is not None}
        )
    except ValidationError as error:
        raise source_error(error, places, ExportMap) from None
    found._places = places
    return found


def _filled(key: str, value: Any) -> Any:
    """Return a value of the map; an empty column of a group means that there is no such group."""
    if key == "groups" and isinstance(value, dict):
        return {name: column for name, column in value.items() if column is not None}
    return value


def map_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a map.yaml."""
    schema = ExportMap.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "emovid map"}


def map_text(
    named: Map[str, str], videos: Map[str, str] | list[str], groups: Map[str, str], answers: Sequence[str]
) -> str:
    """Return a map.yaml to edit: the detected columns, and comments on all keys.

    Args:
        named: detected columns of `participant`, `video`, `response` and `truth`.
        videos: as in `ExportMap`; left out if there is a column of videos.
        groups: as in `ExportMap`.
        answers: texts of answers that are not labels.
    """
    keys: dict[str, Any] = dict(named)
    if "video" not in named:
        keys["videos"] = videos or None
    keys["answers"] = dict.fromkeys(answers) or None
    keys["groups"] = dict(groups) or None
    text = yaml.safe_dump(keys, sort_keys=False, allow_unicode=True, default_flow_style=False, width=10_000)
    return text.replace(": null\n", ":\n") + _COMMENTS


_COMMENTS = f"""\
# participant: the column that names the participants; "{EACH_ROW}" or "{EACH_FILE}" if each belongs to another one
# video, response: the columns of videos and of answers, in a table with one row for each answer
# truth: the column of the true emotion in such a table, if there is no key
# videos: a code for each column as above, or a list of codes for columns that ask one question, in their order
# answers: the label of each text above; none for "none of these", nothing for a missing answer
# rows: {{leave_out: {{column: [values]}}}} leaves out rows such as practice; keep: keeps only the rows it names
# repeats: first, last or all, if participants answered a video several times
# drop: {{column: [values]}} leaves out participants
# labels: [happiness, surprise, ...] if they are not the six emotions
"""


def unknown_column(where: ExportMap, path: KeyPath, title: str, hint: str) -> SourceError:
    """Return the error for a key of the map that names a column that no file has."""
    message = f"no file has the column {quoted(title)}{hint}; expected a column of the export"
    return SourceError(where.place(*path), message, 0, ".".join(map(str, path)))
