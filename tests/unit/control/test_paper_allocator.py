"""Eq. (6) behind the autopilot: heave and pitch are divided between bow and stern."""

from dataclasses import dataclass

import numpy as np
import pytest
from eq5 import stern_matrix

from pipeline.control.allocation import ThrustLimits
from pipeline.control.paper_allocator import PaperAllocator, rest_inverse
from pipeline.records.fits import InverseCharacteristic
from pipeline.types import ArrayLike, FloatArray
from pipeline.vehicle.schema import Allocator, Vehicle

NAMES = ("bow", "right", "left", "spare", "lower", "upper")


@dataclass(frozen=True)
class OneNewtonACode:
    """Thrust and code are one number, up to 40 N, 20 N fewer at 2 m/s."""

    name: str = "one newton a code"

    def limits(self, speed_mps: float) -> ThrustLimits:
        largest = 40.0 - 10.0 * abs(speed_mps)
        return ThrustLimits(largest, largest)

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        return np.broadcast_arrays(np.asarray(thrust_n, float), speed_mps)[0] * 1.0


def geometry(**changes: object) -> Allocator:
    return Allocator.model_validate(
        {
            "delta_deg": 30.0,
            "stern_arm_m": 1.0,
            "bow_arm_m": 0.6,
            "upper": "upper",
            "lower": "lower",
            "left": "left",
            "right": "right",
            "bow": "bow",
            "portions": {"surge": 0.5, "heading": 0.5, "pitch": 0.5},
            **changes,
        }
    )


def wrench_of(codes: FloatArray, allocator: Allocator) -> FloatArray:
    by_name = dict(zip(NAMES, codes.tolist(), strict=True))
    thrust = [by_name[name] for name in ("upper", "lower", "left", "right", "bow")]
    return np.asarray(stern_matrix(allocator) @ thrust)


@pytest.mark.parametrize(
    "demand",
    [(30, 0, 0, 0, 0, 0), (0, 0, 8, 0, 0, 0), (0, 0, 0, 0, 5, 0), (20, 0, -6, 0, 3, 0)],
)
def test_surge_heave_and_pitch_are_met_together(demand: tuple[float, ...]) -> None:
    """Within the rounding of five whole newtons."""
    allocator = geometry()
    one = PaperAllocator(allocator, OneNewtonACode(), NAMES)
    codes, _, cut = one.decide(np.array(demand, float), np.zeros(6))
    assert not cut
    assert codes[NAMES.index("spare")] == 0.0
    # rounding: 2 newtons of the four stern thrusters, half of one of the bow
    assert wrench_of(codes, allocator)[[0, 2, 4]] == pytest.approx(
        np.array(demand, float)[[0, 2, 4]], abs=1.2
    )


def test_yaw_takes_the_sides_and_sway_comes_with_it() -> None:
    allocator = geometry()
    one = PaperAllocator(allocator, OneNewtonACode(), NAMES)
    codes, _, _ = one.decide(np.array([0, 0, 0, 0, 0, 10.0]), np.zeros(6))
    got = wrench_of(codes, allocator)
    assert got[5] == pytest.approx(10.0)
    assert got[1] == pytest.approx(-10.0)
    assert got[[0, 2, 4]] == pytest.approx(np.zeros(3), abs=1e-12)


def test_says_when_a_limit_cut_it() -> None:
    one = PaperAllocator(geometry(), OneNewtonACode(), NAMES)
    surge = np.array([60.0, 0, 0, 0, 0, 0])
    assert not one.decide(surge, np.zeros(6))[2]
    assert one.decide(surge, np.array([2.0, 0, 0, 0, 0, 0]))[2]
    assert one.decide(np.array([0, 0, 200.0, 0, 0, 0]), np.zeros(6))[2]


def test_a_bow_thruster_without_a_stated_arm_lifts_and_makes_no_moment() -> None:
    allocator = geometry(bow_arm_m=None)
    one = PaperAllocator(allocator, OneNewtonACode(), NAMES)
    codes, _, cut = one.decide(np.array([0, 0, -20.0, 0, 4.0, 0]), np.zeros(6))
    assert not cut
    assert wrench_of(codes, allocator)[[2, 4]] == pytest.approx([-20.0, 4.0])
    assert codes[NAMES.index("bow")] == pytest.approx(24.0)
    assert one.decide(np.array([0, 0, -60.0, 0, 0, 0]), np.zeros(6))[2]


def test_without_a_bow_thruster_heave_is_left_out() -> None:
    allocator = geometry(bow=None, bow_arm_m=None)
    one = PaperAllocator(allocator, OneNewtonACode(), NAMES)
    codes, _, _ = one.decide(np.array([0, 0, 20.0, 0, 4.0, 0]), np.zeros(6))
    assert wrench_of(codes, allocator)[4] == pytest.approx(4.0)
    assert codes[NAMES.index("bow")] == 0.0


def test_the_inverse_at_rest_is_table_3_or_the_grids_row_at_rest(
    paper_inverse: InverseCharacteristic, mmt300: Vehicle
) -> None:
    """20 N: 12.7 + 86.72 - 28 + 5.832 of eq. (7), whatever the speed."""
    moored = rest_inverse(paper_inverse, mmt300)
    np.testing.assert_allclose(moored.code([20.0, 20.0], [0.0, 2.0]), 77.252, atol=1e-9)
    none = paper_inverse.model_copy(update={"table3_negative": None, "table3_positive": None})
    grid = rest_inverse(none, mmt300)
    rest, under_way = grid.code([20.0, 20.0], [0.0, 2.0])
    assert rest == under_way == pytest.approx(77.0, abs=5.0)
