"""The cable at rest: both closed forms, equilibrium, a mooring library, and refusals."""

import math
import warnings
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import CannotComputeError
from pipeline.physics.catenary import catenary_parameter, uniform_load_cable
from pipeline.physics.tether_cable import Cable, TetherSolution, tether_load
from pipeline.physics.tether_static import solve_tether

RHO = 1025.0
ENDS = [
    np.array([50.0, 0.0, 0.0]),
    np.array([30.0, 10.0, 40.0]),
    np.array([1.0, 0.0, -50.0]),
    np.array([-20.0, 35.0, 5.0]),
]
RATIOS = [1.0001, 1.01, 1.5, 5.0, 20.0]


def neutral_cable_in_flow(
    arc_length_m: np.ndarray,
    *,
    velocity_mps: np.ndarray,
    normal_load: float,
    **ends: Any,  # noqa: ANN401 - lengths and places
) -> tuple[np.ndarray, np.ndarray]:
    """Shape and tension with normal drag only: the catenary's shape, a tension of one size."""
    speed = np.linalg.norm(velocity_mps)
    down = velocity_mps / speed
    places, heavy = uniform_load_cable(arc_length_m, load_npm=down, **ends)
    c = np.linalg.norm(heavy - np.outer(heavy @ down, down), axis=1, keepdims=True)
    tangent = heavy / np.linalg.norm(heavy, axis=1, keepdims=True)
    return places, normal_load * speed**2 * c * tangent


def solve(cable: Cable, end: np.ndarray, flow: object = (0.0, 0.0, 0.0)) -> TetherSolution:
    field = flow if callable(flow) else np.array(flow, float)
    return solve_tether(cable, start_m=np.zeros(3), end_m=end, flow=field, density_kgpm3=RHO)


def errors(got: TetherSolution, places: np.ndarray, tension: np.ndarray) -> tuple[float, float]:
    """Return the largest error of the tension, over its largest, and of the places, over length."""
    return (
        float(np.abs(got.tension_n - tension).max() / np.abs(tension).max()),
        float(np.abs(got.position_m - places).max() / got.arc_length_m[-1]),
    )


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("ratio", RATIOS)
def test_heavy_cable_in_still_water_is_the_catenary(end: np.ndarray, ratio: float) -> None:
    cable = Cable(float(np.linalg.norm(end)) * ratio, 0.014, 1.8, 0.025, wet_weight_npm=1.3)
    got = solve(cable, end)
    exact = uniform_load_cable(
        got.arc_length_m, length_m=cable.length_m, start_m=np.zeros(3), end_m=end,
        load_npm=np.array([0.0, 0.0, 1.3]),
    )  # fmt: skip
    assert max(errors(got, *exact)) < 1e-4


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("ratio", RATIOS)
def test_neutral_cable_with_normal_drag_is_the_drag_catenary(end: np.ndarray, ratio: float) -> None:
    cable = Cable(float(np.linalg.norm(end)) * ratio, 0.014, 1.8, 0.0)
    flow = np.array([0.2, 0.3, -0.6])
    got = solve(cable, end, flow)
    exact = neutral_cable_in_flow(
        got.arc_length_m, length_m=cable.length_m, start_m=np.zeros(3), end_m=end,
        velocity_mps=flow, normal_load=0.5 * RHO * 0.014 * 1.8,
    )  # fmt: skip
    assert max(errors(got, *exact)) < 1e-4
    size = got.tension_size_n
    assert np.ptp(size) < 1e-4 * size.max()  # nothing pulls along the cable


def test_the_two_closed_forms_have_one_shape_and_other_tensions() -> None:
    s = np.linspace(0.0, 100.0, 7)
    ends = {"length_m": 100.0, "start_m": np.zeros(3), "end_m": np.array([60.0, 0.0, 20.0])}
    down = np.array([0.0, 0.0, 2.0])
    heavy = uniform_load_cable(s, load_npm=down, **ends)
    neutral = neutral_cable_in_flow(s, velocity_mps=down, normal_load=1.0, **ends)
    assert heavy[0] == pytest.approx(neutral[0], abs=1e-9)
    assert np.ptp(np.linalg.norm(neutral[1], axis=1)) < 1e-9
    assert np.ptp(heavy[1][:, 0]) < 1e-9
    assert np.ptp(np.linalg.norm(heavy[1], axis=1)) > 10.0


