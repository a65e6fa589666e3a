r"""A tether at rest between two points in a flow: the quasi-static cable.

Equilibrium of a piece of cable, in three dimensions, s from start to end:

.. math::

    \frac{d r}{d s} = \left(1 + \frac{T}{EA}\right) t, \qquad
    \frac{d (T t)}{d s} = -q

with q the load of `tether_cable.tether_load` on an unstretched metre. In the plane of a uniform
flow, with no weight and the angle alpha between t and V, this is

.. math:: \frac{dT}{ds} = -R_\tau, \qquad T \frac{d\alpha}{ds} = R_n

with R_tau, R_n of Kostenko and Mokeeva 2009. Their eq. (1) prints a minus before R_n too. No
direction of s or of the flow makes both signs minus: both equations keep their form when the cable
is run through from its other end, and both change sign with the flow.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_bvp

from pipeline.errors import CannotComputeError
from pipeline.physics.catenary import uniform_load_cable
from pipeline.physics.tether_cable import Cable, TetherSolution, tether_load
from pipeline.types import FloatArray

#: Relative error of the equations that is allowed. [-]
_TOLERANCE = 1e-6
#: Velocity of the water past the cable [m/s], shape (n, 3), at positions [m], shape (n, 3).
FlowField = Callable[[FloatArray], FloatArray]
#: Shortest distances between the ends across the load that are tried, in cable lengths.
LEAST_SPANS = (1e-4, 3e-3)
#: The same where nothing else converges: a neutral cable folds in a bend as sharp as it can.
LAST_SPAN = 1e-2


@dataclass(frozen=True)
class _Problem:
    """What the equations need, with forces in units of `force_n` and lengths of the cable's."""

    cable: Cable
    start_m: FloatArray
    end_m: FloatArray
    flow: FlowField
    density_kgpm3: float
    force_n: float


def solve_tether(
    cable: Cable,
    *,
    start_m: FloatArray,
    end_m: FloatArray,
    flow: FloatArray | FlowField,
    density_kgpm3: float,
    nodes: int = 101,
) -> TetherSolution:
    """Solve the cable between two given ends, NED.

    The two-point problem is solved by collocation (scipy's `solve_bvp`) from the catenary under the
    drag of the straight cable; if that does not converge, the true load is brought in by steps.
    `flow` is the velocity of the water past the cable, (3,) everywhere or a function of position
    [m/s]; `nodes` points are returned, evenly spaced along the cable.

    Raises
    ------
    CannotComputeError
        The cable is too short, nothing loads it, or no equilibrium was found. The text gives the
        numbers.

    Notes
    -----
    A slack cable whose ends lie in line with its load folds to a point of no tension, where the
    equations have no solution. If the ends are nearer than 1e-4 cable lengths across the mean load
    (2 cm of 200 m), the end is taken that far aside, or 3e-3 if that fails; the tension at the ends
    of such a fold changes by 0.2 % or less. Where nothing has converged, ends nearer than 1e-2 are
    taken that far apart across the load: a neutral cable along the flow is then met within 1 % of
    the drag along all of it. A floating or heavy cable in a flow folds along a line that no mean
    load tells; there the end is moved by 3e-3 cable lengths across the line between the ends.

    Examples
    --------
    A hanging chain, 1 N/m, of 2 sinh(1) m over 2 m: 1 N in the middle, cosh(1) N at the ends.

    >>> chain = Cable(2 * np.sinh(1.0), 0.01, 1.2, 0.02, wet_weight_npm=1.0)
    >>> rest = solve_tether(chain, start_m=np.zeros(3), end_m=np.array([2.0, 0, 0]),
    ...                     flow=np.zeros(3), density_kgpm3=1000.0)
    >>> rest.tension_size_n[[0, 50, 100]].round(5).tolist()
    [1.54308, 1.0, 1.54308]
    """
    a, b = np.asarray(start_m, float), np.asarray(end_m, float)
    _check_reach(cable, a, b)
    field = flow if callable(flow) else _uniform(np.asarray(flow, float))
    guesses = _mean_loads(cable, a, b, field, density_kgpm3)
    largest = max(float(np.linalg.norm(g)) for g in guesses)
    problem = _Problem(cable, a, b, field, density_kgpm3, largest * cable.length_m)
    attempts = [(problem, load, False) for load in guesses] + [(problem, guesses[0], True)]
    shifted = [replace(problem, end_m=_aside(problem, guesses[0], e)) for e in LEAST_SPANS]
    if not np.array_equal(shifted[0].end_m, b):
        attempts = [(near, load, False) for load in guesses for near in shifted]
    wide = replace(problem, end_m=_aside(problem, guesses[0], LAST_SPAN))
    if not np.array_equal(wide.end_m, b):
        attempts += [(wide, load, False) for load in guesses]
    attempts += [(near, guesses[0], False) for near in _across(problem, guesses[0])]
    for attempt, mean_load, stepped in attempts:
        found = _continued(attempt, mean_load, nodes, stepped=stepped)
        if found is not None:
            return found
    raise CannotComputeError(
        f"No equilibrium was found for {cable.length_m:g} m of cable between points "
        f"{np.linalg.norm(b - a):.6g} m apart.\nA slack cable that its weight pushes against the "
        "flow has none (it would be in compression); otherwise the flow may change too sharply "
        "along the cable. Take in slack, or try a smoother flow."
    )


