"""Data from which no diagnosis can be made get a plain reason."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case
from pipeline.diagnose.preconditions import check_preconditions
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray


@pytest.fixture(scope="module")
def case() -> Case:
    return small_case(manoeuvres=("prbs",), seconds=32.0)


def changed(case: Case, **values: FloatArray) -> Case:
    run = case.runs[0]
    return replace(case, runs=(replace(run, values=run.values | values),))


def test_a_usable_case_passes(case: Case) -> None:
    check_preconditions(case)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda case: replace(case, runs=()), "no run was given"),
        (
            lambda case: replace(
                case,
                runs=(
                    replace(
                        case.runs[0],
                        time_s=case.runs[0].time_s[:400],
                        values={k: v[:400] for k, v in case.runs[0].values.items()},
                        valid={k: v[:400] for k, v in case.runs[0].valid.items()},
                        reading={k: v[:400] for k, v in case.runs[0].reading.items()},
                    ),
                ),
            ),
            "at least 30 s",
        ),
        (
            lambda case: changed(case, command=np.zeros_like(case.runs[0].values["command"])),
            "all thrusters were off",
        ),
        (
            lambda case: changed(case, command=np.full_like(case.runs[0].values["command"], 90.0)),
            "commands never change",
        ),
        (
            lambda case: changed(case, command=10.0 * case.runs[0].values["command"]),
            "wrong vehicle file",
        ),
        (
            lambda case: changed(case, command=case.runs[0].values["command"][:, :5]),
            "commands of 5 thrusters and rov8 has 8",
        ),
        (
            lambda case: changed(case, velocity=np.ones_like(case.runs[0].values["velocity"])),
            "frozen",
        ),
        (
            lambda case: changed(case, command=np.full((1601, 8), np.nan)),
            "quantity thruster_command",
        ),
    ],
)
def test_hopeless_data_are_refused_with_the_reason(
    case: Case, spoil: Callable[[Case], Case], says: str
) -> None:
    with pytest.raises(CannotComputeError, match=says):
        check_preconditions(spoil(case))