def test_catenary_parameter_keeps_its_digits_for_a_taut_cable() -> None:
    """x^2 / 6 = (L - D) / D for a small sag."""
    assert catenary_parameter(1.0, 0.0, 1.0 + 1e-10) == pytest.approx(math.sqrt(6e-10), rel=1e-5)


def test_straight_taut_cable_across_the_flow_has_the_tension_of_a_shallow_bow() -> None:
    """By hand: T = q D / (2 sqrt(6 (L / D - 1))) with q = rho C_n d V^2 / 2, sag small."""
    got = solve(Cable(100.01, 0.02, 1.2, 0.0), np.array([100.0, 0.0, 0.0]), (0.0, 0.5, 0.0))
    by_hand = 0.5 * RHO * 1.2 * 0.02 * 0.25 * 100 / (2 * math.sqrt(6e-4))
    assert got.tension_size_n[50] == pytest.approx(by_hand, rel=1e-3)
    assert got.position_m[50, 1] > 0  # the bow hangs downstream
    assert got.force_on_start_n[1] > 0  # and drags both ends with the flow
    assert got.force_on_end_n[1] > 0


def test_tangential_drag_alone_builds_up_along_a_streamed_cable() -> None:
    """Hand case of the sign of R_tau: a nearly straight cable in line with the flow."""
    cable = Cable(100.0 * (1 + 1e-3), 0.014, 0.5, 0.05, wet_weight_npm=0.02)
    got = solve(cable, np.array([100.0, 0.0, 0.0]), (1.0, 0.0, 0.0))
    built_up = 0.5 * RHO * 0.014 * 0.05 * 1.0 * 100.0
    # dT/ds = -R_tau: the upstream end holds what the flow drags downstream
    assert got.tension_size_n[0] - got.tension_size_n[-1] == pytest.approx(built_up, rel=0.01)


@given(
    end=st.tuples(*[st.floats(5.0, 60.0)] * 3),
    ratio=st.floats(1.001, 3.0),
    flow=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.0, 1.0)),
    weight=st.floats(0.2, 5.0),
    stiffness=st.sampled_from([None, 2e3, 1e6]),
)
def test_ends_carry_the_whole_load_and_nothing_twists(
    end: tuple[float, float, float], ratio: float, flow: tuple[float, float, float],
    weight: float, stiffness: float | None,
) -> None:  # fmt: skip
    """Force and moment balance of the cable as one body, by another quadrature."""
    length = float(np.linalg.norm(end)) * ratio
    cable = Cable(length, 0.014, 1.5, 0.02, weight, stiffness)
    got = solve_tether(
        cable, start_m=np.zeros(3), end_m=np.array(end), flow=np.array(flow),
        density_kgpm3=RHO, nodes=4001,
    )  # fmt: skip
    tangent = got.tension_n / got.tension_size_n[:, None]
    load = tether_load(cable, np.broadcast_to(np.array(flow), tangent.shape), tangent, RHO)
    total = np.trapezoid(load, got.arc_length_m, axis=0)
    scale = np.linalg.norm(total) + got.tension_size_n.max()
    assert got.force_on_start_n + got.force_on_end_n == pytest.approx(total, abs=1e-4 * scale)
    moment = np.trapezoid(np.cross(got.position_m, load), got.arc_length_m, axis=0)
    assert np.cross(np.array(end), got.force_on_end_n) == pytest.approx(
        moment, abs=2e-4 * scale * length
    )


@settings(max_examples=15, deadline=None)
@given(ratio=st.floats(1.01, 4.0), vertical=st.floats(-0.8, 0.8))
def test_running_the_cable_from_its_other_end_changes_nothing(
    ratio: float, vertical: float
) -> None:
    a, b = np.array([3.0, -4.0, 10.0]), np.array([40.0, 20.0, 30.0])
    cable = Cable(float(np.linalg.norm(b - a)) * ratio, 0.014, 1.8, 0.025, 1.0 + abs(vertical))
    flow = np.array([0.5, -0.3, max(vertical, 0.0)])
    there = solve_tether(cable, start_m=a, end_m=b, flow=flow, density_kgpm3=RHO)
    back = solve_tether(cable, start_m=b, end_m=a, flow=flow, density_kgpm3=RHO)
    size = there.tension_size_n.max()
    assert back.force_on_end_n == pytest.approx(there.force_on_start_n, abs=1e-4 * size)
    assert back.position_m[::-1] == pytest.approx(there.position_m, abs=1e-4 * cable.length_m)


