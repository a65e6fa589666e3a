"""Propeller of the B-series: polynomials, Table 3, optimum, limits, what cannot be."""

import numpy as np
import pytest
from design_cases import propeller

from pipeline.bundled.design import design_example
from pipeline.design.propeller_cavitation import burrill, keller_area_ratio
from pipeline.design.propeller_design import design_propeller, drive_limit
from pipeline.design.propeller_input import DriveCurve, DrivePoint, PropellerInput, WaterInput
from pipeline.design.propeller_select import Task, full_power, least_power, most_thrust, screw
from pipeline.design.propeller_series import (
    THRUST_TERMS,
    TORQUE_TERMS,
    Geometry,
    reynolds_correction,
    thrust_coefficient,
    torque_coefficient,
)
from pipeline.errors import CannotComputeError
from pipeline.vehicle.load import load_checked

INPUT = PropellerInput.model_validate(
    {
        "name": "test",
        "title": "test",
        "required": {"thrust_n": 60.0, "speed_mps": 3.0},
        "drive": {
            "kind": "curve",
            "shaft_speed_rpm": (600.0, 900.0, 1200.0, 1500.0),
            "torque_nm": (3.4, 3.0, 2.4, 1.2),
        },
        "water": {"density_kgpm3": 1000.0, "shaft_depth_m": 1.0},
        "bounds": {"diameter_m": (0.10, 0.22), "blades": (3,)},
    }
)


def test_the_series_has_the_terms_of_the_paper() -> None:
    assert (len(THRUST_TERMS), len(TORQUE_TERMS)) == (39, 47)


def test_horner_is_the_sum_of_the_terms() -> None:
    one, j = Geometry(5, 1.0, 1.1, 0.75), 0.7
    for terms, ours in (
        (THRUST_TERMS, thrust_coefficient(j, one)),
        (TORQUE_TERMS, torque_coefficient(j, one)),
    ):
        plain = sum(c * j**s * 1.1**t * 0.75**u * 5.0**v for c, s, t, u, v in terms)
        assert float(ours) == pytest.approx(plain, rel=1e-12)


def test_known_points_of_the_series() -> None:
    """B3-71.8 and B3-80 as Fossen prints them; B4-70 of the regression's own check."""
    assert float(thrust_coefficient(0.0, Geometry(4, 1.0, 1.0, 0.70))) == pytest.approx(
        0.4547, abs=5e-5
    )
    assert float(torque_coefficient(0.0, Geometry(4, 1.0, 1.0, 0.70))) == pytest.approx(
        0.06754, abs=5e-6
    )
    remus = propeller("remus")
    assert [row.within_rounding for row in remus.printed] == [True, True, True, False, True]
    assert all(row.within_rounding or row.reason for row in remus.printed)


def test_the_correction_does_nothing_at_and_below_the_series_reynolds_number() -> None:
    one = Geometry(4, 1.0, 1.0, 0.7)
    for number in (1e5, 2e6):
        assert [float(d) for d in reynolds_correction(0.5, one, number)] == [0.0, 0.0]
    # less torque, a little more thrust, growing with the number
    small, large = (float(reynolds_correction(0.8, one, r)[1]) for r in (1e7, 1e9))
    assert large < small < 0


def test_pilgrims_table_3_within_3_percent_with_a_warning() -> None:
    found = propeller("pilgrim")
    for row in found.printed:
        assert row.difference / row.printed == pytest.approx(0.0, abs=0.03)
        assert row.within_rounding or row.reason
    assert found.candidate is not None
    assert found.candidate.thrust_n == pytest.approx(63.5, abs=0.05)
    assert found.candidate.torque_nm == pytest.approx(2.437, abs=5e-4)
    assert any("outside what was tested with 3 blades" in text for text in found.warnings)


def test_the_ranking_meets_the_task_and_is_in_order() -> None:
    found = propeller("remus")
    powers = [point.power_w for point in found.ranked]
    assert powers == sorted(powers)
    assert {point.blades for point in found.ranked} == {2, 3, 4, 5, 6, 7}
    for point in found.ranked:
        assert point.thrust_n >= found.thrust_n * (1 - 1e-5)
        assert point.torque_nm <= 178.0 / (2 * np.pi * 1525 / 60) * (1 + 1e-5)
        assert not point.cavitates
        assert point.diameter_m <= 0.14 * (1 + 1e-9)
    assert found.candidate is not None
    assert powers[1] < found.candidate.power_w  # three blades with less area


def test_no_other_propeller_of_a_fine_grid_needs_less_power() -> None:
    task = Task(INPUT, drive_limit(INPUT.drive))
    best = least_power(task, 3)
    assert best is not None
    d, p, a, n = (
        x.ravel()
        for x in np.meshgrid(
            np.linspace(0.10, 0.22, 25),
            np.linspace(0.5, 1.4, 25),
            np.linspace(0.35, 0.80, 7),
            np.linspace(10.0, 25.0, 61),
            indexing="ij",
        )
    )
    every = screw(task, Geometry(3, d, p, a), n)
    good = (
        (every.thrust_n >= 60.0)
        & (every.torque_nm <= task.drive.torque_nm(n))
        & (every.torque_coefficient > 1e-6)
    )
    assert float(best.power_w) <= float(every.power_w[good].min()) * (1 + 1e-6)
    assert float(best.power_w) > 0.97 * float(every.power_w[good].min())
    assert float(best.thrust_n) == pytest.approx(60.0, rel=1e-5)


