"""Results as JSON: `results.json`, and the schema that it keeps."""

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from emovid.report import apa
from emovid.statistics.goodness import Goodness
from emovid.statistics.results import StudyResults

SCHEMA_VERSION = 2  # 1 is that of emovid 0.1.0, which did not name it


def results_json(results: StudyResults) -> str:
    """Return the text of `results.json`."""
    found = {"schema_version": SCHEMA_VERSION, **as_json(results)}
    return json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def as_json(value: object) -> Any:
    """Return results in JSON's types: NaN is null, arrays are lists, and each test has its sentence beside it."""
    if is_dataclass(value) and not isinstance(value, type):
        found = {field.name: as_json(getattr(value, field.name)) for field in fields(value)}
        if apa.has_sentence(type(value)):
            found["apa"] = apa.sentence(value)
        if isinstance(value, Goodness):
            found["apa_exact"] = apa.goodness_exact(value)
        return found
    if isinstance(value, Mapping):
        return {str(name): as_json(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return as_json(value.tolist())
    if isinstance(value, list | tuple):
        return [as_json(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def results_schema() -> dict[str, Any]:
    """Return the JSON Schema of `results.json`, made from the types of the results."""
    definitions: dict[str, Any] = {}
    root = _schema(StudyResults, definitions)
    study = definitions.pop(root["$ref"].rpartition("/")[2])
    study["properties"] = {"schema_version": {"const": SCHEMA_VERSION}, **study["properties"]}
    study["required"] = ["schema_version", *study["required"]]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "results.json of emovid study analyze",
        **study,
        "$defs": definitions,
    }


def _schema(kind: Any, definitions: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a type; those of dataclasses go to `definitions`."""
    origin, arguments = get_origin(kind), get_args(kind)
    if is_dataclass(kind) and isinstance(kind, type):
        if kind.__name__ not in definitions:
            definitions[kind.__name__] = {}
            definitions[kind.__name__] = _object_schema(kind, definitions)
        return {"$ref": f"#/$defs/{kind.__name__}"}
    if origin in (Union, UnionType):
        return {"anyOf": [_schema(option, definitions) for option in arguments]}
    if origin in (np.ndarray, tuple):
        return _array_schema(origin, arguments, definitions)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {"type": "object", "additionalProperties": _schema(arguments[1], definitions)}
    return {"type": _TYPES[kind]}


def _array_schema(origin: Any, arguments: tuple[Any, ...], definitions: dict[str, Any]) -> dict[str, Any]:
    if origin is np.ndarray:  # of one or two dimensions
        cell = {"type": "integer" if "int" in str(arguments) else ["number", "null"]}
        return {"type": "array", "items": {"anyOf": [cell, {"type": "array", "items": cell}]}}
    if arguments[-1] is Ellipsis:
        return {"type": "array", "items": _schema(arguments[0], definitions)}
    items = [_schema(item, definitions) for item in arguments]
    return {"type": "array", "prefixItems": items, "minItems": len(items), "maxItems": len(items)}


_TYPES: dict[type, str | list[str]] = {
    bool: "boolean",
    int: "integer",
    float: ["number", "null"],  # null where a number is undefined
    str: "string",
    NoneType: "null",
}


def _object_schema(kind: type, definitions: dict[str, Any]) -> dict[str, Any]:
    properties = {name: _schema(hint, definitions) for name, hint in _hints(kind).items()}
    if apa.has_sentence(kind):
        properties["apa"] = {"type": "string"}
    if kind is Goodness:
        properties["apa_exact"] = {"type": "string"}
    return {
        "description": (kind.__doc__ or "").partition("\n")[0],
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


@cache
def _hints(kind: type) -> dict[str, Any]:
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields(kind)}
