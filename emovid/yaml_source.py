"""YAML text to plain values, with the line of every key; and one clear line for text that is none.

PyYAML reads YAML 1.1, where `1e-3` is text, `on` is true and `1:30` is ninety. Scenes are read by the core schema of
YAML 1.2 instead (yaml.org/spec/1.2.2, section 10.3), which is what people mean. Tags, anchors and aliases are
refused: no scene needs them, and they are how a small file becomes a large or an endless one.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

import yaml

from emovid.errors import SourceError

KeyPath = tuple[str | int, ...]
Places = Mapping[KeyPath, str]

_CORE = "tag:yaml.org,2002:"
_RESOLVERS = (
    ("null", r"^(~|null|Null|NULL|)$", None),
    ("bool", r"^(true|True|TRUE|false|False|FALSE)$", None),
    ("int", r"^([-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+)$", None),
    ("float", r"^([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$", None),
)


class _Loader(yaml.SafeLoader):
    """Composes nodes by the core schema, refuses anchors and aliases, and shows the tags that were written."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - as PyYAML declares it; empty, so that only ours apply

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        event = self.peek_event()  # type: ignore[no-untyped-call]
        if event.anchor is not None:  # an alias has the name of its anchor there
            mark = event.start_mark
            raise yaml.MarkedYAMLError(problem="anchors and aliases are not supported", problem_mark=mark)
        node = super().compose_node(parent, index)
        if (
            node is not None and event.tag is not None
        ):  # keep it apart from the tags of plain values, so that it is refused
            node.tag = event.tag.replace(_CORE, "!!")
        return node


class _WordLoader(_Loader):
    """Leaves numbers and truths as they are written."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - as above


for _name, _pattern, _first in _RESOLVERS:
    _Loader.add_implicit_resolver(_CORE + _name, re.compile(_pattern), _first)
    if _name == "null":
        _WordLoader.add_implicit_resolver(_CORE + _name, re.compile(_pattern), _first)


def read_yaml(text: str, where: str, what: str = "scene", as_words: bool = False) -> tuple[Any, dict[KeyPath, str]]:
    """Return the values in `text` and, for the path of each key, the place it stands at, ``"file:line"``.

    Args:
        text: one YAML document.
        where: what to call it in messages, usually the file.
        what: it should hold, for messages.
        as_words: whether values are text as it stands there, 007 and 1.50 too, or None.

    Raises:
        SourceError: for a syntax error, a duplicate key, a tag, an alias, more than one document, or none.
    """
    places: dict[KeyPath, str] = {}
    try:
        node = yaml.compose(text, Loader=_WordLoader if as_words else _Loader)
        if node is None:
            raise SourceError(where, f"empty: expected a {what}")
        return _value(node, (), places, where), places
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark else ""
        problem = " ".join(str(error.problem or error.context).split()).removeprefix("but ")
        raise SourceError(f"{where}{line}", f"not YAML: {problem}") from None
    except yaml.YAMLError as error:
        raise SourceError(where, f"not YAML: {str(error).splitlines()[0]}") from None
    except (ValueError, OverflowError):  # PyYAML's own, for characters beyond Unicode and endless version numbers
        raise SourceError(where, "not YAML: a character or number beyond all bounds") from None
    except RecursionError:
        raise SourceError(where, f"not a {what}: nested too deeply") from None


def read_value(text: str, where: str) -> Any:
    """Return the value of `text` as it would be in a scene; a leading ``#`` is a colour, and nothing is null."""
    if text.startswith("#"):
        return text
    try:
        return read_yaml(text, where)[0] if text.strip() else None
    except SourceError as error:
        raise SourceError(where, error.message) from None


def _value(node: yaml.Node, path: KeyPath, places: dict[KeyPath, str], where: str) -> Any:
    places.setdefault(path, _place(node, where))
    if isinstance(node, yaml.MappingNode) and node.tag == _CORE + "map":
        return _mapping(node, path, places, where)
    if isinstance(node, yaml.SequenceNode) and node.tag == _CORE + "seq":
        return [_value(item, (*path, i), places, where) for i, item in enumerate(node.value)]
    kind = node.tag.removeprefix(_CORE)
    if not isinstance(node, yaml.ScalarNode) or kind not in _SCALARS:
        _refuse(node, path, where, f"tags such as {node.tag} are not supported")
    try:
        return _SCALARS[kind](node.value)
    except ValueError:
        _refuse(node, path, where, f"{node.value[:40]!r} is no {kind}")


def _mapping(node: yaml.MappingNode, path: KeyPath, places: dict[KeyPath, str], where: str) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for key, item in node.value:
        if not isinstance(key, yaml.ScalarNode):
            _refuse(key, path, where, "a key must be a word")
        name, place = key.value, _place(key, where)
        if name in values:
            first = places[*path, name].rsplit(":", 1)[-1]
            _refuse(key, (*path, name), where, f"given twice (first on line {first})")
        places[*path, name] = place
        values[name] = _value(item, (*path, name), places, where)
    return values


def _integer(text: str) -> int:
    if len(text) > 40:  # no key takes one, and Python refuses to print the longest
        raise ValueError(text)
    return int(text, 0) if text[:2] in ("0o", "0x") else int(text)


_SCALARS: dict[str, Callable[[str], Any]] = {
    "null": lambda _: None,
    "bool": lambda text: text.lower() == "true",
    "int": _integer,
    "float": lambda text: float(text.lower().replace(".inf", "inf").replace(".nan", "nan")),
    "str": str,
}


def _place(node: yaml.Node, where: str) -> str:
    return f"{where}:{node.start_mark.line + 1}"


def _refuse(node: yaml.Node, path: KeyPath, where: str, message: str) -> NoReturn:
    raise SourceError(_place(node, where), message, key=".".join(map(str, path)))


def key_path(key: str) -> KeyPath:
    """Return the path of a dotted key; numbers are places in a list."""
    return tuple(int(part) if part.isdecimal() and len(part) < 10 else part for part in key.split("."))


def place_of(path: KeyPath, places: Places) -> str:
    """Return the place of a key, or of the innermost group around it that was written."""
    return next((places[path[:n]] for n in range(len(path), -1, -1) if path[:n] in places), "")
