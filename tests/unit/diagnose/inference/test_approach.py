"""The way from the nominal model to the point of a strong fault."""

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import channels_of, led_by, setting_of
from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.inference.approach import approach
from pipeline.diagnose.judging.search import ordinary_prior
from pipeline.diagnose.linear.coordinates import counted_by_size, recounted
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.diagnose.linear.scales import levels
from pipeline.types import FloatArray


def reached(*faults: str, effects: tuple[str, ...]) -> dict[str, float]:
    """Departures of the point that is gone to, by the names of their coordinates.

    Places are counted by all that there is of what they are the place of.
    """
    case = small_case(faults, effects=effects)
    channels = channels_of(case.vehicle, case.runs)
    setting = setting_of(case, case.runs, channels)

    def lead(at: Setting, vector: FloatArray) -> Setting:
        return led_by(at, case.packed, case.runs, channels, vector)

    near = approach(
        setting, lead, ordinary_prior(setting), levels(healthy_known=False), healthy_known=False
    )
    by_size = counted_by_size(setting.coordinates)
    departures = recounted(setting.coordinates, by_size, near.departures)
    return {one.name: float(value) for one, value in zip(by_size, departures, strict=True)}


def test_payload_is_reached_with_its_place() -> None:
    found = reached(
        "payload:mass_kg=2.25,volume_m3=0.0005,x_m=0.0,y_m=0.065,z_m=0.15",
        effects=("payload", "residual_buoyancy", "cg_shift", "added_mass"),
    )
    # counted in half the plausible range; a place as the product with how much there is
    assert found["payload:mass_kg"] == pytest.approx(0.225, abs=0.05)
    assert found["payload:y_m"] == pytest.approx(0.225 * 0.065 / 0.25, abs=0.015)
    assert found["payload:z_m"] == pytest.approx(0.225 * 0.15 / 0.25, abs=0.03)


@pytest.mark.slow
def test_a_module_that_is_missing_and_nearly_floated_is_reached() -> None:
    """Its weight hardly shows, and from where nothing is missing neither does its place."""
    found = reached(
        "payload:mass_kg=-1.1,volume_m3=-0.0009,x_m=0.0,y_m=0.05,z_m=0.2",
        effects=("payload", "residual_buoyancy", "cg_shift", "added_mass"),
    )
    size = -np.hypot(found["payload:mass_kg"], found["payload:volume_m3"])
    assert found["payload:mass_kg"] - found["payload:volume_m3"] == pytest.approx(-0.02, abs=0.01)
    assert found["payload:mass_kg"] == pytest.approx(-0.11, abs=0.04)
    assert found["payload:z_m"] / size * 0.25 == pytest.approx(0.2, abs=0.07)


def test_shift_far_beyond_what_is_stated_is_reached() -> None:
    found = reached("cg_shift:dy_m=0.009", effects=("cg_shift", "residual_buoyancy", "lift"))
    assert found["cg_shift:dy_m"] == pytest.approx(0.009 / 0.025, rel=0.1)
    assert np.abs([value for name, value in found.items() if "residual" in name]).max() < 0.1


def test_both_of_two_effects_are_reached() -> None:
    found = reached(
        "dead_zone:codes=30",
        "dvl_misalignment:yaw_deg=8",
        effects=("dead_zone", "dvl_misalignment", "added_mass", "current"),
    )
    assert found["dead_zone:codes"] == pytest.approx(30 / 30, rel=0.1)
    assert found["dvl_misalignment:yaw_deg"] != pytest.approx(0.0, abs=0.5)


def test_current_on_a_vehicle_that_hardly_moves_is_reached_from_its_strong_side(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its drag grows with the square of the current: next to no derivative without one."""
    monkeypatch.setattr("pipeline.diagnose.inference.approach._TRIED", 0)
    monkeypatch.setattr("pipeline.diagnose.inference.approach._TRIED_LOUD", 0)
    monkeypatch.setattr("pipeline.diagnose.inference.approach._QUIET", np.inf)
    monkeypatch.setattr("pipeline.diagnose.inference.trials.Follower.anew", lambda *_: [])
    found = reached("current:north_mps=-0.3", effects=("current", "linear_damping"))
    # counted in half the plausible range, 0.25 m/s
    assert found["current:north_mps"] == pytest.approx(-0.3 / 0.25, rel=0.1)
    assert abs(found["current:east_mps"]) < 0.1


def test_where_nothing_that_was_tried_explains_the_runs_the_others_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("pipeline.diagnose.inference.approach._TRIED", 0)
    monkeypatch.setattr("pipeline.diagnose.inference.approach._TRIED_LOUD", 0)
    # nor is it found where all are judged anew
    monkeypatch.setattr("pipeline.diagnose.inference.trials.Follower.anew", lambda *_: [])
    effects = ("current", "linear_damping", "added_mass")
    found = reached("current:east_mps=0.4", effects=effects)
    # counted in half the plausible range, 0.25 m/s
    assert found["current:east_mps"] == pytest.approx(0.4 / 0.25, rel=0.1)
    assert abs(found["current:north_mps"]) < 0.1


def test_dead_zone_beyond_what_is_plausible_is_reached() -> None:
    """Its signature changes so fast with its size that it must be tried near where it is."""
    found = reached(
        "dead_zone:codes=84", effects=("dead_zone", "thrust_deduction", "linear_damping", "lift")
    )
    assert found["dead_zone:codes"] == pytest.approx(84.0 / 30.0, rel=0.03)


@pytest.mark.slow
def test_a_long_lag_is_reached_though_what_is_stated_imitates_it_afar() -> None:
    """It was looked for only where stated masses and drags, far out, had taken its place."""
    found = reached(
        "thruster_lag:lag_s=1.0",
        effects=(
            "thruster_lag",
            "added_mass",
            "linear_damping",
            "quadratic_damping",
            "lift",
            "cg_shift",
            "thruster_degraded",
            "thrust_deduction",
            "dead_zone",
        ),
    )
    assert found["thruster_lag:lag_s"] == pytest.approx(2.0, abs=0.2)


@pytest.mark.slow
def test_what_leads_the_model_astray_is_found_beside_a_strong_fault() -> None:
    """The model is led along the DVL's velocity, taken as if the DVL were where it is stated."""
    case = small_case(
        ("dead_zone:codes=100", "dvl_lever_arm:x_m=0.55,y_m=0.07,z_m=0.24"),
        effects=("dead_zone", "dvl_lever_arm", "thrust_deduction", "added_mass"),
    )
    found = diagnose(case)
    assert found.verdict.effects == ("dead_zone", "dvl_lever_arm")
    values = {name: one.value for name, one in found.ranking[0].parameters.items()}
    assert values["dead_zone.codes"] == pytest.approx(100.0, rel=0.03)
    assert values["dvl_lever_arm.x_m"] == pytest.approx(0.55, rel=0.05)
