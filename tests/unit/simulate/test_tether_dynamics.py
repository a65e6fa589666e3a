"""The lumped tether alone: its rest, its swings, its energy, its winch, and a second library."""

from itertools import pairwise
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import j0, jn_zeros
from tether_swing import swing

from pipeline.errors import CannotComputeError
from pipeline.physics.tether_cable import Cable, TetherSolution
from pipeline.physics.tether_footprint import Footprint, ned_from_paper
from pipeline.physics.tether_static import FlowField, solve_tether
from pipeline.physics.winch import Winch
from pipeline.simulate.tether import LumpedMassTether, TetherHistory, TetherState
from pipeline.simulate.tethered import hang

RHO, GRAVITY = 1025.0, 9.81
NEUTRAL = RHO * np.pi / 4 * 0.014**2
STILL, TOP, LOW = np.zeros(3), np.zeros(3), np.array([60.0, 0.0, 20.0])
#: Water past the cable of Mokeeva's Table 2 where it is uniform, and one that is turned from it.
FLOW = ned_from_paper(np.array([-1.0, 0.5, -0.5]))
TURNED = ned_from_paper(np.array([-1.0, 0.2, -0.2]))


def rope(segments: int, length: float = 100.0, **numbers: float) -> LumpedMassTether:
    values: dict[str, float] = {
        "diameter_m": 0.014,
        "mass_kgpm": 0.4,
        "normal_drag": 1.2,
        "tangential_drag": 0.03,
        "axial_stiffness_n": 1e5,
        "density_kgpm3": RHO,
        "gravity_mps2": GRAVITY,
    }
    return LumpedMassTether(length, segments, **(values | numbers))


def static(
    tether: LumpedMassTether, low: np.ndarray, flow: np.ndarray | FlowField
) -> TetherSolution:
    cable = Cable(
        tether.length_m,
        tether.diameter_m,
        tether.normal_drag,
        tether.tangential_drag,
        wet_weight_npm=tether.wet_weight_npm,
        axial_stiffness_n=tether.axial_stiffness_n,
    )
    return solve_tether(
        cable,
        start_m=TOP,
        end_m=low,
        flow=flow,
        density_kgpm3=tether.density_kgpm3,
        nodes=tether.segments + 1,
    )


def apart(run: TetherHistory, at_rest: TetherSolution) -> float:
    """Return the largest error: either end's force over it, the shape over the length."""
    top, low = at_rest.force_on_start_n, at_rest.force_on_end_n
    return float(
        max(
            np.linalg.norm(run.force_on_top_ned_n[-1] - top) / np.linalg.norm(top),
            np.linalg.norm(run.force_below_ned_n[-1] - low) / np.linalg.norm(low),
            np.abs(run.position_ned_m[-1] - at_rest.position_m).max() / at_rest.arc_length_m[-1],
        )
    )


CASES = {
    "heavy, still water": (rope(20), LOW, STILL),
    "neutral, uniform current": (rope(40, mass_kgpm=NEUTRAL), LOW, np.array([0.3, 0.5, 0.0])),
    "heavy, across a current": (rope(20), LOW, np.array([0.0, 0.5, 0.0])),
}
MOKEEVA = {"mass_kgpm": NEUTRAL, "normal_drag": 1.8, "tangential_drag": 0.025}
for _angle in (0.0, 90.0, 180.0, 270.0):
    CASES[f"Mokeeva, Table 2, {_angle:g} deg"] = (
        rope(100, 200.0, **MOKEEVA),
        ned_from_paper(Footprint().position_m(_angle)),
        FLOW,
    )


@pytest.mark.parametrize("name", CASES)
def test_settled_nodes_equal_the_quasi_static_cable(name: str) -> None:
    tether, low, flow = CASES[name]
    state = hang(tether, top_ned_m=TOP, lower_ned_m=low, current_mps=flow)
    run = swing(tether, state, steps=1, dt_s=0.01, lower="held", current_mps=flow)
    assert apart(run, static(tether, low, flow)) < 0.01


