import numpy as np
import pytest
from eq5 import asked_wrench
from hypothesis import given
from hypothesis import strategies as st

from pipeline.control.allocation import (
    Demand,
    ThrustLimits,
    demanded_channels,
    limited_channels,
    within_reach,
)
from pipeline.vehicle.schema import Allocator

LIMITS = ThrustLimits(42.0, 42.0)
DELTA = np.radians(22.5)
PER_MOMENT = 2.0 * 1.2 * np.sin(DELTA)

force = st.floats(-400.0, 400.0)
moment = st.floats(-120.0, 120.0)


@pytest.fixture(scope="module")
def geometry() -> Allocator:
    return Allocator.model_validate(
        {
            "delta_deg": 22.5,
            "stern_arm_m": 1.2,
            **{name: name for name in ("upper", "lower", "left", "right")},
            "portions": {"surge": 0.6, "heading": 0.4, "pitch": 0.3},
        }
    )


def formed(allocator: Allocator, form: str) -> Allocator:
    return allocator.model_copy(update={"form": form})


def test_hand_worked_channels(allocator: Allocator) -> None:
    """X = 40 N, M = 5 N m (nose up), N = 3 N m (to starboard)."""
    stern = demanded_channels(Demand(40.0, 5.0, 3.0), allocator).stern_thrust_n()
    surge, pitch, heading = 40.0 / (4 * 0.92388), 5.0 / 0.918440, -3.0 / 0.918440
    expected = [surge - pitch, surge + pitch, surge - heading, surge + heading]
    np.testing.assert_allclose(stern, expected, rtol=1e-5)


@given(force, moment, moment)
def test_unlimited_demand_is_what_is_asked(
    geometry: Allocator, surge: float, pitch: float, yaw: float
) -> None:
    """Eq. (6) without limits is the exact inverse of eq. (5), with no coupling between channels."""
    channels = demanded_channels(Demand(surge, pitch, yaw), geometry)
    x, _, _, k, m, n = asked_wrench(channels, geometry)
    np.testing.assert_allclose([x, m, n], [surge, pitch, yaw], atol=1e-9)
    assert k == 0.0


@given(force)
def test_pure_surge_gives_no_moment_and_no_side_force(geometry: Allocator, surge: float) -> None:
    channels = limited_channels(demanded_channels(Demand(surge), geometry), LIMITS, geometry)
    np.testing.assert_allclose(asked_wrench(channels, geometry)[1:], 0.0, atol=1e-9)


@given(force, moment, moment)
def test_no_thruster_saturates_however_large_the_demand(
    geometry: Allocator, surge: float, pitch: float, yaw: float
) -> None:
    for form in ("limit", "scaled"):
        channels = limited_channels(
            demanded_channels(Demand(surge, pitch, yaw), geometry), LIMITS, formed(geometry, form)
        )
        assert np.abs(channels.stern_thrust_n()).max() <= 42.0 + 1e-9


def test_limit_form_realises_what_is_within_reach(allocator: Allocator) -> None:
    demanded = demanded_channels(Demand(90.0, 10.0, -14.0), allocator)
    assert within_reach(demanded, LIMITS, allocator)
    asked = asked_wrench(limited_channels(demanded, LIMITS, allocator), allocator)
    np.testing.assert_allclose(asked[[0, 4, 5]], [90.0, 10.0, -14.0])


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_scaled_form_gives_exactly_the_portion(
    geometry: Allocator, x: float, m: float, n: float
) -> None:
    """As printed, a demand that saturates nothing still loses the factor 1 - Pi."""
    portions = geometry.portions
    demand = Demand(
        x * portions.surge * 42 * 4 * np.cos(DELTA),
        m * portions.pitch * 42 * PER_MOMENT,
        n * portions.heading * 42 * PER_MOMENT,
    )
    demanded = demanded_channels(demand, geometry)
    limit, scaled = (
        asked_wrench(limited_channels(demanded, LIMITS, formed(geometry, form)), geometry)
        for form in ("limit", "scaled")
    )
    np.testing.assert_allclose(scaled[0], portions.surge * limit[0], atol=1e-9)
    np.testing.assert_allclose(scaled[4], portions.pitch * limit[4], atol=1e-9)
    np.testing.assert_allclose(scaled[5], portions.heading * limit[5], atol=1e-9)


def test_both_forms_meet_at_saturation(allocator: Allocator) -> None:
    demanded = demanded_channels(Demand(1e4, -1e4, 1e4), allocator)
    limit, scaled = (
        asked_wrench(limited_channels(demanded, LIMITS, formed(allocator, form)), allocator)
        for form in ("limit", "scaled")
    )
    np.testing.assert_allclose(limit, scaled)
    assert limit[0] == pytest.approx(4 * np.cos(DELTA) * 0.6 * 42)
    assert limit[4] == pytest.approx(-PER_MOMENT * 0.3 * 42)
    assert limit[5] == pytest.approx(PER_MOMENT * 0.4 * 42)


def test_scaled_form_saturates_at_t_max_as_printed(allocator: Allocator) -> None:
    """Just below T_max nothing is cut in the printed form: the demand is only multiplied."""
    below = Demand(0.99 * 42 * 4 * np.cos(DELTA))
    demanded = demanded_channels(below, allocator)
    assert within_reach(demanded, LIMITS, formed(allocator, "scaled"))
    assert not within_reach(demanded, LIMITS, formed(allocator, "limit"))
    scaled = limited_channels(demanded, LIMITS, formed(allocator, "scaled"))
    assert scaled.surge_n == pytest.approx(0.99 * 42 * 0.6)


def test_unequal_signs(allocator: Allocator) -> None:
    """Surge has a limit for each sign, turning takes the smaller one."""
    limits = ThrustLimits(50.0, 40.0)
    large = Demand(np.array([1e4, -1e4]), 0.0, np.array([1e4, -1e4]))
    channels = limited_channels(demanded_channels(large, allocator), limits, allocator)
    np.testing.assert_allclose(channels.surge_n, [30.0, -24.0])
    np.testing.assert_allclose(channels.heading_n, [-16.0, 16.0])
    stern = channels.stern_thrust_n()
    assert stern.max() <= 50.0
    assert stern.min() >= -40.0
