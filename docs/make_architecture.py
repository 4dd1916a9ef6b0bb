"""Draw the folders of the package and which of them use which, from the imports in the code.

Usage: python docs/make_architecture.py FILE.svg
"""

import ast
import sys
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "emovid"

# Column and row of each folder: data flows from top to bottom. The last two may use all of the others.
PLACES = {
    "scene": (0, 0),
    "responses": (3, 0),
    "swarm": (0, 1),
    "statistics": (3, 1),
    "measure": (0, 2),
    "video": (1, 2),
    "report": (2, 1),
    "kit": (3, 3),
    "platforms": (1, 3),
    "figures": (2, 3),
    "survey": (3, 4),
    "batch": (0, 4),
}
JOINING = ("workflows", "cli")
SUBJECTS = {
    "scene": "YAML to a valid scene",
    "swarm": "laws, robots, trajectory",
    "measure": "descriptors, claims",
    "video": "cameras, drawing, ffmpeg",
    "platforms": "testbeds",
    "batch": "many items, workers",
    "figures": "figures for print",
    "responses": "survey exports to answers",
    "statistics": "answers to results",
    "report": "results to pages, tables",
    "kit": "a blinded study",
    "survey": "the study in browsers",
    "workflows": "tasks that join several of the folders above",
    "cli": "the commands: each parses its options, calls one function, prints",
}
WIDTH, HEIGHT, STEP_X, STEP_Y, MARGIN = 196, 50, 224, 92, 16


def folder_imports() -> dict[str, set[str]]:
    """Return for each folder of the package the folders that its modules import."""
    found: dict[str, set[str]] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        folder = path.relative_to(PACKAGE).parts[0]
        if folder.endswith(".py"):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            for name in names:
                parts = name.split(".")
                if parts[0] == "emovid" and len(parts) > 1 and (PACKAGE / parts[1]).is_dir() and parts[1] != folder:
                    found.setdefault(folder, set()).add(parts[1])
        found.setdefault(folder, set())
    return found


def direct(uses: dict[str, set[str]]) -> dict[str, set[str]]:
    """Return the imports without those that another import implies (the transitive reduction)."""
    reached: dict[str, set[str]] = {}
    for folder in TopologicalSorter(uses).static_order():
        reached[folder] = uses[folder].union(*(reached[name] for name in uses[folder]))
    return {folder: used - set().union(*(reached[name] for name in used)) for folder, used in uses.items()}


def picture(uses: dict[str, set[str]]) -> str:
    """Return the picture as SVG text: an arrow leads from a folder to each one that uses it."""
    columns, rows = max(x for x, _ in PLACES.values()), max(y for _, y in PLACES.values()) + len(JOINING)
    size = (2 * MARGIN + columns * STEP_X + WIDTH, 2 * MARGIN + rows * STEP_Y + HEIGHT)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]:g} {size[1]:g}" '
        'font-family="sans-serif" font-size="13" role="img" aria-label="The folders of the package">',
        '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 0L10 5L0 10z" fill="#607080"/></marker></defs>',
        f'<rect width="{size[0]:g}" height="{size[1]:g}" fill="#ffffff"/>',
    ]
    for folder, used in sorted(direct(uses).items()):
        lines += [_arrow(name, folder) for name in sorted(used) if folder not in JOINING]
    for folder, (column, row) in PLACES.items():
        lines += _box(folder, MARGIN + column * STEP_X, MARGIN + row * STEP_Y, WIDTH)
    for i, folder in enumerate(JOINING):
        lines += _box(folder, MARGIN, MARGIN + (rows - len(JOINING) + 1 + i) * STEP_Y, size[0] - 2 * MARGIN)
    return "\n".join([*lines, "</svg>", ""])


def _box(folder: str, x: float, y: float, width: float) -> list[str]:
    """Return the box of a folder: its name, and its subject below."""
    middle = f'x="{x + width / 2:g}" text-anchor="middle"'
    return [
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{HEIGHT}" rx="7" fill="#eef3f8" stroke="#4a6a8a"/>',
        f'<text {middle} y="{y + 21:g}" font-weight="bold">{folder}</text>',
        f'<text {middle} y="{y + 39:g}" fill="#405060">{SUBJECTS[folder]}</text>',
    ]


def _arrow(start: str, end: str) -> str:
    """Return a curve from the lower edge of one folder to the upper edge of another."""
    (x0, y0), (x1, y1) = (
        (MARGIN + PLACES[name][0] * STEP_X + WIDTH / 2, MARGIN + PLACES[name][1] * STEP_Y) for name in (start, end)
    )
    if y0 == y1:  # beside one another
        side = 1 if x1 > x0 else -1
        x0, x1, y = x0 + side * WIDTH / 2, x1 - side * WIDTH / 2, y0 + HEIGHT / 2
        path = f"M{x0:g} {y:g}L{x1:g} {y:g}"
    else:
        y0 += HEIGHT
        bend = (y1 - y0) / 2
        path = f"M{x0:g} {y0:g}C{x0:g} {y0 + bend:g} {x1:g} {y1 - bend:g} {x1:g} {y1:g}"
    return f'<path d="{path}" fill="none" stroke="#607080" marker-end="url(#tip)"/>'


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(picture(folder_imports()), encoding="utf-8")