@pytest.mark.parametrize(
    ("tether", "low", "flow", "before", "seconds"),
    [
        (rope(20, normal_drag=0.3), LOW, STILL, np.array([0.0, 0.6, 0.0]), 100.0),
        (
            rope(20, mass_kgpm=NEUTRAL, axial_stiffness_n=1e4),
            LOW,
            np.array([0.3, 0.5, 0.0]),
            np.array([0.4, 0.5, -0.3]),
            240.0,
        ),
        (
            rope(50, 200.0, axial_stiffness_n=1e4, **MOKEEVA),
            ned_from_paper(Footprint().position_m(0.0)),
            FLOW,
            TURNED,
            300.0,
        ),
    ],
    ids=["heavy, still water", "neutral, current", "Mokeeva, Table 2"],
)
def test_motion_dies_down_to_the_quasi_static_cable(
    tether: LumpedMassTether, low: np.ndarray, flow: np.ndarray, before: np.ndarray, seconds: float
) -> None:
    """From the shape in another current, by the water's drag alone."""
    start = hang(tether, top_ned_m=TOP, lower_ned_m=low, current_mps=before, settle_s=0.0)
    run = swing(tether, start, steps=round(seconds / 0.1), dt_s=0.1, lower="held", current_mps=flow)
    at_rest = static(tether, low, flow)
    assert np.abs(start.position_ned_m - at_rest.position_m).max() > 0.02 * tether.length_m
    assert apart(run, at_rest) < 0.01


def frequency(mode: int, segments: int) -> float:
    """Frequency of a hanging chain in a vacuum, off a run of its mode's shape, over the exact one.

    The exact one is omega_k = j_0k / 2 (g / L)^(1/2), mode shape J_0(j_0k ((L - s) / L)^(1/2)).
    """
    length, mass = 10.0, 0.5
    chain = rope(
        segments, length, mass_kgpm=mass, density_kgpm3=0.0, axial_stiffness_n=2e5,
        axial_damping=0.0,
    )  # fmt: skip
    s = np.linspace(0.0, length, segments + 1)
    zero = jn_zeros(0, mode)[-1]
    pull = mass * GRAVITY * (length - (s[:-1] + s[1:]) / 2)
    down = np.concatenate([[0.0], np.cumsum(chain.segment_m * (1 + pull / 2e5))])
    aside = 1e-3 * j0(zero * np.sqrt((length - s) / length))
    start = TetherState(
        np.stack([aside, 0 * s, down], axis=1),
        np.zeros((segments + 1, 3)),
        np.full(segments, chain.segment_m),
    )
    run = swing(chain, start, steps=3000, dt_s=0.005, lower="free", current_mps=STILL)
    exact = zero / 2 * np.sqrt(GRAVITY / length)
    x = run.position_ned_m[:, -1, 0]
    crossings = np.flatnonzero(np.diff(np.sign(x)) != 0)
    times = run.time_s[crossings] - x[crossings] * 0.005 / (x[crossings + 1] - x[crossings])
    return float(np.pi / np.mean(np.diff(times)) / exact)


@pytest.mark.parametrize(("mode", "allowed"), [(1, 5e-4), (2, 3e-3), (3, 1.2e-2)])
def test_hanging_chain_swings_at_the_zeros_of_bessels_function(mode: int, allowed: float) -> None:
    assert frequency(mode, 40) == pytest.approx(1.0, abs=allowed)


def test_hanging_chain_comes_nearer_with_more_segments() -> None:
    """Lumping the mass is of second order in the length of a segment."""
    coarse, fine = abs(frequency(2, 10) - 1), abs(frequency(2, 20) - 1)
    assert coarse / fine == pytest.approx(4.0, rel=0.25)


def pendulum(links: int, length: float, angle: float, times: np.ndarray) -> np.ndarray:
    """Place of the end of an inextensible chain, in angles (Lagrange), by another integrator."""
    link = length / links
    mass = np.append(np.ones(links - 1), 0.5)  # of the nodes 1 to n
    below = np.cumsum(mass[::-1])[::-1]
    most = below[np.maximum.outer(np.arange(links), np.arange(links))]

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        theta, omega = y[:links], y[links:]
        between = theta[:, None] - theta
        right = -most @ np.zeros(links) - (most * np.sin(between)) @ omega**2
        right -= GRAVITY / link * below * np.sin(theta)
        return np.concatenate([omega, np.linalg.solve(most * np.cos(between), right)])

    start = np.concatenate([np.full(links, angle), np.zeros(links)])
    solved = solve_ivp(rate, (0.0, times[-1]), start, "DOP853", times, rtol=1e-10, atol=1e-10)
    theta = solved.y[:links]
    return np.stack([link * np.sin(theta).sum(0), link * np.cos(theta).sum(0)], axis=1)