def _check_reach(cable: Cable, start: FloatArray, end: FloatArray) -> None:
    """Refuse a cable that does not reach."""
    distance = float(np.linalg.norm(end - start))
    if cable.axial_stiffness_n is None and cable.length_m <= distance * (1 + 1e-7):
        raise CannotComputeError(
            f"The tether is {cable.length_m:g} m long and its ends are {distance:.6g} m apart: it "
            "does not reach.\nPay out more cable, bring the ends nearer, or state the cable's "
            "axial stiffness if it is meant to be stretched."
        )


def _uniform(velocity: FloatArray) -> FlowField:
    """Return a flow that is the same everywhere."""
    return lambda position: np.broadcast_to(velocity, position.shape)


def _mean_loads(
    cable: Cable, start: FloatArray, end: FloatArray, flow: FlowField, density: float
) -> list[FloatArray]:
    """Return uniform loads to start from: weight with half and all of the broadside drag."""
    line = start + np.linspace(0.0, 1.0, 9)[:, None] * (end - start)
    velocity = np.asarray(flow(line), float)
    speed = np.linalg.norm(velocity, axis=1, keepdims=True)
    drag = np.mean(0.5 * density * cable.diameter_m * cable.normal_drag * speed * velocity, axis=0)
    weight = np.array([0.0, 0.0, cable.wet_weight_npm])
    loads = [weight + 0.5 * drag, weight + drag, drag, weight]
    scale = max(float(np.linalg.norm(drag)), abs(cable.wet_weight_npm))
    if scale == 0.0:
        raise CannotComputeError(
            "Nothing loads the tether: no wet weight and no flow across it, so its shape is not "
            "determined and it pulls with nothing.\nState a wet weight or a flow."
        )
    return [load for load in loads if np.linalg.norm(load) > 1e-3 * scale]


def _step_aside(problem: _Problem, share: float) -> float:
    """Return a share of the cable's length, or less: a move must not take up its slack. [m]."""
    chord, length = problem.end_m - problem.start_m, problem.cable.length_m
    slack = np.sqrt(max(length**2 - float(chord @ chord), 0.0))
    return float(min(share * length, 0.03 * slack))


def _aside(problem: _Problem, load: FloatArray, share: float) -> FloatArray:
    """Return the end, moved so that the ends are not in line with the load."""
    _, sideways, span = _directions(problem.end_m - problem.start_m, load)
    least = _step_aside(problem, share)
    return np.asarray(problem.end_m + max(least - span, 0.0) * sideways, dtype=float)


def _across(problem: _Problem, load: FloatArray) -> list[_Problem]:
    """Return the problem with its end moved a little across the line between the ends, both ways.

    A taut cable is left as it is.
    """
    chord, size = problem.end_m - problem.start_m, _step_aside(problem, LEAST_SPANS[-1])
    if size == 0.0 or not chord.any():
        return []
    step = size * _directions(load, chord)[1]
    return [replace(problem, end_m=problem.end_m + way * step) for way in (1.0, -1.0)]


