"""The autopilot: its law by hand, and the loops that it closes."""

import numpy as np
import pytest

from pipeline.control.autopilot import Autopilot, Design, MeasuredState, Setpoint, wrapped

DESIGN = Design(
    surge_mass_kg=100.0,
    heave_mass_kg=200.0,
    pitch_inertia_kgm2=40.0,
    yaw_inertia_kgm2=50.0,
    surge_linear=2.0,
    surge_quadratic=20.0,
    roll_inertia_kgm2=5.0,
)
STILL = MeasuredState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def moving(**values: float) -> MeasuredState:
    return MeasuredState(**{**STILL.__dict__, **values})


def demand(motion: MeasuredState, reference: Setpoint, design: Design = DESIGN) -> np.ndarray:
    """Without the integrals, which have had no time."""
    return Autopilot(design).step(motion, reference, 0.0)[0]


def test_nothing_asked_nothing_given() -> None:
    assert demand(moving(surge_mps=1.0, depth_m=3.0), Setpoint()).tolist() == [0.0] * 6


def test_each_law_by_hand() -> None:
    """m (w^2 e + 2 zeta w e') on each axis; surge with the drag at the wanted speed."""
    assert demand(STILL, Setpoint(surge_mps=1.0))[0] == pytest.approx(100 * 0.6 + 22.0)
    deep = demand(moving(depth_rate_mps=0.1), Setpoint(depth_m=2.0))
    assert deep[2] == pytest.approx(200 * (0.16 * 2.0 - 2 * 0.9 * 0.4 * 0.1))
    nose = demand(moving(pitch_rad=0.1), Setpoint(pitch_rad=0.0))
    assert nose[4] == pytest.approx(-40 * 0.1)
    turn = demand(moving(yaw_rate_radps=0.2), Setpoint(heading_rad=0.1))
    assert turn[5] == pytest.approx(50 * (0.64 * 0.1 - 2 * 0.9 * 0.8 * 0.2))
    roll = demand(moving(roll_rad=0.1), Setpoint(roll_rad=0.0))
    assert roll[3] == pytest.approx(-5.0 * 1.5**2 * 0.1)


def test_heading_takes_the_short_way() -> None:
    north_west = demand(moving(heading_rad=np.radians(170.0)), Setpoint(heading_rad=-np.pi + 0.1))
    assert north_west[5] > 0.0


def test_stiffness_grows_with_what_the_hull_upsets() -> None:
    """w^2 I becomes w^2 I + 2 c u^2."""
    design = Design(100.0, 200.0, 40.0, 50.0, 2.0, 20.0, pitch_upset_kg=30.0, yaw_upset_kg=60.0)
    under_way = moving(surge_mps=2.0, pitch_rad=0.1)
    got = demand(under_way, Setpoint(pitch_rad=0.0, heading_rad=0.1), design)
    assert got[4] == pytest.approx(-(40.0 + 2 * 30 * 4) * 0.1)
    assert got[5] == pytest.approx((50 * 0.64 + 2 * 60 * 4) * 0.1)


def test_integrals_wait_while_the_demand_is_out_of_reach() -> None:
    pilot = Autopilot(DESIGN)
    reference = Setpoint(surge_mps=1.0, depth_m=1.0, heading_rad=0.5, pitch_rad=0.2)
    _, waiting = pilot.step(STILL, reference, 0.1, saturated=True)
    _, growing = pilot.step(STILL, reference, 0.1)
    assert waiting.integral == (0.0, 0.0, 0.0, 0.0)
    assert all(value > 0.0 for value in growing.integral)
    assert pilot.integral == (0.0, 0.0, 0.0, 0.0)


def test_a_step_does_not_wind_the_integral_up() -> None:
    pilot = Autopilot(DESIGN)
    _, small = pilot.step(STILL, Setpoint(heading_rad=0.1), 0.1)
    _, large = pilot.step(STILL, Setpoint(heading_rad=2.0), 0.1)
    assert large.integral == pytest.approx(small.integral)


@pytest.mark.parametrize("push_n", [0.0, 60.0])
def test_depth_loop_settles_and_its_integral_takes_a_steady_push(push_n: float) -> None:
    """A point mass in heave: no static error is left; the overshoot stays small."""
    pilot, depth, rate, reached = Autopilot(DESIGN), 0.0, 0.0, []
    for _ in range(3000):
        force, pilot = pilot.step(
            moving(depth_m=depth, depth_rate_mps=rate), Setpoint(depth_m=1.0), 0.05
        )
        rate += 0.05 * (force[2] + push_n) / 200.0
        depth += 0.05 * rate
        reached.append(depth)
    assert depth == pytest.approx(1.0, abs=1e-3)
    assert pilot.integral[1] == pytest.approx(-push_n, abs=0.5)
    if push_n == 0.0:
        assert max(reached) < 1.25


@pytest.mark.parametrize(
    ("angle", "expected"), [(3.0, 3.0), (4.0, 4.0 - 2 * np.pi), (-4.0, 2 * np.pi - 4.0)]
)
def test_wrapped(angle: float, expected: float) -> None:
    assert wrapped(angle) == pytest.approx(expected)