def test_full_power_is_where_both_torques_meet() -> None:
    task = Task(INPUT, drive_limit(INPUT.drive))
    met = full_power(task, Geometry(3, 0.19, 1.1, 0.35))
    assert met is not None
    assert float(met.torque_nm) == pytest.approx(
        float(task.drive.torque_nm(met.shaft_speed_rps)), rel=1e-9
    )


def test_keller_and_burrill_by_hand() -> None:
    water = WaterInput(density_kgpm3=1000.0, shaft_depth_m=1.0)
    one = Geometry(3, 0.2, 1.0, 0.5)
    over = 101325 + 9810 - 1706
    assert float(keller_area_ratio(500.0, one, water, 0.1)) == pytest.approx(
        2.2 * 500 / over / 0.04 + 0.1
    )
    loading, limit = burrill(500.0, 3.0, 40.0, one, water)
    q = 500.0 * (9.0 + (0.7 * np.pi * 40 * 0.2) ** 2)
    assert float(loading) == pytest.approx(500 / (q * 0.5 * np.pi * 0.01 * (1.067 - 0.229)))
    assert float(limit) == pytest.approx(0.28 * (over / q - 0.03) ** 0.57)


def test_a_thrust_beyond_every_propeller_is_answered_with_the_most() -> None:
    asked = INPUT.model_copy(
        update={"required": INPUT.required.model_copy(update={"thrust_n": 500.0})}
    )
    assert isinstance(asked.drive, DriveCurve)
    with pytest.raises(CannotComputeError, match=r"The most is ") as error:
        design_propeller(asked, drive_limit(asked.drive), "the drive")
    most = float(str(error.value).split("The most is ")[1].split()[0])
    possible = INPUT.model_copy(
        update={"required": INPUT.required.model_copy(update={"thrust_n": 0.98 * most})}
    )
    assert design_propeller(possible, drive_limit(asked.drive), "the drive").ranked


def stated(name: str, **changes: object) -> PropellerInput:
    file = design_example("propeller", name)
    one = load_checked(file, PropellerInput, expected="", remedy="")
    return PropellerInput.model_validate(one.model_dump() | changes)


def calculate(one: PropellerInput) -> object:
    assert isinstance(one.drive, DrivePoint)
    return design_propeller(one, drive_limit(one.drive), "the drive")


def pinned(thrust_n: float) -> PropellerInput:
    """REMUS's propeller with nothing left to choose."""
    bounds = {
        "diameter_m": (0.14, 0.14),
        "pitch_ratio": (1.0, 1.0),
        "area_ratio": (0.718, 0.718),
        "blades": (3,),
    }
    required = {"thrust_n": thrust_n, "speed_mps": 2.5, "wake_fraction": 0.056}
    return stated("remus", bounds=bounds, required=required)


def test_a_propeller_with_nothing_free_is_looked_at_as_it_is() -> None:
    one = pinned(45.7)
    assert isinstance(one.drive, DrivePoint)
    task = Task(one, drive_limit(one.drive))
    only = screw(task, Geometry(3, 0.14, 1.0, 0.718), 1525.0 / 60.0)
    for found in (least_power(task, 3), most_thrust(task, [3])):
        assert found is not None
        assert float(found.thrust_n) == pytest.approx(float(only.thrust_n), rel=1e-12)
        assert float(found.power_w) == pytest.approx(float(only.power_w), rel=1e-12)
    with pytest.raises(CannotComputeError, match=r"The most is 45.77 N"):
        calculate(pinned(500.0))


def test_a_pinned_propeller_beyond_the_drive_is_not_said_to_give_no_thrust() -> None:
    weak = {"kind": "point", "power_w": 20.0, "shaft_speed_rpm": 1525.0}
    one = PropellerInput.model_validate(pinned(45.7).model_dump() | {"drive": weak})
    with pytest.raises(CannotComputeError, match=r"none there keeps to the drive's torque"):
        calculate(one)


def test_a_candidate_that_the_water_drives_is_refused() -> None:
    candidate = stated("pilgrim").candidate
    assert candidate is not None
    slow = candidate.model_dump() | {"shaft_speed_rpm": 100.0}
    with pytest.raises(CannotComputeError, match=r"at 100 rpm its advance ratio is 9.73"):
        calculate(stated("pilgrim", candidate=slow))


def test_no_propeller_is_found_far_beyond_windmilling() -> None:
    """There both polynomials are positive again and promise thrust for no torque."""
    drive = {"kind": "point", "power_w": 2000.0, "shaft_speed_rpm": 100.0}
    one = stated("pilgrim", candidate=None, drive=drive, enforce_cavitation=False)
    with pytest.raises(CannotComputeError, match=r"No propeller of the series"):
        calculate(one)
