"""Models of YAML files: groups of keys that pydantic validates, and one-line messages from its errors."""

import json
import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from math import isfinite
from pathlib import Path
from types import NoneType
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from emovid.errors import InputError, SourceError, nearest, reason
from emovid.yaml_source import KeyPath, Places, key_path, place_of

_EDITOR_LINE = "# yaml-language-server: $schema="
_BOUNDS = {
    "greater_than": ("gt", "more than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}
_WORDS: Mapping[KeyPath, str] = {
    ("video", "size"): "width x height in pixels, as in 1280x720",
    ("robot", "model"): "a robot's name, a file that ends in .yaml, or a group of keys",
    ("robot", "limits"): "a group of keys, model or null",
}
_TRUTHS = {"yes": "true", "on": "true", "1": "true", "no": "false", "off": "false", "0": "false"}
_UNITS = {"": 1, "s": 1, "ms": 1e-3, "m": 1, "cm": 1e-2, "mm": 1e-3, "fps": 1}  # that are typed behind numbers
# Not 1,234, which may be a thousand.
_NUMBER = re.compile(
    r"\s*(?P<number>[-+]?(0,\d+|\d[\d_]*,\d{1,2}|\d[\d_]*,\d{4,}|\d[\d_]*\.?\d*|\.\d+)([eE][-+]?\d+)?)\s*(?P<unit>s|ms|m|cm|mm|fps)?\s*"
)
_KINDS = {
    "float_type": "a number",
    "finite_number": "a finite number",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "string_unicode": "text of Unicode characters",
    "list_type": "a list",
    "tuple_type": "a list",
    "model_type": "a group of keys",
    "model_attributes_type": "a group of keys",
}


class Keys(BaseModel):
    """A group of keys: other keys are invalid, and values cannot change."""

    # Strict: "15" in quotes is text, and true is not a number. Whole numbers are valid real numbers.
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


def inconsistent(key: str, message: str) -> PydanticCustomError:
    """Return the error that a validator raises for an inconsistent value of a dotted key inside its group."""
    return PydanticCustomError("inconsistent", "{message}", {"key": key, "message": message})


def source_error(error: ValidationError, places: Places, root: type[BaseModel]) -> SourceError:
    """Return the first problem, by its line in the file, as a `SourceError`.

    Args:
        error: from the validation of a `root`.
        places: of the keys.
        root: the model that was validated.
    """
    items = error.errors(include_url=False)
    # pydantic counts a list with an invalid item as too short: only the item is reported.
    broken = {item["loc"][:n] for item in items for n in range(len(item["loc"]))}
    told = [item for item in items if item["type"] != "too_short" or item["loc"] not in broken]
    found = [(item["type"] == "missing", *_problem(item, root)) for item in told]
    placed = [(missing, place_of(path, places), path, message) for missing, path, message in found]
    # A misspelled key is also a missing one, on the line of its group: the misspelling is more useful.
    _, where, path, message = min(placed, key=lambda problem: (problem[0], _line(problem[1])))
    return SourceError(where, message, key=".".join(map(str, path)))


def _line(where: str) -> int:
    number = where.rsplit(":", 1)[-1]
    return int(number) if number.isdigit() else 0


def _problem(item: Mapping[str, Any], root: type[BaseModel]) -> tuple[KeyPath, str]:
    """Return the path of the key and the message of one pydantic error."""
    kind, given, context = item["type"], item["input"], item.get("ctx", {})
    path = _walk(item["loc"], root)[0]
    if kind == "inconsistent":
        return (*path, *key_path(context["key"])), context["message"]
    if kind == "extra_forbidden":
        return path, f"unknown key{_known_key(item['loc'], path, root)}"
    if kind == "missing":
        return path, f"missing ({_description(item['loc'], root)})"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        key = context["discriminator"].strip("'")
        expected = _tags(item["loc"], key, root)
        if kind == "union_tag_invalid":
            return (*path, key), _wrong_word(given[key], expected)
        close = get_close_matches(key, map(str, given), n=1, cutoff=0.7)
        if close:
            return (*path, close[0]), f"unknown key (did you mean {'.'.join(map(str, (*path, key)))}?)"
        return (*path, key), f"missing; expected {_one_of(expected)}"
    if kind == "literal_error":
        words = context["expected"].replace("' or '", "', '").strip("'").split("', '")
        return path, _wrong_word(given, [*words, *_null(item["loc"], root)])
    if kind in _BOUNDS:
        bound, words = _BOUNDS[kind]
        return path, f"{_shown(given)}: expected {words} {context[bound]:g}"
    hint = _nearest_value(kind, path, str(given))
    words = _expected(kind, path, context, item["msg"])
    return path, f"{_shown(given)}: expected {words}{hint and f' (did you mean {hint}?)'}"


def _nearest_value(kind: str, path: KeyPath, given: str) -> str:
    """Return the nearest valid value to the text of one of another kind, such as 0.02 for 20 mm; "" if unclear."""
    if kind == "bool_type":
        return _TRUTHS.get(given.lower(), "")
    if path == ("video", "size"):
        sides = re.fullmatch(r"\s*(\d+)\D+(\d+)\s*", given)
        return "x".join(f"{2 * round(int(side) / 2)}" for side in sides.groups()) if sides else ""
    found = _NUMBER.fullmatch(given)
    if kind not in ("float_type", "int_type") or not found or (found["unit"] == "m" and "duration" in path):
        return ""
    value = float(found["number"].replace("_", "").replace(",", ".")) * _UNITS[found["unit"] or ""]
    if not isfinite(value):
        return ""
    return f"{value:.0f}" if kind == "int_type" else f"{value:.12g}"


def _expected(kind: str, path: KeyPath, context: Mapping[str, Any], message: str) -> str:
    if "colours" in path and kind in ("string_type", "string_pattern_mismatch"):
        return 'a color in quotes, as in "#0072b2"'
    if path in _WORDS:
        return _WORDS[path]
    if kind == "too_short":
        return f"at least {context['min_length']}"
    if kind == "too_long":
        return f"at most {context['max_length']}"
    return _KINDS.get(kind, message)


def _shown(value: Any) -> str:
    if value is None:
        return "empty"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a group of keys"
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        return f"a list of {len(value)}"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _one_of(words: list[str]) -> str:
    return words[0] if len(words) == 1 else "one of " + ", ".join(words)


def _wrong_word(given: Any, expected: list[str]) -> str:
    hint = nearest(given, expected) if isinstance(given, str) else ""
    return f"{_shown(given)}: expected {_one_of(expected)}{hint}"


def _known_key(loc: KeyPath, path: KeyPath, root: type[BaseModel]) -> str:
    models = _models_at(loc[:-1], root)
    known = [field.alias or name for model in models for name, field in model.model_fields.items()]
    parents = "".join(f"{part}." for part in path[:-1])
    hint = nearest(str(path[-1]), known)
    if not hint and not parents:
        hint = next((f" (did you mean {path}?)" for path in _paths_to(str(path[-1]), root)), "")
        parents = ""
    return hint.replace("mean ", f"mean {parents}") if hint else f"; expected {_one_of(known)}"


def _paths_to(name: str, root: type[BaseModel]) -> Iterator[str]:
    """Yield the dotted paths of the keys of a name in the groups of a model."""
    for key, field in root.model_fields.items():
        for model in _models_in(field.annotation):
            if name in model.model_fields:
                yield f"{key}.{name}"


def _description(loc: KeyPath, root: type[BaseModel]) -> str:
    return next((str(field.description) for field in _fields_at(loc, root)), "a value")


def _null(loc: KeyPath, root: type[BaseModel]) -> list[str]:
    """Return "null" if a key may be null."""
    return ["null"] if any(NoneType in get_args(field.annotation) for field in _fields_at(loc, root)) else []


def _fields_at(loc: KeyPath, root: type[BaseModel]) -> list[FieldInfo]:
    """Return the fields that the last key of a pydantic location may stand for."""
    models, name = _models_at(loc[:-1], root), str(loc[-1])
    return [model.model_fields[name] for model in models if name in model.model_fields]


def _tags(loc: KeyPath, discriminator: str, root: type[BaseModel]) -> list[str]:
    models = _models_at(loc, root)
    return list(dict.fromkeys(_literal(model, discriminator) for model in models))


def _literal(model: type[BaseModel], field: str) -> str:
    return str(get_args(model.model_fields[field].annotation)[0])


def _models_at(loc: KeyPath, root: type[BaseModel]) -> list[type[BaseModel]]:
    """Return the models that a pydantic location may stand for: several at a union, one behind its tags."""
    return _walk(loc, root)[1]


def _walk(loc: KeyPath, root: type[BaseModel]) -> tuple[KeyPath, list[type[BaseModel]]]:
    """Follow a pydantic location from `root`: its path without the tags of unions, and its possible models."""
    models: list[type[BaseModel]] = [root]
    path: list[str | int] = []
    for part in loc:
        if len(models) > 1:  # at a union, pydantic names the tag that it chose
            models = [model for model in models if part in (model.__name__, *_literals_of(model))]
            continue
        path.append(part)
        if isinstance(part, str) and models and part in models[0].model_fields:
            models = _models_in(models[0].model_fields[part].annotation)
    return tuple(path), models


def _literals_of(model: type[BaseModel]) -> set[str]:
    fields = model.model_fields.values()
    return {get_args(field.annotation)[0] for field in fields if get_origin(field.annotation) is Literal}


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _models_in(argument)]


def with_schema(text: str, file: Path, schema: Mapping[str, Any]) -> dict[Path, bytes]:
    """Return the contents of a YAML file and, beside it, of its schema, which a first line names to editors.

    Args:
        text: of the file.
        file: to write.
        schema: JSON Schema of its keys; its title, as in "emovid scene", gives the name emovid-scene.schema.json.

    Raises:
        InputError: if another program wrote a file of that name.
    """
    title = schema["title"]
    target = file.with_name(f"{title.replace(' ', '-')}.schema.json")
    try:
        known = json.loads(target.read_bytes()) if target.exists() else {"title": title}
    except OSError as error:
        raise InputError(f"{target}: cannot be read: {reason(error)}") from None
    except ValueError:
        known = None
    if not isinstance(known, dict) or known.get("title") != title:
        raise InputError(f"{target}: was not written by emovid; move it, or choose another folder")
    lines = text.removeprefix("\ufeff").splitlines(keepends=True)
    if lines and lines[0].startswith(_EDITOR_LINE):
        lines = lines[1:]
    lines = [f"{_EDITOR_LINE}{target.name}\n", *lines]
    return {file: "".join(lines).encode(), target: f"{json.dumps(schema, indent=2)}\n".encode()}
