"""Additions to the pages of the site: references generated from the code, formulas, names of files outside it."""

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from typer import Context
from typer.cli import get_docs_for_click

from emovid.cli.main import all_commands
from emovid.scene.load import scene_schema

ROOT = Path(__file__).parent.parent
GALLERY = ROOT / "figures" / "gallery.html"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are generated from the code."""
    made = {"reference/commands.md": commands_page(), "reference/scene.md": scene_page()}
    made["gallery.html"] = GALLERY.read_text() if GALLERY.is_file() else "<!doctype html><p>Made by make docs.</p>"
    for path, text in made.items():
        files.append(File.generated(config, path, content=text))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Write formulas as MathML, and replace links to files outside the site by their names."""
    folder = Path(page.file.src_uri).parent
    parts = re.split(r"(^```.*?^```$|`[^`\n]+`)", markdown, flags=re.MULTILINE | re.DOTALL)
    return "".join(part if part.startswith("`") else _inside(part, folder) for part in parts)


def _inside(text: str, folder: Path) -> str:
    text = re.sub(r"\$\$(.+?)\$\$", lambda found: convert(found[1].strip(), display="block"), text, flags=re.DOTALL)
    text = re.sub(r"\$([^$\n]+)\$", lambda found: f"<span>{convert(found[1])}</span>", text)
    return re.sub(r"\[([^]]+)\]\((\.\./[^)]+)\)", lambda found: _named(found, folder), text)


def _named(link: "re.Match[str]", folder: Path) -> str:
    path = os.path.normpath(folder / link[2])
    if not path.startswith(".."):
        return link[0]
    name = path.removeprefix("../")
    return f"`{name}`" if Path(name).name == link[1] else f"{link[1]} (`{name}`)"


def commands_page() -> str:
    """Return the page of all commands, generated from the command line."""
    root = all_commands()
    return get_docs_for_click(obj=root, ctx=Context(root), name="emovid", title="Commands")


def scene_page() -> str:
    """Return the page of all keys of a scene, generated from the models that validate them."""
    schema = scene_schema()
    lines = [
        "# Keys of a scene",
        "",
        "Every key of a scene, with its unit in brackets, its valid values and its default. The scenes that come with "
        "emovid use them: `emovid scene show anger`. With the output of `emovid scene schema`, an editor completes and "
        "explains them.",
        "",
        "## Top level",
        "",
        *_table(schema, schema),
    ]
    shown: dict[str, str] = {}
    for group, options in _groups(schema, schema, ""):
        lines += ["", f"## `{group}`", ""]
        first = shown.get(options[0]["title"])
        if first:
            lines += [f"The keys of `{first}`." if len(options) == 1 else f"Each of the first forms of `{first}`."]
            continue
        for option in options:
            shown[option["title"]] = group
            mark = _mark(option)
            lines += [f"### {mark}", ""] if mark else []
            lines += [option.get("description", ""), "", *_table(option, schema), ""]
    return "\n".join(lines) + "\n"


def _groups(keys: dict[str, Any], schema: dict[str, Any], path: str) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield each key that contains keys, with its alternative forms."""
    for name, key in keys.get("properties", {}).items():
        options = list(_options(key, schema))
        if options:
            yield f"{path}{name}", options
            deeper = {key: value for option in options for key, value in option["properties"].items()}
            if not path.endswith(".parts."):  # a sum of densities has no other densities than those above it
                yield from _groups({"properties": deeper}, schema, f"{path}{name}.")


def _options(key: dict[str, Any], schema: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the alternative groups of keys of a key, each once."""
    if "$ref" in key:
        key = schema["$defs"][key["$ref"].split("/")[-1]]
    if "properties" in key:
        yield key
    for form in (*key.get("oneOf", ()), *key.get("anyOf", ()), key.get("items", {})):
        if form:
            yield from _options(form, schema)


def _mark(option: dict[str, Any]) -> str:
    """Return the keys whose constant value identifies a form, as in `kind: gaussian`."""
    consts = [f"`{name}: {key['const']}`" for name, key in option["properties"].items() if "const" in key]
    return " ".join(sorted(consts, key=lambda mark: "law" not in mark))


def _table(group: dict[str, Any], schema: dict[str, Any]) -> list[str]:
    lines = ["| key | meaning | values | default |", "|---|---|---|---|"]
    for name, key in group["properties"].items():
        needed = "const" in key or name in group.get("required", ())
        default = "required" if needed else _value(key.get("default"))
        cells = (f"`{name}`", key.get("description", ""), _values(key, schema), default)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return lines


def _value(default: object) -> str:
    if isinstance(default, dict):
        return "as below"
    if isinstance(default, list):
        return ", ".join(f"`{value}`" for value in default)
    return f"`{'null' if default is None else str(default).lower() if isinstance(default, bool) else default}`"


def _values(key: dict[str, Any], schema: dict[str, Any]) -> str:
    """Return the valid values of a key in words."""
    if "$ref" in key:
        key = schema["$defs"][key["$ref"].split("/")[-1]]
    if "const" in key:
        return f"`{key['const']}`"
    if "enum" in key:
        return ", ".join(f"`{value}`" for value in key["enum"])
    forms = [form for form in (*key.get("anyOf", ()), *key.get("oneOf", ())) if form]
    if forms:
        return " or ".join(dict.fromkeys(_values(form, schema) for form in forms))
    words = {"integer": "whole number", "number": "number", "boolean": "true or false", "string": "text"}
    words |= {"object": "keys", "array": "list", "null": "null"}
    text = words.get(str(key.get("type")), "")
    bounds = (
        ("minimum", "at least"),
        ("exclusiveMinimum", "above"),
        ("maximum", "at most"),
        ("exclusiveMaximum", "below"),
    )
    limits = [f"{word} {key[bound]:g}" for bound, word in bounds if bound in key]
    return " ".join([text, ", ".join(limits)]).strip()