def test_large_swings_equal_an_inextensible_chain_in_angles() -> None:
    links, length, angle = 6, 3.0, 0.9
    chain = rope(links, length, density_kgpm3=0.0, axial_stiffness_n=1e6)
    s = np.linspace(0.0, length, links + 1)
    start = TetherState(
        np.stack([s * np.sin(angle), 0 * s, s * np.cos(angle)], axis=1),
        np.zeros((links + 1, 3)),
        np.full(links, chain.segment_m),
    )
    run = swing(chain, start, steps=150, dt_s=0.02, lower="free", current_mps=STILL)
    exact = pendulum(links, length, angle, run.time_s)
    np.testing.assert_allclose(run.position_ned_m[:, -1][:, [0, 2]], exact, atol=2e-3 * length)


def energy(tether: LumpedMassTether, state: TetherState) -> tuple[float, float]:
    """Return kinetic energy, with added mass, and the whole."""
    place, speed, rest = state.position_ned_m, state.velocity_ned_mps, state.rest_length_m
    chord = np.diff(place, axis=0)
    length = np.linalg.norm(chord, axis=1)
    along = chord / length[:, None]
    added = tether.added_mass * tether.density_kgpm3 * np.pi / 4 * tether.diameter_m**2
    kinetic = potential = 0.0
    for end in (slice(None, -1), slice(1, None)):
        across = speed[end] - np.sum(speed[end] * along, axis=1, keepdims=True) * along
        squares = tether.mass_kgpm * np.sum(speed[end] ** 2, axis=1)
        squares += added * np.sum(across**2, axis=1)
        kinetic += float(np.sum(0.25 * rest * squares))
        potential -= float(np.sum(0.5 * rest * tether.wet_weight_npm * place[end, 2]))
    strain = np.maximum(length / rest - 1, 0.0)
    elastic = float(np.sum(0.5 * tether.axial_stiffness_n * rest * strain**2))
    return kinetic, kinetic + potential + elastic


@pytest.mark.parametrize("density", [0.0, RHO])
@pytest.mark.parametrize("damping", [0.0, 0.5])
@pytest.mark.parametrize("angle", [0.35, 1.57])
def test_energy_without_drag_never_grows_and_is_kept_without_damping(
    density: float, damping: float, angle: float
) -> None:
    """A rope let go at an angle, or level, which throws it about and slackens it."""
    tether = rope(
        20, 20.0, diameter_m=0.02, mass_kgpm=0.6, normal_drag=0.0, tangential_drag=0.0,
        axial_stiffness_n=1e4, density_kgpm3=density, axial_damping=damping,
    )  # fmt: skip
    s = np.linspace(0.0, 20.0, 21)
    place = np.stack([s * np.sin(angle), 0.1 * np.sin(s), s * np.cos(angle)], axis=1)
    rest = np.linalg.norm(np.diff(place, axis=0), axis=1)
    state = TetherState(place, np.zeros((21, 3)), rest)
    total, largest = [energy(tether, state)[1]], 0.0
    for _ in range(40):
        run = swing(tether, state, steps=10, dt_s=0.02, lower="free", current_mps=STILL)
        state = run.final
        kinetic, whole = energy(tether, state)
        total.append(whole)
        largest = max(largest, kinetic)
    assert np.max(np.diff(total)) < 1e-6 * largest
    if damping == 0.0:
        # what is lost are axial waves too short for the sub-step
        assert total[0] - total[-1] < 0.03 * largest


