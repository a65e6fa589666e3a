"""What docs/tutorial.md tells a newcomer to type is typed, and what it shows comes.

Blocks of kind ``console`` are run line by line; a block whose first line is ``# raw/...`` is saved
there. A comment above a block, ``<!-- test: ... -->``, says when it counts, or what is typed in
place of a command that would take too long. Of the lines shown every word must come, in that order;
numbers and digests may differ, and ``...`` stands for any lines.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

WORKBOOK = "T200-Public-Performance-Data-10-20V-September-2019.xlsx"
#: From here on the page diagnoses, which takes as long as all before it.
DIAGNOSIS = "$ rig2sea diagnose "
_BLOCK = re.compile(r"(?m)^(?:<!-- test: (.+) -->\n)?```(console|yaml|csv)\n((?:.*\n)*?)```$")
_NUMBER = re.compile(r"-?\b\d+(\.\d+)?(e-?\d+)?\b|\b(?=[0-9a-f]*\d)[0-9a-f]{8,64}\b")


@dataclass(frozen=True)
class Step:
    """A command with the lines shown below it, or a file to save (then `shown` is its text)."""

    when: str
    command: str
    shown: str
    saved: bool


def steps(page: str) -> Iterator[Step]:
    """Read a tutorial."""
    for when, kind, body in _BLOCK.findall(page):
        if kind == "console":
            for one in re.split(r"(?m)^\$ ", body)[1:]:
                command, _, shown = one.partition("\n")
                yield Step(when, command, shown, saved=False)
        else:
            yield Step(when, body.partition("\n")[0].removeprefix("# "), body, saved=True)


def words(text: str) -> list[str]:
    """Lines with a mark in place of every number and digest."""
    return [_NUMBER.sub("#", line).rstrip() for line in text.splitlines() if line.strip()]


#: What a long command tells of its work: a line that goes away on a screen.
PROGRESS = re.compile(r"^(reading|weighing|simulating|fitting) .*\n", re.MULTILINE)


def missing(shown: str, came: str) -> str | None:
    """Return the first line shown that did not come; between two ``...`` the lines are unbroken."""
    got, at = words(came), 0
    anywhere = False
    for line in words(shown):
        if line == "...":
            anywhere = True
            continue
        rest = got[at:] if anywhere else got[at : at + 1]
        if line not in rest:
            return line
        at, anywhere = at + rest.index(line) + 1, False
    return None if anywhere or at == len(got) else f"nothing more, but there was: {got[at]}"


@pytest.fixture(scope="module")
def page(repository: Path) -> str:
    return (repository / "docs/tutorial.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def workbook(repository: Path) -> Path | None:
    """The public workbook, where it is at hand; else the page's made-up table takes its place."""
    stated = os.environ.get("RIG2SEA_SHARED_DATA")
    data = Path(stated) if stated else repository.parent / "shared/data"
    path = data / "t200_bollard" / WORKBOOK
    return path if path.is_file() else None


def counts(step: Step, workbook: Path | None) -> bool:
    conditions = {
        "nothing": False,
        "with the workbook": workbook is not None,
        "without the workbook": workbook is None,
        "with gcc": shutil.which("gcc") is not None,
    }
    return conditions.get(step.when, True)


def test_a_line_that_does_not_come_is_found() -> None:
    came = "a 1.25 s\nb\nc sha 1f2e3d4c5b6a\nd\n"
    assert missing("a 7 s\n...\nc sha 00112233aa\nd\n", came) is None
    assert missing("...\nd\n", came) is None
    assert missing("a 7 s\n...\n", came) is None
    assert missing("a 7 s\nc sha 1f2e3d4c5b6a\n...\n", came) == "c sha #"
    assert missing("...\nc sha 1f2e3d4c5b6a\n", came) == "nothing more, but there was: d"
    assert missing("...\nd\n...\nb\n", came) == "b"


def test_the_page_has_every_step(page: str) -> None:
    """A block that the pattern above did not know would be passed over in silence."""
    assert page.count("\n$ ") == len([step for step in steps(page) if not step.saved])
    assert page.count("```") == 2 * len(_BLOCK.findall(page))
    typed = {step.command.split()[1] for step in steps(page) if step.command.startswith("rig2sea")}
    assert typed == {"new", "check", "run", "why", "export", "simulate", "diagnose"}


def test_the_tutorial_to_its_diagnosis(
    page: str, bench_folder: Path, workbook: Path | None, tmp_path: Path
) -> None:
    before, diagnosis, _ = page.partition(DIAGNOSIS)
    assert diagnosis
    here = typed(before, bench_folder, workbook, tmp_path)
    tables = json.loads((here / "processed/t200/tables.json").read_bytes())
    assert len(tables["table3"]["positive"]) == 4


@pytest.mark.slow
def test_the_tutorial_to_its_end(
    page: str, bench_folder: Path, workbook: Path | None, tmp_path: Path
) -> None:
    here = typed(page, bench_folder, workbook, tmp_path)
    answer = json.loads((here / "processed/mmt300/diagnosis/diagnosis.json").read_bytes())
    assert "thruster_degraded" in json.dumps(answer)
    said = re.search(r"thrust_fraction = \S+ \[(\S+), (\S+)\]", page)
    assert said is not None
    assert float(said[1]) < 0.7 < float(said[2])


def typed(page: str, bench_folder: Path, workbook: Path | None, folder: Path) -> Path:
    """Type what a page says, and compare what comes; return the folder where it was typed."""
    here = folder / "first"
    shutil.copytree(bench_folder, here)
    here_first = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    for step in steps(page):
        if not counts(step, workbook):
            continue
        if step.saved:
            assert (here / step.command).parent.is_dir(), step.command
            (here / step.command).write_text(step.shown, encoding="utf-8")
            continue
        command = step.when if step.command == "make" else step.command
        if workbook is not None:
            command = command.replace(f"~/Downloads/{WORKBOOK}", str(workbook))
        done = subprocess.run(
            ["bash", "-c", command],
            cwd=here,
            env=here_first,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,  # as on a screen
            text=True,
            check=False,
            timeout=300,
        )
        assert done.returncode == 0, f"$ {command}\n{done.stdout}"
        assert missing(step.shown, PROGRESS.sub("", done.stdout)) is None, (
            f"$ {command}\n{done.stdout}"
        )
    return here
