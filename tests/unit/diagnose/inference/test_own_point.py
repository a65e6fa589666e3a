"""An answer is gone on with until its values stay."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.inference import infer
from pipeline.diagnose.inference.own_point import ahead
from pipeline.diagnose.judging.search import Near
from pipeline.diagnose.linear.linear_model import Setting


def test_steps_that_shrink_alike_are_taken_at_once() -> None:
    step, last = np.array([0.5, -0.25]), np.array([1.0, -0.5])
    # 1/2 + 1/4 + ... of the step to come
    assert ahead(step, last) == pytest.approx(1.0)
    assert ahead(step, None) == 0.0


def test_steps_that_turn_back_are_not_lengthened_and_those_that_grow_not_without_end() -> None:
    assert ahead(np.array([0.5]), np.array([-1.0])) == 0.0
    assert ahead(np.array([2.0]), np.array([1.0])) == pytest.approx(4.0)


@pytest.mark.slow
def test_the_mass_of_a_module_that_is_nearly_floated_is_found_with_its_volume() -> None:
    """Counted by the mass the estimate stayed where it was begun, far along the valley."""
    case = small_case(
        ("payload:mass_kg=1.6,volume_m3=0.0011,x_m=0.08,y_m=-0.02,z_m=0.15",),
        effects=("payload", "residual_buoyancy", "cg_shift", "added_mass"),
    )
    found = diagnose(case, threads=1)
    assert found.verdict.effects == ("payload",)
    values = found.ranking[0].parameters
    for name, true in (("mass_kg", 1.6), ("volume_m3", 0.0011), ("x_m", 0.08), ("z_m", 0.15)):
        low, high = values[name].ci95
        assert low <= true <= high
        assert values[name].value == pytest.approx(true, rel=0.15)


def test_values_do_not_depend_on_where_all_was_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thrust deduction judged where the supply is low came out at another value."""
    real = infer.approach

    def elsewhere(setting: Setting, *rest: Any, **more: Any) -> Near:  # noqa: ANN401 (passed on)
        near = real(setting, *rest, **more)
        names = [one.name for one in setting.coordinates]
        moved = near.departures.copy()
        moved[names.index("voltage_sag:drop")] += 2.5
        return replace(near, departures=moved)

    case = small_case(("thrust_deduction:t=0.3",), effects=("thrust_deduction", "voltage_sag"))
    values = [diagnose(case, threads=1).ranking[0].parameters["t"].value]
    monkeypatch.setattr(infer, "approach", elsewhere)
    monkeypatch.setattr(infer, "_ELSEWHERE", np.inf)  # nor is the first answer's own point gone to
    values.append(diagnose(case, threads=1).ranking[0].parameters["t"].value)
    assert values[1] == pytest.approx(values[0], abs=0.02)
