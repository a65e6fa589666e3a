"""A fit that comes to nothing says so; it does not end the program."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.records.base import Record
from pipeline.stages.job import Job, leave_record


class Found(Record):
    """A result as the records are: finite."""

    mass_kg: float


def no_solution() -> Found:
    np.linalg.cholesky(-np.eye(2))
    return Found(mass_kg=1.0)


@pytest.mark.parametrize(
    ("compute", "told"),
    [
        (no_solution, "the equations have no solution"),
        (lambda: Found(mass_kg=float("nan")), "mass_kg came out as no finite number"),
    ],
)
def test_a_stage_leaves_the_reason(
    compute: Callable[[], Record], told: str, tmp_path: Path
) -> None:
    out = tmp_path / "processed/boat/static.json"
    file = tmp_path / "raw/boat/vehicle.yaml"
    file.parent.mkdir(parents=True)
    file.write_text("name: boat\n", encoding="utf-8")
    said = leave_record(Job("static", "boat", "", (file,), out), compute)
    assert told in said
    assert told in out.read_text(encoding="utf-8")
