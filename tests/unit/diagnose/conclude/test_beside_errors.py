"""Answers beside errors of the instruments: names, ranking, what is asked of the rest."""

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.conclude.beside_errors import (
    alike_beside,
    case_beside,
    names_beside,
    ranking_beside,
)
from pipeline.diagnose.kinematics.instruments import InstrumentErrors
from pipeline.effects.specification import EffectSpec
from pipeline.physics.parameters import read
from pipeline.records.diagnosis import ParameterEstimate, RankedEffect

SCALE = ParameterEstimate(value=1.1, unit="1", ci95=(1.08, 1.12))
ERRORS = InstrumentErrors(
    (EffectSpec("dvl_scale", {"scale": 1.1}, None),), {"dvl_scale": {"scale": SCALE}}, 40.0
)
THRUST = ParameterEstimate(value=0.6, unit="1", ci95=(0.5, 0.7))


def row(effect: str, probability: float, **parameters: ParameterEstimate) -> RankedEffect:
    return RankedEffect(
        effect=effect,
        probability=probability,
        parameters=parameters,
        gap_closed=None,
        log_evidence=5.0,
    )


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("none",), ("dvl_scale",)),
        (("unknown",), ("dvl_scale", "unknown")),
        (("current",), ("current", "dvl_scale")),
        (("thruster_lag", "cg_shift"), ("cg_shift", "dvl_scale", "thruster_lag")),
    ],
)
def test_the_errors_are_part_of_every_answer(
    names: tuple[str, ...], expected: tuple[str, ...]
) -> None:
    assert names_beside(names, ERRORS) == expected
    assert names_beside(names, None) == names


def test_the_ranking_has_the_errors_in_every_answer_and_nothing_is_lost() -> None:
    before = (
        row("thruster_degraded", 0.7, thrust_fraction=THRUST),
        row("none", 0.2),
        row("unknown", 0.1),
        row("payload", 0.0),
    )
    found = {one.effect: one for one in ranking_beside(before, ERRORS)}
    assert list(found)[:3] == ["dvl_scale+thruster_degraded", "dvl_scale", "dvl_scale+unknown"]
    assert sum(one.probability for one in found.values()) == pytest.approx(1.0)
    assert found["dvl_scale"].parameters == {"scale": SCALE}
    assert found["dvl_scale+unknown"].parameters == {"scale": SCALE}
    assert found["dvl_scale+thruster_degraded"].parameters == {
        "dvl_scale.scale": SCALE,
        "thruster_degraded.thrust_fraction": THRUST,
    }
    assert found["dvl_scale"].log_evidence == 45.0
    assert {"none", "unknown", "payload"} <= {
        name for name, one in found.items() if one.probability == 0.0
    }
    assert ranking_beside(before, None) == before


def test_none_is_not_confusable_with_an_answer_that_has_errors() -> None:
    assert alike_beside(("none", "lift", "dvl_scale"), ERRORS) == ("lift",)
    assert alike_beside(("none", "lift"), None) == ("none", "lift")


def test_the_rest_is_asked_with_the_instrument_as_it_reads() -> None:
    case = small_case(seconds=1.0, manoeuvres=("hover",))
    beside = case_beside(case, ERRORS)
    assert float(read(beside.packed.vector, "dvl_scale")) == pytest.approx(1.1)
    np.testing.assert_array_equal(beside.stated.vector, case.packed.vector)
    assert set(beside.candidates) == set(case.candidates) - {"dvl_scale"}