def test_slack_cable_straight_below_hangs_in_two_legs() -> None:
    """100 m at 1.3 N/m between points 50 m apart, one below the other: 25 m and 75 m of it."""
    got = solve(Cable(100.0, 0.014, 1.8, 0.025, 1.3), np.array([0.0, 0.0, 50.0]))
    assert got.tension_size_n[0] == pytest.approx(75 * 1.3, rel=1e-3)
    assert got.tension_size_n[-1] == pytest.approx(25 * 1.3, rel=1e-3)


@pytest.mark.parametrize("behind", [50.0, -50.0, 0.0])
def test_neutral_slack_cable_in_line_with_the_flow_streams_in_two_legs(behind: float) -> None:
    """Each leg lies along the flow and carries the tangential drag of its own length."""
    cable = Cable(100.0, 0.014, 1.8, 0.025)
    got = solve(cable, np.array([behind, 0.0, 0.0]), (0.5, 0.0, 0.0))
    per_metre = 0.5 * RHO * 0.014 * 0.025 * 0.25
    assert got.force_on_start_n[0] == pytest.approx(per_metre * (100 + behind) / 2, abs=0.006)
    assert got.force_on_end_n[0] == pytest.approx(per_metre * (100 - behind) / 2, abs=0.006)


@pytest.mark.parametrize("behind", [-16.8, 50.0])
def test_a_fold_too_sharp_for_a_small_step_aside_is_opened_further(behind: float) -> None:
    """60 m of ROV cable, upstream and downstream of the garage at its own depth."""
    got = solve(Cable(60.0, 0.0075, 1.2, 0.03), np.array([behind, 0.0, 0.0]), (-0.7, 0.0, 0.0))
    per_metre = 0.5 * RHO * 0.0075 * 0.03 * 0.49
    expected = -per_metre * (60 - behind) / 2
    assert got.force_on_start_n[0] == pytest.approx(expected, abs=0.01 * 60 * per_metre)


def test_a_fold_along_a_line_that_the_mean_load_does_not_tell_is_found() -> None:
    """A floating cable streams past its garage and back; the pull goes on as at the places beside.

    20 m below the garage and 39.6 m upstream of it, seven tenths of the way to the cable's end.
    """
    cable, radius = Cable(60.0, 0.0075, 1.2, 0.03, -0.5), 39.59797974644666
    pulls = []
    for share in (1.0, 0.99, 1.01):
        got = solve_tether(
            cable,
            start_m=np.zeros(3),
            end_m=np.array([-share * radius, 0.0, -20.0]),
            flow=np.array([-0.7, 0.0, 0.0]),
            density_kgpm3=1000.0,
        )
        pulls.append(got.force_on_start_n[[0, 2]])
    assert pulls[0] == pytest.approx((pulls[1] + pulls[2]) / 2, rel=0.01)


def test_elastic_cable_may_be_shorter_than_the_distance() -> None:
    got = solve(Cable(40.0, 0.014, 1.8, 0.025, 1.0, 1e5), np.array([0.0, 0.0, 50.0]), (0.5, 0, 0))
    assert got.tension_size_n[50] == pytest.approx(1e5 * 0.25, rel=1e-3)
    equal = solve(Cable(50.0, 0.014, 1.8, 0.0, 0.0, 1e5), np.array([50.0, 0.0, 0.0]), (0, 0.5, 0))
    q = 0.5 * RHO * 0.014 * 1.8 * 0.25
    # a string with no slack: T^3 = EA (q L)^2 / 24
    assert equal.tension_size_n[0] == pytest.approx((1e5 * (q * 50) ** 2 / 24) ** (1 / 3), rel=5e-3)


def test_sheared_flow_follows_the_field_and_not_its_mean() -> None:
    """All the flow in the upper half: the upper end carries more of the drag."""

    def upper_half(position: np.ndarray) -> np.ndarray:
        speed = 0.6 / (1 + np.exp((position[:, 2] - 20.0) / 2.0))
        return np.stack([speed, 0 * speed, 0 * speed], axis=1)

    got = solve(Cable(42.0, 0.014, 1.2, 0.0), np.array([0.0, 0.0, 40.0]), upper_half)
    assert got.force_on_start_n[0] > 1.5 * got.force_on_end_n[0] > 0


