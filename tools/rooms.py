"""Draw the rooms of the package from the import contract, into docs/images/rooms.svg: `rooms.py [--check]`.

A room imports only from rows below its own.  `--check` draws nothing, and exits with 1 if the picture is old.
"""

import sys
import tomllib
from ast import get_docstring, parse
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs" / "images" / "rooms.svg"
WIDTH, ROW, BOX, GAP = 960, 66, 52, 12


def floors() -> list[list[str]]:
    """Return the rooms of each layer, the outermost first."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = next(each["layers"] for each in contracts if each.get("exhaustive"))
    return [layer.split(" | ") for layer in layers if layer != "__main__"]


def purpose(room: str) -> str:
    """Return the first sentence of a room's docstring."""
    package = ROOT / "src" / "axistwin" / room
    source = package / "__init__.py" if package.is_dir() else package.with_suffix(".py")
    text = get_docstring(parse(source.read_text(encoding="utf-8"))) or ""
    return text.split(".")[0].split("\n\n")[0]


def words(text: str, width: int) -> list[str]:
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) >= width // 6.4:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines[:2]


def drawn() -> str:
    """Return the picture: a row for each layer, a box for each room."""
    rows = floors()
    height = ROW * len(rows) + GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif">',
        f'<rect width="{WIDTH}" height="{height}" fill="#e4e7ea"/>',
    ]
    for floor, rooms in enumerate(rows):
        wide = (WIDTH - GAP) // len(rooms) - GAP
        for place, room in enumerate(rooms):
            x, y = GAP + place * (wide + GAP), GAP + floor * ROW
            parts.append(
                f'<rect x="{x}" y="{y}" width="{wide}" height="{BOX}" rx="4" fill="#f5f6f7" stroke="#7d8792"/>'
            )
            parts.append(f'<text x="{x + 10}" y="{y + 20}" font-size="15" fill="#1d5a96">{escape(room)}</text>')
            for line, text in enumerate(words(purpose(room), wide - 20)):
                parts.append(
                    f'<text x="{x + 10}" y="{y + 36 + 13 * line}" font-size="11" fill="#4d5864">{escape(text)}</text>'
                )
    return "\n".join([*parts, "</svg>", ""])


if __name__ == "__main__":
    if "--check" in sys.argv:
        sys.exit(PICTURE.read_text(encoding="utf-8") != drawn() and f"{PICTURE.name} is old: run {Path(__file__).name}")
    PICTURE.write_text(drawn(), encoding="utf-8")
