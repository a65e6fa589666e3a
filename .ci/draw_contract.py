"""Draw the import contract of pyproject.toml into docs/architecture.md.

``make drawing`` writes it; a test compares the page with what this would write.
"""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "architecture.md"
BEGIN = "<!-- drawn from pyproject.toml by make drawing -->"
_ROOM = re.compile(r"pipeline[.](\w+)")
END = "<!-- end of the drawing -->"


def contracts() -> list[dict[str, object]]:
    """Return the contracts of the import linter."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        found: list[dict[str, object]] = tomllib.load(file)["tool"]["importlinter"]["contracts"]
    return found


def drawing() -> str:
    """Return the drawings (Mermaid) and the contracts beside the layers, as Markdown."""
    lines: list[str] = []
    sentences = []
    for contract in contracts():
        if contract["type"] == "layers":
            inside = _names(contract.get("containers"))
            if inside:
                lines += [f"**{contract['name']}** (inside {inside}):", ""]
            lines += _layers([str(layer) for layer in _list(contract["layers"])])
        elif contract["type"] == "forbidden":
            sentences.append(
                f"- **{contract['name']}.** {_names(contract['source_modules'])} may not import "
                f"{_names(contract['forbidden_modules'])}."
            )
    return "\n".join([*lines, *sentences])


def _layers(layers: list[str]) -> list[str]:
    rooms = [" · ".join(_ROOM.findall(layer) or layer.split(" | ")) for layer in layers]
    boxes = [f'    L{i}["{room}"]' for i, room in enumerate(rooms)]
    arrows = [f"    L{i} --> L{i + 1}" for i in range(len(layers) - 1)]
    return ["```mermaid", "flowchart TB", *boxes, *arrows, "```", ""]


def _list(value: object) -> list[object]:
    return list(value) if isinstance(value, list) else []


def _names(value: object) -> str:
    return ", ".join(f"`{str(name).removeprefix('pipeline.')}`" for name in _list(value))


def page() -> str:
    """Return the page with the drawing as it ought to be."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{drawing()}\n{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