def moorpy() -> ModuleType:
    """Return MoorPy, or skip visibly; its own warnings at import are not ours."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip("moorpy", reason="MoorPy is not installed")


@pytest.mark.parametrize(
    ("span", "rise", "length", "stiffness", "weight"),
    [
        (50.0, 50.0, 100.0, 1e9, 1.3),
        (60.0, 0.0, 65.0, 1e5, 2.0),
        (20.0, 80.0, 120.0, 1e4, 5.0),
        (40.0, 20.0, 60.0, 300.0, 10.0),
        (40.0, 30.0, 49.0, 2e3, 3.0),
        (5.0, 60.0, 200.0, 1e6, 1.0),
    ],
)
def test_moorpy_finds_the_same_elastic_catenary(
    span: float, rise: float, length: float, stiffness: float, weight: float
) -> None:
    moorpy()
    from moorpy.Catenary import catenary

    theirs = catenary(span, rise, length, stiffness, weight, CB=-1e4, Tol=1e-10)[:4]
    got = solve(Cable(length, 0.014, 1.0, 0.0, weight, stiffness), np.array([span, 0.0, -rise]))
    ours = [got.force_on_start_n[0], -got.force_on_start_n[2],
            got.force_on_end_n[0], -got.force_on_end_n[2]]  # fmt: skip
    assert ours == pytest.approx(theirs, abs=1e-6 * math.hypot(theirs[2], theirs[3]))


def against_moorpy_in_a_current(ratio: float, weight: float) -> tuple[float, float]:
    """Return MoorPy's tension over ours, less 1, at both ends of a cable across a current."""
    mp = moorpy()
    end, flow = np.array([30.0, 10.0, 40.0]), np.array([0.4, -0.6, 0.1])
    length, d, up = float(np.linalg.norm(end)) * ratio, 0.014, np.array([1.0, 1.0, -1.0])
    system = mp.System(depth=1000, rho=RHO, g=9.81)
    system.lineTypes["tether"] = {
        "name": "tether", "d_vol": d, "m": weight / 9.81 + math.pi / 4 * d**2 * RHO, "w": weight,
        "EA": 1e6, "Cd": 1.8, "CdAx": 0.025 / math.pi,
    }  # fmt: skip
    top = np.array([0.0, 0.0, -200.0])
    system.addPoint(1, top)
    system.addPoint(1, top + end * up)
    system.addLine(length, "tether", nSegs=200, pointA=1, pointB=2)
    line = system.lineList[0]
    line.setEndPosition(top, 0)
    line.setEndPosition(top + end * up, 1)
    line.staticSolve(profiles=1)
    system.currentMod, system.current = 1, flow * up
    for _ in range(60):
        line.staticSolve(tol=1e-9, profiles=1)
    got = solve(Cable(length, d, 1.8, 0.025, weight, 1e6), end, flow)
    return line.TA / got.tension_size_n[0] - 1, line.TB / got.tension_size_n[-1] - 1


@pytest.mark.parametrize("ratio", [1.0005, 1.002])
@pytest.mark.parametrize("weight", [1e-3, 2.0])
def test_moorpy_finds_the_same_tension_of_a_taut_cable_in_a_current(
    ratio: float, weight: float
) -> None:
    """MoorPy spreads the drag evenly along the cable, which holds for a taut one only."""
    assert max(np.abs(against_moorpy_in_a_current(ratio, weight))) < 5e-3


@pytest.mark.parametrize(("ratio", "apart"), [(1.01, 0.005), (1.05, 0.031), (1.2, 0.117)])
def test_moorpy_parts_from_ours_as_the_cable_slackens(ratio: float, apart: float) -> None:
    """Not an error of either: its even drag is no longer that of the curved cable."""
    worst = max(np.abs(against_moorpy_in_a_current(ratio, 1e-3)))
    assert worst == pytest.approx(apart, abs=0.001)


@pytest.mark.parametrize(
    ("cable", "end", "flow", "words"),
    [
        (Cable(60.0, 0.01, 1.2, 0.0, 1.0), [70.7, 0, 0], [0, 0, 0], "60 m long.*70.7 m apart"),
        (Cable(50.0, 0.01, 1.2, 0.0, 1.0), [50.0, 0, 0], [0, 0, 0], "does not reach"),
        (Cable(60.0, 0.01, 1.2, 0.0), [50.0, 0, 0], [0, 0, 0], "Nothing loads"),
        # slack cable pushed against a fast flow by its weight: compression
        (Cable(400.0, 0.014, 1.7, 0.0, -1.4), [42.0, 46, 12], [0.4, -0.2, 1.0], "No equilibrium"),
    ],
)
def test_what_cannot_be_solved_is_said_with_its_numbers(
    cable: Cable, end: list[float], flow: object, words: str
) -> None:
    with pytest.raises(CannotComputeError, match=words):
        solve(cable, np.array(end, float), flow)
