"""A reference from short runs of a vehicle with a weak thruster that its file does not know."""

from dataclasses import replace

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.reference.made import Made, made


@pytest.fixture(scope="module")
def reference() -> Made:
    case = small_case(
        ("thruster_degraded:thrust_fraction=0.6@front_left", "residual_buoyancy:force_n=-12"),
        manoeuvres=("prbs", "surge_steps"),
        seconds=24.0,
        effects=("residual_buoyancy", "thruster_degraded"),
    )
    return made(replace(case, runs=(), healthy=case.runs), threads=1)


def test_what_the_vehicle_was_like_is_learned(reference: Made) -> None:
    by_name = {one.name: one for one in reference.departures}
    weak = by_name["thruster_degraded:thrust_fraction@front_left"]
    assert weak.value == pytest.approx(0.6, abs=0.12)
    assert weak.neutral == 1.0
    assert weak.stands_out
    assert not by_name["thruster_degraded:thrust_fraction@rear_right"].value < 0.85


def test_what_the_file_lacks_is_alike_in_both_runs(reference: Made) -> None:
    heave = reference.axes["heave"]
    assert heave.unit == "N"
    assert heave.lacked > 8.0
    assert heave.same_share > 0.7
    assert heave.left < 0.5 * heave.lacked


def test_it_predicts_what_was_left_out_better_than_the_file(reference: Made) -> None:
    assert reference.held_out == "half of each run in turn"
    rows = {(row.method, row.quantity, row.ahead_s): row.rmse for row in reference.predictions}
    for quantity in ("velocity", "angular_velocity"):
        for seconds in (3.0, 6.0):
            own = rows["reference", quantity, seconds]
            assert own < 0.7 * rows["vehicle file", quantity, seconds]
            assert own < rows["last value", quantity, seconds]
    assert reference.used, reference.why