def test_halving_the_step_is_of_fourth_order() -> None:
    """A soft rope in a current, so that one sub-step is enough and the step is the integrator's."""
    tether = rope(5, 20.0, axial_stiffness_n=400.0)
    start = hang(tether, top_ned_m=TOP, lower_ned_m=np.array([12.0, 0, 12.0]), current_mps=STILL)
    ends = []
    for halvings in range(4):
        dt = 0.02 / 2**halvings
        run = swing(
            tether, start, steps=round(2.0 / dt), dt_s=dt, lower="held",
            current_mps=np.array([0.3, 0.4, 0.0]),
        )  # fmt: skip
        assert run.substeps.max() == 1
        assert np.nanmin(run.tension_n) > 0
        ends.append(run.final.position_ned_m)
    steps = [np.abs(a - b).max() for a, b in pairwise(ends)]
    assert steps[0] / steps[1] == pytest.approx(16.0, rel=0.2)
    assert steps[1] / steps[2] == pytest.approx(16.0, rel=0.2)


def test_fast_waves_are_stepped_over_by_their_own_courant_number() -> None:
    """By hand: omega = 2 (EA / m)^(1/2) / l, a sub-step of 1 / omega."""
    tether = rope(20, density_kgpm3=0.0)
    state = hang(tether, top_ned_m=TOP, lower_ned_m=LOW, current_mps=STILL, settle_s=0.0)
    run = swing(tether, state, steps=1, dt_s=0.1, lower="held", current_mps=STILL)
    assert run.substeps[0] == np.ceil(0.1 * 2 * np.sqrt(1e5 / 0.4) / 5.0)


def test_cable_pulls_or_does_nothing() -> None:
    tether = rope(10, 30.0)
    start = hang(tether, top_ned_m=TOP, lower_ned_m=np.array([29.0, 0, 0]), current_mps=STILL)
    inward = np.array([-3.0, 0.0, 0.0])
    run = swing(
        tether, start, steps=100, dt_s=0.02, lower="held", current_mps=STILL,
        lower_velocity_mps=inward,
    )  # fmt: skip
    assert run.tension_n.min() == 0.0


HEAVY_DRUM = Winch(0.5, 1e12, 1.0, 1e9, shortest_m=12.0, longest_m=300.0)


def test_paying_out_as_fast_as_the_end_is_drawn_away_keeps_the_tension() -> None:
    """Through four new nodes: a taut straight cable sails out through the sheave."""
    tether = rope(
        20, density_kgpm3=0.0, gravity_mps2=0.0, normal_drag=0.0, tangential_drag=0.0
    )  # fmt: skip
    strain, rate = 1e-3, 0.5
    place = np.linspace(0.0, 1.0, 21)[:, None] * np.array([0.0, 0.0, 100.0 * (1 + strain)])
    away = np.array([0.0, 0.0, rate * (1 + strain)])
    speed = np.tile(away, (21, 1))
    speed[0] = 0.0
    state = TetherState(place, speed, np.full(20, 5.0), drum_speed_radps=rate / 0.5)
    run = swing(
        tether, state, steps=1800, dt_s=0.02, lower="held", current_mps=STILL,
        lower_velocity_mps=away, winch=HEAVY_DRUM,
    )  # fmt: skip
    assert run.segments[-1] == 24
    assert run.paid_out_m[-1] == pytest.approx(118.0, abs=1e-6)
    assert np.nanmax(np.abs(run.tension_n - 100.0)) < 1e-3


def test_hauling_in_keeps_account_of_the_length_and_the_tension_smooth() -> None:
    tether = rope(20)
    start = hang(tether, top_ned_m=TOP, lower_ned_m=LOW, current_mps=STILL)
    state = TetherState(
        start.position_ned_m, start.velocity_ned_mps, start.rest_length_m, drum_speed_radps=-0.5
    )
    run = swing(
        tether, state, steps=3500, dt_s=0.02, lower="held", current_mps=STILL, winch=HEAVY_DRUM
    )
    assert run.segments[-1] == 17
    np.testing.assert_allclose(run.paid_out_m, 100.0 - 0.25 * run.time_s, atol=1e-6)
    assert run.final.paid_out_m == pytest.approx(82.5, abs=1e-6)
    gone = np.flatnonzero(np.diff(run.segments))
    jumps = np.abs(run.top_tension_n[gone + 1] - run.top_tension_n[gone])
    assert np.all(jumps < 0.05 * run.top_tension_n[gone])


