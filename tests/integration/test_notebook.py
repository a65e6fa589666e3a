"""The notebook of the documents is run, cell by cell."""

import json
from pathlib import Path
from typing import Any

import pytest

import pipeline


def test_from_a_log_to_a_verdict(repository: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(repository)
    path = repository / "docs/examples/log_to_verdict.ipynb"
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    names: dict[str, Any] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)  # noqa: S102 - what is tested
    best = names["answer"].iloc[0]
    assert (best["effect"], best["thruster"]) == ("thruster_degraded", "rear_left")
    assert best["ci95_low"] < 0.6 < best["ci95_high"]
    shown = "".join(cells[-1]["outputs"][0]["text"])
    assert shown.startswith(names["answer"].attrs["sentence"][:60])
    read = pipeline.read_run(names["log"], "rov8")
    assert read.index.name == "time_s"
    assert read["depth_m"].equals(names["run"]["depth_m"])
