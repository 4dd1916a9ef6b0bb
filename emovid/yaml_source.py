"""YAML text to plain values with the line of every key, and one clear error for text that is not YAML.

PyYAML reads YAML 1.1, where `1e-3` is text, `on` is true and `1:30` is ninety. Files are read by the core schema of
YAML 1.2 instead (yaml.org/spec/1.2.2, section 10.3), which is what people expect. Tags, anchors and aliases are
refused: no file needs them, and with them a small file can expand to a huge or endless one.
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
    """Composes nodes by the core schema, refuses anchors and aliases, and keeps explicit tags visible."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - as PyYAML declares it; empty, so that only ours apply

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        event = self.peek_event()  # type: ignore[no-untyped-call]
        if event.anchor is not None:  # an alias has the name of its anchor there
            mark = event.start_mark
            raise yaml.MarkedYAMLError(problem="anchors and aliases are not supported", problem_mark=mark)
        node = super().compose_node(parent, index)
        if node is not None and event.tag is not None:  # unlike the tags of plain values, so that it is refused
            node.tag = event.tag.replace(_CORE, "!!")
        return node

    def scan_to_next_token(self) -> None:
        """Skip spaces, comments and line breaks, and tabs where YAML 1.2 allows them (sections 6.2 and 6.6)."""
        super().scan_to_next_token()
        while self.peek() == "\t" and self._may_skip_tab():
            self.forward()
            super().scan_to_next_token()

    def _may_skip_tab(self) -> bool:
        """Return whether a tab indents nothing: it follows a word, or only a comment or nothing follows it."""
        line = self.buffer.rfind("\n", 0, self.pointer) + 1
        before, after = self.buffer[line : self.pointer], self.buffer[self.pointer :].lstrip(" \t")
        return bool(before.strip(" \t-?")) or after[:1] in ("#", "\n", "\r", "\0")


class _WordLoader(_Loader):
    """Leaves numbers and booleans as text."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - as above


for _name, _pattern, _first in _RESOLVERS:
    _Loader.add_implicit_resolver(_CORE + _name, re.compile(_pattern), _first)
    if _name == "null":
        _WordLoader.add_implicit_resolver(_CORE + _name, re.compile(_pattern), _first)


def read_yaml(text: str, where: str, what: str = "scene", as_words: bool = False) -> tuple[Any, dict[KeyPath, str]]:
    """Return the values in `text` and, for the path of each key, its place, as in ``"file:line"``.

    Args:
        text: one YAML document.
        where: its name in messages, usually the file.
        what: the kind of file, for messages.
        as_words: whether to keep values as text, 007 and 1.50 too; a missing value is None.

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
        if "'\\t'" in problem:
            problem = "a tab; expected spaces"
        elif "'?'" in problem:
            problem += "; text with a question mark inside { } or [ ] needs quotes"
        elif "<block end>" in problem or "simple key" in problem or "mapping values" in problem:
            problem = "this line or the one before it has a wrong indentation, or lacks its colon"
        raise SourceError(f"{where}{line}", f"not YAML: {problem}") from None
    except yaml.YAMLError as error:
        raise SourceError(where, f"not YAML: {str(error).splitlines()[0]}") from None
    except (ValueError, OverflowError):  # from PyYAML, for characters outside Unicode and endless version numbers
        raise SourceError(where, "not YAML: a character or number out of range") from None
    except RecursionError:
        raise SourceError(where, f"not a {what}: nested too deeply") from None


def read_value(text: str, where: str) -> Any:
    """Return the value of `text` as in a scene; a leading ``#`` starts a color, and empty text is null."""
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
        _refuse(node, path, where, f"{node.value[:40]!r} is not a valid {kind}")


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
    if len(text) > 40:  # no key takes such a number, and Python refuses to print the longest ones
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
    """Return the path of a dotted key; numbers are indices of lists."""
    return tuple(int(part) if part.isdecimal() and len(part) < 10 else part for part in key.split("."))


def place_of(path: KeyPath, places: Places) -> str:
    """Return the place of a key, or of the innermost written group around it."""
    return next((places[path[:n]] for n in range(len(path), -1, -1) if path[:n] in places), "")