def test_hauled_in_cable_ends_in_the_shape_of_the_shorter_one() -> None:
    winch = Winch(0.5, 50.0, 2000.0, 0.6, dry_friction_nm=5.0, brake_nm=5e3, shortest_m=20.0)
    tether = rope(20)
    start = hang(tether, top_ned_m=TOP, lower_ned_m=LOW, current_mps=STILL)
    command = np.where(np.arange(3000) < 2000, -1.0, 0.0)
    run = swing(
        tether, start, steps=3000, dt_s=0.05, lower="held", current_mps=STILL,
        winch=winch, winch_command=command,
    )  # fmt: skip
    left = float(run.paid_out_m[-1])
    assert 70.0 < left < 80.0
    assert run.drum_speed_radps[-1] == 0.0
    at_rest = static(rope(40, left), LOW, STILL)
    top = np.linalg.norm(run.force_on_top_ned_n[-1])
    assert top == pytest.approx(float(at_rest.tension_size_n[0]), rel=0.01)


def test_drum_hauls_at_the_speed_of_its_torque_balance() -> None:
    winch = Winch(0.3, 20.0, 300.0, 4.0, dry_friction_nm=10.0, shortest_m=20.0)
    tether = rope(20)
    start = hang(tether, top_ned_m=TOP, lower_ned_m=np.array([10.0, 0, 30.0]), current_mps=STILL)
    run = swing(
        tether, start, steps=1000, dt_s=0.02, lower="held", current_mps=STILL,
        winch=winch, winch_command=-0.5,
    )  # fmt: skip
    torque = 300.0 * -0.5 + 0.3 * float(run.top_tension_n[-1]) + 10.0
    balance = torque / (300.0 / 4.0)
    assert run.drum_speed_radps[-1] == pytest.approx(balance, rel=0.01)


def refused(**change: object) -> str:
    tether = rope(10, 30.0)
    start = hang(tether, top_ned_m=TOP, lower_ned_m=np.array([20.0, 0, 0]), current_mps=STILL)
    options: dict[str, object] = {
        "steps": 5,
        "dt_s": 0.02,
        "lower": "held",
        "current_mps": STILL,
    }
    with pytest.raises(CannotComputeError) as caught:
        swing(tether, start, **(options | change))  # type: ignore[arg-type]
    return str(caught.value)


def test_bad_input_has_one_clear_message_each() -> None:
    assert "5 s is too large" in refused(dt_s=5e5).replace("500000", "5")
    assert "0 s cannot be" in refused(dt_s=0.0)


def test_too_short_a_tether_is_refused_with_both_numbers() -> None:
    with pytest.raises(CannotComputeError, match=r"30 m long.* 31\.000 m") as caught:
        hang(rope(10, 30.0), top_ned_m=TOP, lower_ned_m=np.array([31.0, 0, 0]), current_mps=STILL)
    assert "Pay out more" in str(caught.value)


@pytest.fixture
def moordyn() -> ModuleType:
    """Return MoorDyn, a second lumped-mass library, or skip visibly."""
    return pytest.importorskip("moordyn", reason="MoorDyn is not installed")


LINES = """MoorDyn v2 input
---- LINE TYPES ----
Name Diam Mass/m EA BA EI Cd Ca CdAx CaAx
(-) (-) (-) (-) (-) (-) (-) (-) (-) (-)
rope {d} {m} {ea} {ba} 0 {cn} {ca} {ct} 0.0
---- POINTS ----
ID Type X Y Z Mass Volume CdA CA
(-) (-) (-) (-) (-) (-) (-) (-) (-)
1 Fixed 0 0 -100 0 0 0 0
2 Coupled {x} {y} {z} 0 0 0 0
---- LINES ----
ID LineType AttachA AttachB UnstrLen NumSegs Outputs
(-) (-) (-) (-) (-) (-) (-)
1 rope 1 2 {length} {segments} -
---- OPTIONS ----
2e-4 dtM
0 writeLog
{g} g
{rho} WtrDnsty
500 WtrDpth
rk4 tScheme
0.5 dtIC
60.0 TmaxIC
1.0 CdScaleIC
1e-6 threshIC
---- end ----
"""


