"""Balance of Kostenko 2017: printed tables, exact form, limits, what cannot be."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled
from design_cases import pilgrim_balance
from hypothesis import given
from hypothesis import strategies as st

from pipeline.bundled.design import design_example
from pipeline.design.balance import (
    Balance,
    Condition,
    control_forces,
    exact_balance,
    moment_left_nm,
    slopes,
    small_angle_balance,
)
from pipeline.design.balance_design import design_balance
from pipeline.design.balance_hull import BodyHull, PolarHull
from pipeline.design.balance_input import BalanceHullInput, BalanceInput, LimitInput
from pipeline.design.balance_limits import StatedLimits
from pipeline.errors import CannotComputeError
from pipeline.report.sections.design_balance import use_figure
from pipeline.vehicle.load import load_checked

LAW = BalanceHullInput(
    at_speed_mps=3.0, drag_n=148.0, lift_n_per_rad=1375.0, righting_nm_per_rad=731.0
)
PILGRIM = PolarHull(LAW, 0.70)
POINT = Condition(3.0, 60.0, 22.5, 2.0, 2.0)


def read(name: str, **changes: object) -> BalanceInput:
    file = design_example("balance", name)
    one = load_checked(file, BalanceInput, expected="", remedy="")
    return BalanceInput.model_validate(one.model_dump() | changes)


def residuals(hull: PolarHull, at: Condition, found: Balance) -> list[float]:
    """Left sides of (1), level and steady, written out here a second time."""
    scale = (at.speed_mps / 3.0) ** 2
    a, delta = found.alpha_rad, np.radians(at.angle_deg)
    left, right, upper, lower = found.loads_n
    t_x = (left + right + upper + lower) * np.cos(delta)
    t_y = (upper - lower) * np.sin(delta)
    return [
        -scale * 148.0 + t_x * np.cos(a) - t_y * np.sin(a),
        scale * 1375.0 * a + at.residual_buoyancy_n + t_y * np.cos(a) + t_x * np.sin(a),
        -hull.metacentric_nm_per_rad * np.sin(a) - scale * 731.0 * a - t_y * at.pitch_arm_m,
    ]


@given(st.floats(0.8, 6.0), st.floats(-75.0, 75.0), st.floats(8.0, 60.0), st.floats(1.2, 4.0))
def test_the_exact_form_satisfies_the_equations_of_motion(
    speed: float, buoyancy: float, angle: float, arm: float
) -> None:
    at = Condition(speed, buoyancy, angle, arm, arm)
    try:
        found = exact_balance(PILGRIM, at)
    except CannotComputeError:
        # only where the hull cannot carry it: 1157 N/rad at 3 m/s, up to 30 deg
        assert abs(buoyancy) > 0.3 * (speed / 3.0) ** 2 * (1523.0 - 732.0 / arm)
        return
    np.testing.assert_allclose(residuals(PILGRIM, at, found), 0.0, atol=1e-8)


def test_no_buoyancy_needs_no_angle_and_loads_all_alike() -> None:
    found = exact_balance(PILGRIM, Condition(3.0, 0.0, 22.5, 2.0, 2.0))
    assert found.alpha_rad == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(found.loads_n, 148.0 / 4 / np.cos(np.radians(22.5)))


def test_small_buoyancy_is_where_both_forms_meet() -> None:
    at = Condition(3.0, 0.1, 22.5, 2.0, 2.0)
    exact, small = exact_balance(PILGRIM, at), small_angle_balance(slopes(PILGRIM, at), at)
    assert exact.alpha_rad == pytest.approx(small.alpha_rad, rel=1e-5)
    assert exact.vertical_n == pytest.approx(small.vertical_n, rel=1e-5)


def test_the_slopes_are_those_that_were_put_in() -> None:
    found = slopes(PILGRIM, POINT)
    assert (found.drag_n, found.lift_n_per_rad) == pytest.approx((148.0, 1375.0))
    assert found.righting_nm_per_rad == pytest.approx(731.0)
    assert found.metacentric_nm_per_rad == pytest.approx(0.70, rel=1e-6)


def test_the_printed_sign_of_the_righting_moment_would_upset_the_vehicle() -> None:
    """With +M_o, as (1) prints, a heavy-bottomed vehicle at rest would turn over."""
    heavy = PolarHull(LAW, 50.0)
    assert float(heavy.restoring_nm(0.0, 0.1)) < 0 < float(heavy.restoring_nm(0.0, -0.1))


def test_a_vehicle_that_cannot_be_carried_is_told_what_can() -> None:
    with pytest.raises(CannotComputeError, match=r"60 N cannot be carried at 0.5 m/s") as error:
        exact_balance(PILGRIM, Condition(0.5, 60.0, 22.5, 2.0, 2.0))
    most = float(str(error.value).split("at most ")[1].split()[0])
    exact_balance(PILGRIM, Condition(0.5, 0.99 * most, 22.5, 2.0, 2.0))
    with pytest.raises(CannotComputeError):
        exact_balance(PILGRIM, Condition(0.5, 1.02 * most, 22.5, 2.0, 2.0))


def test_a_vehicle_out_of_trim_is_told_the_moment_and_no_buoyancy(repository: Path) -> None:
    """Its weight acts 0.1 m ahead of its buoyancy: at a crawl no hull force holds that."""
    vehicle = bundled(repository, "mmt300")
    assert vehicle.model is not None
    hull, _ = BodyHull.of_model(vehicle.model, 9.81, 1000.0)
    x, z = hull.centre_of_mass_m
    heavy = replace(hull, centre_of_mass_m=(x + 0.1, z))
    moment = -0.1 * hull.weight_n
    with pytest.raises(CannotComputeError, match="and neither can none") as error:
        exact_balance(heavy, Condition(0.3, 5.0, 22.5, 1.0, 1.0))
    assert f"a moment of {moment:.3g} N m, nose up" in str(error.value)


def test_a_short_arm_is_refused_by_the_small_angle_form() -> None:
    at = Condition(3.0, 60.0, 22.5, 0.4, 0.4)
    with pytest.raises(CannotComputeError, match=r"An arm above 0.48"):
        small_angle_balance(slopes(PILGRIM, at), at)


@pytest.mark.parametrize("lift_n_per_rad", [-148.0, -2000.0])
def test_a_hull_that_does_not_lift_has_no_small_angle_form_at_any_arm(
    lift_n_per_rad: float,
) -> None:
    linear = replace(slopes(PILGRIM, POINT), lift_n_per_rad=lift_n_per_rad)
    with pytest.raises(CannotComputeError, match="Check the sign of the lift") as error:
        small_angle_balance(linear, POINT)
    assert "arm" not in str(error.value)


def test_a_speed_whose_square_is_no_number_is_refused() -> None:
    with pytest.raises(ValueError, match="at_speed_mps"):
        BalanceHullInput.model_validate(LAW.model_dump() | {"at_speed_mps": 1e-200})


@pytest.mark.parametrize(
    ("limit_n", "speeds", "expected"),
    [
        (60.0, (1.0, 3.5), "Beyond the dotted line"),
        (500.0, (1.0, 3.5), "No thruster comes to its limit anywhere"),
        (5.0, (3.0, 3.5), "beyond its limit everywhere"),
        (60.0, (0.01, 0.02), "Nowhere in the envelope"),
    ],
)
def test_the_map_of_use_says_what_is_on_it(
    limit_n: float, speeds: tuple[float, float], expected: str
) -> None:
    """Its title names the limit only where it is passed."""
    envelope = {
        "speed_mps": {"first": speeds[0], "last": speeds[1], "points": 2},
        "residual_buoyancy_n": {"first": 60.0, "last": 75.0, "points": 2},
        "angle_deg": {"first": 20.0, "last": 30.0, "points": 2},
    }
    found = design_balance(read("pilgrim", limit={"thrust_max_n": limit_n}, envelope=envelope))
    assert expected in use_figure(found).lead


def test_the_body_hull_is_the_polar_one_at_small_angles() -> None:
    body = BodyHull(
        linear=(0.0, 0.0),
        quadratic=(148.0 / 9, 0.0),
        lift=1375.0 / 9,
        moment=-731.0 / 9,
        munk=(0.0, 0.0, 0.0),
        weight_n=1000.0,
        centre_of_mass_m=(0.0, 0.0007),
        centre_of_buoyancy_m=(0.0, 0.0),
    )
    alpha = 1e-4
    # in flow axes the drag of the body leans up with the nose: (K_y + R_0) less R_0
    ours, paper = body.forces(3.0, alpha), PILGRIM.forces(3.0, alpha)
    assert float(ours[0]) == pytest.approx(float(paper[0]), rel=1e-4)
    assert float(ours[1]) == pytest.approx(float(paper[1]) - 148.0 * alpha, rel=1e-4)
    assert float(ours[2]) == pytest.approx(float(paper[2]), rel=1e-4)
    assert float(body.restoring_nm(0.0, alpha)) == pytest.approx(-0.7 * alpha, rel=1e-6)


def test_power_limits_the_thrust_by_eq_10() -> None:
    limits = StatedLimits(LimitInput(propeller_efficiency=0.75, power_max_w=263.0))
    assert limits.limit_n(3.0) == pytest.approx(65.75)
    assert limits.use(64.3, 0.0, 3.0) == pytest.approx(64.3 * 3 / 0.75 / 263.0)
    assert StatedLimits(LimitInput()).use(1e9, 0.0, 3.0) is None


def test_pilgrims_table_2_is_reproduced() -> None:
    """To the digit where the paper agrees with itself, with a reason where it does not."""
    found = pilgrim_balance()
    by = {row.quantity: row for row in found.printed}
    for quantity in ("angle_of_attack_deg", "vertical_force_n", "angle_of_attack_deg_exact"):
        assert by[quantity].within_rounding
    for thruster in ("left", "right", "upper", "lower"):
        assert by[f"{thruster}_n_from_printed"].within_rounding
    assert by["power_w_from_printed"].within_rounding
    assert all(row.within_rounding or len(row.reason) > 5 for row in found.printed)


def test_the_three_readings_of_the_surge_force() -> None:
    readings = {row.reading: row.surge_force_n for row in pilgrim_balance().readings}
    assert readings["(8) as printed"] == pytest.approx(149.0, abs=0.05)
    assert readings["first line of (6)"] == pytest.approx(147.0, abs=0.05)
    assert readings["T_x and T_y as printed"] == 146.0
    assert readings["exact form of (1)"] == pytest.approx(147.2, abs=0.05)


def test_saturation_is_where_the_most_loaded_thruster_takes_all_its_power() -> None:
    found = pilgrim_balance()
    speed, lighter, heavier = found.saturation
    assert (speed.thruster, lighter.thruster, heavier.thruster) == ("upper", "upper", "lower")
    assert speed.value is not None
    at = Condition(speed.value, 60.0, 22.5, 2.0, 2.0)
    assert exact_balance(PILGRIM, at).loads_n[2] * speed.value / 0.75 == pytest.approx(263.0)
    assert lighter.value is not None
    assert heavier.value is not None
    assert lighter.value == pytest.approx(-heavier.value, rel=1e-6)


def test_the_envelope_holds_the_design_point_itself() -> None:
    found = pilgrim_balance()
    envelope = found.envelope
    i = envelope.speed_mps.index(3.0)
    j = envelope.residual_buoyancy_n.index(60.0)
    k = envelope.angle_deg.index(22.5)
    most = max(found.exact.loads, key=lambda load: load.thrust_n)
    assert envelope.largest_load_n[i][j][k] == pytest.approx(most.thrust_n)
    assert envelope.most_loaded[i][j][k] == "upper"
    assert envelope.angle_of_attack_deg[i][j][k] == pytest.approx(found.exact.angle_of_attack_deg)


def test_forces_are_zero_sum_in_the_moment_at_the_solution() -> None:
    found = exact_balance(PILGRIM, POINT)
    assert float(moment_left_nm(PILGRIM, POINT, found.alpha_rad)) == pytest.approx(0.0, abs=1e-8)
    surge, vertical = control_forces(PILGRIM, POINT, found.alpha_rad)
    assert (float(surge), float(vertical)) == (found.surge_n, found.vertical_n)


def test_a_state_that_the_small_angle_form_lacks_is_shown_exactly() -> None:
    slow = {"metacentric_nm_per_rad": 300.0, "speed_mps": 0.6, "residual_buoyancy_n": 5.0}
    found = design_balance(read("pilgrim", **slow))
    assert found.small_angle is None
    assert found.exact.angle_of_attack_deg == pytest.approx(2.76, abs=0.005)
    text = next(text for text in found.warnings if "small-angle" in text)
    assert "left out" in text
    assert "An arm above 5.4 m is needed" in text
    most = max(abs(load.thrust_n) for load in found.exact.loads)
    assert found.preliminary_power_w == pytest.approx(most * 0.6 / 0.75)
    assert [row.reading for row in found.readings] == [
        "T_x and T_y as printed",
        "exact form of (1)",
    ]


def test_a_moment_that_eq_7_lacks_is_named_where_it_parts_the_forms(repository: Path) -> None:
    vehicle = bundled(repository, "mmt300")
    assert vehicle.model is not None
    body = vehicle.model.rigid_body.model_copy(update={"centre_of_buoyancy_m": (0.02, 0.0, 0.0)})
    model = vehicle.model.model_copy(update={"rigid_body": body})
    ahead = vehicle.model_copy(update={"model": model})
    one = read("mmt300", residual_buoyancy_n=1.0)
    warned = next(t for t in design_balance(one, ahead).warnings if "small-angle" in t)
    assert "(7) lacks the moment of" in warned
    ten = read("mmt300", residual_buoyancy_n=10.0)
    warned = next(t for t in design_balance(ten, vehicle).warnings if "small-angle" in t)
    assert "far from linear" in warned


@pytest.mark.parametrize(
    ("first", "last", "expected"),
    [
        (-80.0, -10.0, ["residual buoyancy, heavier"]),
        (10.0, 60.0, ["residual buoyancy, lighter"]),
    ],
)
def test_an_envelope_of_one_sign_has_no_saturation_of_the_other(
    first: float, last: float, expected: list[str]
) -> None:
    envelope = read("pilgrim").envelope.model_dump()
    envelope["residual_buoyancy_n"] = {"first": first, "last": last, "points": 2}
    found = design_balance(read("pilgrim", envelope=envelope))
    assert [one.quantity for one in found.saturation] == ["speed", *expected]


def test_the_end_of_what_can_be_balanced_is_no_saturation() -> None:
    """With 5 kW a shaft Pilgrim is carried up to 584 N, its thrusters far below their limit."""
    strong = {"propeller_efficiency": 0.75, "power_max_w": 5000.0}
    envelope = read("pilgrim").envelope.model_dump()
    envelope["residual_buoyancy_n"] = {"first": -900.0, "last": 900.0, "points": 2}
    _, lighter, heavier = design_balance(
        read("pilgrim", limit=strong, envelope=envelope)
    ).saturation
    for one, size in ((lighter, 584), (heavier, -584)):
        assert (one.value, one.thruster) == (None, "")
        assert f"comes to its limit up to {size} N; beyond, no angle of attack balances" in one.text
    envelope["residual_buoyancy_n"] = {"first": 700.0, "last": 900.0, "points": 2}
    _, lighter = design_balance(read("pilgrim", limit=strong, envelope=envelope)).saturation
    assert "no angle of attack balances from 700 to 900 N" in lighter.text


def test_a_thruster_that_saturates_before_the_balance_ends_is_named() -> None:
    strong = {"propeller_efficiency": 0.75, "power_max_w": 1000.0}
    envelope = read("pilgrim").envelope.model_dump()
    envelope["residual_buoyancy_n"] = {"first": -50.0, "last": 5000.0, "points": 2}
    found = design_balance(read("pilgrim", limit=strong, envelope=envelope))
    lighter = found.saturation[1]
    assert lighter.thruster == "upper"
    assert lighter.value is not None
    at = Condition(3.0, lighter.value, 22.5, 2.0, 2.0)
    assert exact_balance(PILGRIM, at).loads_n[2] * 3.0 / 0.75 == pytest.approx(1000.0, rel=1e-3)
