"""Several stages in one process: each for itself."""

import json
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pipeline import stage_process
from pipeline.errors import InputError, Place
from pipeline.stage_process import run_steps
from pipeline.stages.job import Job


def stage(name: str) -> SimpleNamespace:
    """Copy the inputs' text; of an input "broken" end with a message, of "fault" with a fault."""

    def run(job: Job) -> str:
        text = "".join(path.read_text() for path in job.inputs)
        if "broken" in text:
            raise InputError.at(Place("log"), "is broken.")
        if "fault" in text:
            raise ZeroDivisionError("ours")
        print(f"at work as {name}")
        job.output.write_text(text)
        return ""

    return SimpleNamespace(run=run)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    def import_module(name: str) -> SimpleNamespace:
        return stage(name.rpartition(".")[2])

    monkeypatch.setattr(stage_process, "importlib", SimpleNamespace(import_module=import_module))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RIG2SEA_JOURNAL", str(tmp_path / "journal"))
    return tmp_path


def work(*items: str) -> list[dict[str, Any]]:
    """Two stages of each item, the second of which reads the first's result."""
    return [
        {
            "vehicle": "boat", "stage": name, "item": item, "code": "c", "inputs": [source],
            "outputs": [f"{item}.{to}"],
        }
        for item in items
        for name, source, to in (("first", item, "1"), ("second", f"{item}.1", "2"))
    ]  # fmt: skip


def events(place: Path) -> Sequence[tuple[str, str, str]]:
    lines = [json.loads(line) for line in (place / "journal").read_text().splitlines()]
    return [(one["item"], one["stage"], one["what"]) for one in lines if one["what"] != "started"]


@pytest.mark.parametrize("what", ["broken", "fault"])
def test_failed_stage_takes_only_its_own_item_with_it(place: Path, what: str) -> None:
    for name, text in (("a", "good"), ("b", what), ("c", "good")):
        (place / name).write_text(text)
    assert run_steps(work("a", "b", "c")) == 1
    assert sorted(path.name for path in place.glob("?.?")) == ["a.1", "a.2", "c.1", "c.2"]
    assert [(item, what) for item, _, what in events(place)] == [
        ("a", "done"),
        ("a", "done"),
        ("b", "failed"),
        ("c", "done"),
        ("c", "done"),
    ]


def test_each_stage_has_a_log_of_its_own(place: Path) -> None:
    for name in "ab":
        (place / name).write_text("good")
    assert run_steps(work("a", "b")) == 0
    logs = place / "processed/boat/logs"
    assert (logs / "first/a.log").read_text() == "at work as first\ndone\n"
    assert sorted(path.name for path in logs.rglob("*.log")) == ["a.log"] * 2 + ["b.log"] * 2