def in_moordyn(
    library: ModuleType, folder: Path, tether: LumpedMassTether, velocity: np.ndarray, dt: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return tensions (m + 1, 3) at three nodes and places (m + 1, 3) of the middle one, NED."""
    flip = np.array([1.0, -1.0, -1.0])  # z up there
    place = [float(v) for v in LOW * flip + np.array([0.0, 0.0, -100.0])]
    dashpot = tether.axial_damping * np.sqrt(tether.axial_stiffness_n * tether.mass_kgpm)
    text = LINES.format(
        d=tether.diameter_m,
        m=tether.mass_kgpm,
        ea=tether.axial_stiffness_n,
        ba=dashpot * tether.segment_m,
        cn=tether.normal_drag,
        ca=tether.added_mass,
        ct=tether.tangential_drag / np.pi,  # referred to the girth there
        x=place[0],
        y=place[1],
        z=place[2],
        length=tether.length_m,
        segments=tether.segments,
        g=tether.gravity_mps2,
        rho=tether.density_kgpm3,
    )
    file = folder / "lines.txt"
    file.write_text(text, encoding="utf-8")
    system = library.Create(str(file))
    library.SetVerbosity(system, library.LEVEL_ERR)
    library.Init(system, place, [0.0, 0.0, 0.0])
    line = library.GetLine(system, 1)
    nodes = (1, tether.segments // 2, tether.segments - 1)
    tensions, middle = [], []
    for k in range(len(velocity) + 1):
        tensions.append([np.linalg.norm(library.GetLineNodeTen(line, i)) for i in nodes])
        middle.append(library.GetLineNodePos(line, nodes[1]))
        if k < len(velocity):
            speed = [float(v) for v in velocity[k] * flip]
            library.Step(system, place, speed, k * dt, dt)
            place = [a + dt * b for a, b in zip(place, speed, strict=True)]
    library.Close(system)
    return np.array(tensions), (np.array(middle) + np.array([0.0, 0.0, 100.0])) * flip


def heaving(amplitude: float, period: float, dt: float, seconds: float) -> np.ndarray:
    """Velocities (m, 3) of an end that comes to swing fore and aft and up and down."""
    time = dt * np.arange(round(seconds / dt) + 1)
    share = np.clip(time / 4.0, 0.0, 1.0)
    share = share**2 * (3 - 2 * share)
    phase = 2 * np.pi * time / period
    place = amplitude * share * np.array([np.sin(phase), 0 * time, 0.5 * (1 - np.cos(phase))])
    return np.diff(place.T, axis=0) / dt


@pytest.mark.parametrize(
    ("amplitude", "water", "segments"),
    # without drag nothing damps the waves that a segment is too long for
    [(1.0, (1.0, 1.2), 40), pytest.param(0.5, (0.0, 0.0), 80, marks=pytest.mark.slow)],
)
def test_a_second_lumped_mass_library_gives_the_same_tension_and_motion(
    moordyn: ModuleType,
    tmp_path: Path,
    amplitude: float,
    water: tuple[float, float],
    segments: int,
) -> None:
    """MoorDyn over 10 s of a heaving end: directions of the nodes there, of the segments here."""
    added_mass, drag = water
    tether = rope(segments, normal_drag=drag, added_mass=added_mass)
    dt = 0.005
    velocity = heaving(amplitude, 5.0, dt, 10.0)
    theirs, middle = in_moordyn(moordyn, tmp_path, tether, velocity, dt)
    start = hang(tether, top_ned_m=TOP, lower_ned_m=LOW, current_mps=STILL)
    run = swing(
        tether, start, steps=len(velocity), dt_s=dt, lower="held", current_mps=STILL,
        lower_velocity_mps=velocity,
    )  # fmt: skip
    pair = (run.tension_n[:, 1:] + run.tension_n[:, :-1]) / 2
    ours = pair[:, [0, tether.segments // 2 - 1, -1]]
    error = np.sqrt(np.mean((ours - theirs) ** 2, axis=0)) / np.ptp(theirs, axis=0)
    assert np.all(error < 0.01)
    travel = np.ptp(middle, axis=0).max()
    assert np.abs(run.position_ned_m[:, tether.segments // 2] - middle).max() < 0.01 * travel
