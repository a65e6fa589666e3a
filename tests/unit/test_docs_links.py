"""Every link of the documents leads somewhere, and every command and page is named."""

import importlib.util
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from pipeline.cli import cli

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        *ROOT.glob("*.md"),
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "raw/mmt300").glob("*.md"),
        *(ROOT / "benchmarks").glob("*.md"),
    ]
)
_CODE = re.compile(r"(?ms)^```.*?^```$|^<!--.*?-->$|^(?: {4}|\t).*?$|`[^`\n]*`")
_CALL = re.compile(r"(?:^|[`$=]\s*|\s)(rig2sea|make|python -m) ([a-z][\w.-]*(?:\s[^`#]*)?)")
_LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\[\]]*\])*\]\(([^()\s]*)\)")
_HEADING = re.compile(r"(?m)^#{1,6} +(.+?) *$")


def links(text: str) -> Iterator[str]:
    """Targets of the links of a page; code is no link."""
    return (found[1] for found in _LINK.finditer(_CODE.sub("", text)))


def anchors(text: str) -> set[str]:
    """Names of the headings as the usual viewers of Markdown make them."""
    heads = _HEADING.findall(re.sub(r"(?ms)^```.*?^```$", "", text))
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def fault(page: Path, target: str, root: Path = ROOT) -> str | None:
    """Return what is wrong with a link, if anything."""
    if re.match(r"(https?|mailto):", target):
        return None
    place, _, anchor = target.partition("#")
    path = (page.parent / place).resolve() if place else page
    if not path.exists():
        return f"{target}: there is no such file"
    if not path.is_relative_to(root):
        return f"{target}: leads out of the project"
    if anchor and anchor not in anchors(path.read_text(encoding="utf-8")):
        return f"{target}: no such heading"
    return None


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_of_a_page_resolve(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert [found for target in links(text) if (found := fault(page, target))] == []


def test_every_document_is_reached_from_the_readme() -> None:
    """Only from page to page: a page that nobody finds helps nobody."""
    reached: set[Path] = set()
    ahead = [ROOT / "README.md"]
    while ahead:
        page = ahead.pop()
        if page in reached or page.suffix != ".md":
            continue
        reached.add(page)
        for target in links(page.read_text(encoding="utf-8")):
            place = (page.parent / target.partition("#")[0]).resolve()
            if place.is_dir():
                ahead += place.glob("*.md")
            elif place.is_file():
                ahead.append(place)
    documents = {page for page in PAGES if page.is_relative_to(ROOT / "docs")}
    assert sorted(page.name for page in documents - reached) == []


def test_the_readme_has_every_command() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = {name for name, command in cli.commands.items() if not command.hidden}
    assert set(re.findall(r"(?m)^\| `rig2sea (\w+)` \|", text)) == shown


def commands(text: str) -> Iterator[tuple[str, str]]:
    """Yield (program, the rest of the line) of all that the code of a page calls."""
    for code in _CODE.findall(text):
        for line in code.replace("\\\n", " ").splitlines():
            for found in _CALL.finditer(line):
                yield found[1], found[2]


def wrong_call(program: str, rest: str) -> str | None:
    """Return what is wrong with a call, if anything."""
    name = rest.split(maxsplit=1)[0]
    if program == "make":
        targets = re.findall(r"(?m)^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"))
        return None if name in targets else f"make {name}: there is no such target"
    if program == "python -m":
        found = importlib.util.find_spec(name)
        return None if found is not None else f"python -m {name}: there is no such module"
    command = cli.commands.get(name)
    if command is None:
        return f"rig2sea {name}: there is no such command"
    parts = [command, *getattr(command, "commands", {}).values()]
    known = {
        option
        for part in parts
        for param in part.params
        for option in param.opts + param.secondary_opts
    }
    asked = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", rest))
    odd = sorted(asked - known - {"--help"})
    return f"rig2sea {name}: there is no {', '.join(odd)}" if odd else None


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_commands_of_a_page_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert [odd for call in commands(text) if (odd := wrong_call(*call)) is not None] == []


def test_a_bad_command_is_found() -> None:
    text = "`rig2sea fly x`, `make hay`\n\n    rig2sea run boat --cors 2\n\nrig2sea turns"
    assert [wrong_call(*call) for call in commands(text)] == [
        "rig2sea fly: there is no such command",
        "make hay: there is no such target",
        "rig2sea run: there is no --cors",
    ]
    assert wrong_call("python -m", "benchmarks.nothing") is not None


def test_a_bad_link_is_found(tmp_path: Path) -> None:
    text = "# A b: c\n[x](gone.md) [y](#a-b-c) `[z](no.md)`\n\n    [code](no.md)\n[w](#d)"
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    assert list(links(text)) == ["gone.md", "#a-b-c", "#d"]
    assert [fault(page, target, tmp_path) for target in ("gone.md", "#a-b-c", "#d")] == [
        "gone.md: there is no such file",
        None,
        "#d: no such heading",
    ]
    assert fault(page, "../", tmp_path) == "../: leads out of the project"