def _directions(chord: FloatArray, load: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the direction of the load, one across it towards the end, and the span across."""
    down = load / np.linalg.norm(load)
    across = chord - (chord @ down) * down
    span = float(np.linalg.norm(across))
    if span > 1e-9 * np.linalg.norm(chord):
        return down, across / span, span
    axis = np.eye(3)[int(np.argmin(np.abs(down)))]
    across = axis - (axis @ down) * down
    return down, across / np.linalg.norm(across), span


def _first_guess(problem: _Problem, load: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return arc lengths, positions and tensions to start from."""
    a, b, length = problem.start_m, problem.end_m, problem.cable.length_m
    chord = b - a
    distance = float(np.linalg.norm(chord))
    stiffness = problem.cable.axial_stiffness_n
    if stiffness is not None and length < distance * (1 + 1e-6):
        # a stretched string: strain of the chord, and the sag that the load brings
        sag_tension = np.cbrt(stiffness * (np.linalg.norm(load) * length) ** 2 / 24)
        size = max(stiffness * (distance / length - 1), float(sag_tension))
        s = np.linspace(0.0, length, 41)
        places = a + (s / length)[:, None] * chord
        return s, places, np.tile(size * chord / distance, (s.size, 1))
    _, sideways, span = _directions(chord, load)
    least = 1e-3 * length
    end = b if span >= least else b + (least - span) * sideways
    reach = max(length, float(np.linalg.norm(end - a)) * (1 + 1e-6))
    # nodes even in arc length and, for a sharp fold, even in direction
    even = np.linspace(0.0, reach, 41)
    _, tension = uniform_load_cable(even, length_m=reach, start_m=a, end_m=end, load_npm=load)
    lowest = np.clip(_lowest(tension, load), 0.0, reach)
    weight = float(np.linalg.norm(load))
    across = tension[0] - (tension[0] @ load) * load / weight**2
    radius = max(float(np.linalg.norm(across)) / weight, 1e-9 * reach)  # of the bend
    bound = np.arcsinh(reach / radius)
    near = lowest + radius * np.sinh(np.linspace(-bound, bound, 41))
    s = np.unique(np.concatenate([even, near[(near > 0) & (near < reach)]]))
    s = s[np.concatenate([[True], np.diff(s) > 1e-9 * reach])]
    s[-1] = reach
    places, tension = uniform_load_cable(s, length_m=reach, start_m=a, end_m=end, load_npm=load)
    return s * length / reach, places, tension


def _lowest(tension: FloatArray, load: FloatArray) -> float:
    """Return the arc length where the tension has no component along the load."""
    return float(tension[0] @ load / (load @ load))


def _continued(
    problem: _Problem, mean_load: FloatArray, nodes: int, *, stepped: bool
) -> TetherSolution | None:
    """Solve, with the load brought from the mean one to the true one if `stepped`, or give up."""
    length, force = problem.cable.length_m, problem.force_n
    stiffness = problem.cable.axial_stiffness_n
    compliance = 0.0 if stiffness is None else force / stiffness
    smallest = 1e-9  # keeps the tangent defined at a point of no tension

    def equations(share: float) -> Callable[[FloatArray, FloatArray], FloatArray]:
        def right_side(_: FloatArray, y: FloatArray) -> FloatArray:
            size = np.sqrt(np.sum(y[3:] ** 2, axis=0) + smallest**2)
            tangent = y[3:] / size
            velocity = problem.flow(y[:3].T * length)
            true = tether_load(problem.cable, velocity, tangent.T, problem.density_kgpm3).T
            load = share * true + (1 - share) * mean_load[:, None]
            return np.vstack([tangent * (1 + compliance * size), -load * length / force])

        return right_side

    def ends(first: FloatArray, last: FloatArray) -> FloatArray:
        return np.concatenate(
            [first[:3] - problem.start_m / length, last[:3] - problem.end_m / length]
        )

    s, places, tension = _first_guess(problem, mean_load)
    x, y = s / length, np.vstack([places.T / length, tension.T / force])
    share, step = 0.0, 0.25 if stepped else 1.0
    while share < 1.0:
        following = min(share + step, 1.0)
        with np.errstate(all="ignore"):
            solved = solve_bvp(equations(following), ends, x, y, tol=_TOLERANCE, max_nodes=1200)
        if solved.success and np.isfinite(solved.y).all():
            share, x, y = following, solved.x, solved.y
        elif step > 1 / 64 and stepped:
            step /= 2
        else:
            return None
    at = np.linspace(0.0, 1.0, nodes)
    values = solved.sol(at)
    return TetherSolution(
        arc_length_m=at * length,
        position_m=values[:3].T * length,
        tension_n=values[3:].T * force,
        residual=float(np.max(np.asarray(solved.rms_residuals))),
    )
