"""What is flown: wishes for the autopilot and wrenches on top, drawn anew for every run.

Each kind of run takes three minutes or as long as it is told. In a pool it stays within a few
metres of the middle; a slender hull is steered ahead, in depth, heading and pitch only.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.blind.truth.craft import Craft, rigid_of
from pipeline.blind.truth.kernel_flight import (
    CONTROL_S,
    DEPTH,
    HEADING,
    PITCH,
    PLACE,
    ROLL,
    SURGE,
    WISHES,
    WRENCH,
    Belief,
)
from pipeline.types import FloatArray

#: Weight of an axis that cannot be pushed alone, in the allocation.
LEFT_ALONE = 0.03
#: Bandwidths [rad/s] of surge, place, depth, heading, pitch, roll.
BANDWIDTH = (0.5, 1.0, 0.4, 0.7, 0.9, 1.2)

#: How far from the middle a run in a pool is planned to go: ahead and across [m].
POOL_NORTH_M, POOL_EAST_M = 2.6, 0.9
POOL_DEPTH_M, OPEN_DEPTH_M = 1.4, 12.0


def configuration(craft: Craft) -> FloatArray:
    """Wrench of a unit thrust of each thruster (6, n)."""
    return np.concatenate([craft.push, np.cross(craft.place, craft.push)], axis=1).T


def free_axes(craft: Craft) -> FloatArray:
    """Which of the six axes can be pushed without pushing another one (6,)."""
    matrix = configuration(craft)
    wrong = np.abs(matrix @ np.linalg.pinv(matrix, rcond=1e-6) - np.eye(6))
    return np.asarray(wrong.max(axis=0) < 1e-6)


def pilot_axes(craft: Craft) -> FloatArray:
    """Axes that are steered (6,): those that are free, and yaw where the rudder drags sway along.

    A slender hull turns by side thrusters at one end: sway comes with yaw and is left to drift.
    """
    free = free_axes(craft)
    if not free[5] and np.linalg.norm(configuration(craft)[5]) > 0.0:
        free[5], free[1] = True, False
    return free


def belief_of(craft: Craft) -> Belief:
    """Make the autopilot of a vehicle that is exactly as its file says."""
    axes = pilot_axes(craft)
    matrix = configuration(craft)
    # moments by an arm, so that newtons and newton metres weigh alike
    arm = max(float(np.linalg.norm(matrix[3:]) / np.linalg.norm(matrix[:3])), 1e-3)
    weight = np.where(axes, 1.0, LEFT_ALONE) * np.array([1, 1, 1, 1 / arm, 1 / arm, 1 / arm])
    inverse = np.linalg.pinv(weight[:, None] * matrix, rcond=1e-4) * weight
    inverse = inverse * np.where(axes, 1.0, 0.0)
    laws = [craft.laws[k] for k in craft.kind]
    total = np.diag(rigid_of(craft) + craft.added).copy()
    weight_n = craft.mass_kg * craft.gravity
    arm_z = weight_n * craft.centre_g[2] - craft.buoyancy_n * craft.centre_b[2]
    a = craft.added
    # Munk's moments net of lift, of an angle of attack and of drift
    pitch = craft.coriolis * (a[2, 2] - a[0, 0]) + craft.lift[1] + craft.turning[0]
    yaw = craft.coriolis * (a[1, 1] - a[0, 0]) - craft.lift[3] - craft.turning[1]
    return Belief(
        inertia=total,
        drag=np.array([craft.linear[0, 0], craft.quadratic[0]]),
        bandwidth=np.array(BANDWIDTH),
        inverse=np.ascontiguousarray(inverse),
        most=np.array([law.most_n for law in laws], float).reshape(-1, 2),
        codes=np.stack([law.inverse for law in laws]),
        gravity_stiffness=np.array([arm_z, arm_z]),
        upset=np.array([max(pitch, 0.0), max(yaw, 0.0)]),
    )


def reach_of(craft: Craft) -> FloatArray:
    """Largest force and moment along each steered axis alone (6,); 0 along the others."""
    belief = belief_of(craft)
    reach = np.zeros(6)
    for axis in np.flatnonzero(pilot_axes(craft)):
        ask = belief.inverse[:, axis]
        least = belief.most.min(axis=1)
        reach[axis] = float(np.min(least / np.maximum(np.abs(ask), 1e-9)))
    return reach


@dataclass(frozen=True)
class Scene:
    """Where a run is flown and what the vehicle can do; `reach` (6,) by axis, `speed` cruising."""

    pool: bool
    hovers: bool
    axes: FloatArray
    reach: FloatArray
    speed_mps: float
    tilt_nm: float
    turn_nm: float

    @property
    def depth_m(self) -> float:
        """Depth at which runs are flown."""
        return POOL_DEPTH_M if self.pool else OPEN_DEPTH_M


def scene_of(craft: Craft) -> Scene:
    """Look at the stated vehicle and its surroundings."""
    axes, reach = pilot_axes(craft), reach_of(craft)
    force, d, q = 0.4 * reach[0], craft.linear[0, 0], craft.quadratic[0]
    speed = (-d + np.sqrt(d * d + 4.0 * q * force)) / (2.0 * q) if q > 0 else force / max(d, 1e-9)
    arm = craft.mass_kg * craft.gravity * craft.centre_g[2] - craft.buoyancy_n * craft.centre_b[2]
    inertia = craft.inertia[2, 2] + craft.added[5, 5]
    return Scene(
        pool=bool(len(craft.walls)),
        hovers=bool(axes[1]),
        axes=axes,
        reach=reach,
        speed_mps=float(speed),
        tilt_nm=max(float(arm), 1.0) * 0.2 + 0.1 * float(craft.inertia[1, 1]),
        turn_nm=0.35 * float(inertia),
    )


Run = Callable[[Scene, int, np.random.Generator], FloatArray]


def _hold(scene: Scene, count: int) -> FloatArray:
    """Depth, heading, pitch and roll held, the place too in a pool."""
    out = np.zeros((count, WISHES))
    out[:, DEPTH], out[:, DEPTH + 1] = 1.0, scene.depth_m
    out[:, HEADING] = 1.0
    out[:, PITCH] = 1.0 if scene.axes[4] else 0.0
    out[:, ROLL] = 1.0 if scene.axes[3] else 0.0
    if scene.pool:
        out[:, PLACE] = 1.0
    return out


def _levels(
    count: int, hold_s: tuple[float, float], draw: Callable[[], float], rng: np.random.Generator
) -> FloatArray:
    """Piecewise constant (count,) with random lengths."""
    out = np.zeros(count)
    begin = 0
    while begin < count:
        length = max(int(rng.uniform(*hold_s) / CONTROL_S), 1)
        out[begin : begin + length] = draw()
        begin += length
    return out


def _ramped(values: FloatArray, fastest: float) -> FloatArray:
    """Limit the rate of change of a wish; per second."""
    out = np.empty_like(values)
    now, most = values[0], fastest * CONTROL_S
    for k, want in enumerate(values):
        now += min(max(want - now, -most), most)
        out[k] = now
    return out


def _ahead(scene: Scene, out: FloatArray, speed: FloatArray, rng: np.random.Generator) -> None:
    """Ask for speeds ahead; in a pool to and fro along it."""
    if not scene.pool:
        out[:, SURGE], out[:, SURGE + 1] = 1.0, speed
        return
    side = 1.0 if rng.random() < 0.5 else -1.0
    place, along = 0.0, np.zeros(len(speed))
    for k, want in enumerate(np.abs(speed)):
        place += side * max(want, 0.05) * CONTROL_S
        if abs(place) > POOL_NORTH_M:
            side, place = -side, float(np.clip(place, -POOL_NORTH_M, POOL_NORTH_M))
        along[k] = place
    out[:, PLACE + 1] = along


def _legs(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Legs at several speeds, on headings that are turned round, with coasting between."""
    out = _hold(scene, count)
    share = _levels(count, (14, 24), lambda: rng.choice([0.35, 0.6, 0.85, 1.1, 0.0]), rng)
    _ahead(scene, out, scene.speed_mps * share, rng)
    base = rng.uniform(-np.pi, np.pi)
    turns = _levels(count, (35, 50), lambda: base + np.pi * rng.integers(2), rng)
    out[:, HEADING + 1] = turns
    coast = share == 0.0
    if not scene.pool:
        out[coast, SURGE] = 0.0
    return out


def _zigzag(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Heading to both sides under way, swings of several sizes."""
    out = _hold(scene, count)
    share = _levels(count, (40, 60), lambda: rng.uniform(0.5, 1.0), rng)
    _ahead(scene, out, scene.speed_mps * share, rng)
    side = [1.0]

    def swing() -> float:
        side[0] = -side[0]
        return side[0] * float(np.radians(rng.uniform(15, 45)))

    out[:, HEADING + 1] = rng.uniform(-1, 1) + _levels(count, (7, 14), swing, rng)
    return out


def _dives(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Make steps of depth, at rest and under way, and of pitch and roll where they can be held."""
    out = _hold(scene, count)
    size = 0.5 if scene.pool else 2.0
    out[:, DEPTH + 1] += _levels(count, (10, 18), lambda: rng.uniform(-size, size), rng)
    if scene.axes[4]:
        angle = 10.0 if not scene.hovers else 6.0
        out[:, PITCH + 1] = np.radians(
            _levels(count, (8, 15), lambda: rng.choice([0.0, 1.0, -1.0]) * angle, rng)
        )
    if scene.axes[3]:
        out[:, ROLL + 1] = np.radians(
            _levels(count, (8, 15), lambda: rng.choice([0.0, 0.0, 6.0, -6.0]), rng)
        )
    share = _levels(count, (30, 45), lambda: rng.choice([0.0, 0.5, 0.8]), rng)
    if not scene.pool:
        out[:, SURGE], out[:, SURGE + 1] = 1.0, scene.speed_mps * share
    return out


def _turns(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Circles at several rates to both sides, under way and on the spot."""
    out = _hold(scene, count)
    rate = _levels(
        count, (15, 25), lambda: rng.choice([-1.0, 1.0]) * np.radians(rng.uniform(5, 18)), rng
    )
    out[:, HEADING + 1] = np.cumsum(rate) * CONTROL_S
    share = _levels(count, (30, 45), lambda: rng.choice([0.0, 0.5, 0.8]), rng)
    if not scene.pool:
        out[:, SURGE], out[:, SURGE + 1] = 1.0, scene.speed_mps * share
    else:
        _ahead(scene, out, 0.5 * scene.speed_mps * share, rng)
    return out


def _tasks(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Places, headings and depths one after the other, as in work at a site."""
    out = _hold(scene, count)
    out[:, HEADING + 1] = _ramped(
        _levels(count, (10, 20), lambda: rng.uniform(-1.5, 1.5), rng), np.radians(20)
    )
    size = 0.5 if scene.pool else 3.0
    out[:, DEPTH + 1] += _ramped(
        _levels(count, (12, 22), lambda: rng.uniform(-size, size), rng), 0.25
    )
    if scene.pool:
        for k, most in enumerate((POOL_NORTH_M, POOL_EAST_M)):
            steps = _levels(count, (8, 16), lambda most=most: rng.uniform(-most, most), rng)  # type: ignore[misc]  # defaults of a lambda have no type
            out[:, PLACE + 1 + k] = _ramped(steps, 0.5)
    else:
        speeds = _levels(count, (10, 25), lambda: rng.uniform(-0.2, 1.1), rng)
        _ahead(scene, out, scene.speed_mps * speeds, rng)
    return out


def _excite(scene: Scene, out: FloatArray, shapes: FloatArray, size: float) -> None:
    """Add wrenches (count, 6) of largest size 1 along the steered axes."""
    most = np.minimum(
        0.3 * size * scene.reach,
        [np.inf, np.inf, np.inf, scene.tilt_nm, 1.5 * scene.tilt_nm, 3.0 * scene.turn_nm],
    )
    if scene.pool:
        most = most * np.array([0.6, 0.6, 0.35, 0.6, 0.6, 0.7])
        out[:, PLACE] = 0.4
    out[:, WRENCH : WRENCH + 6] += most * shapes * scene.axes


def _multisine(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Make sums of sines on every axis about a hold."""
    out = _hold(scene, count)
    time_s = np.arange(count) * CONTROL_S
    shapes = np.zeros((count, 6))
    for axis in range(6):
        tones = np.exp(rng.uniform(np.log(0.02), np.log(0.5), 12))
        phase = rng.uniform(0, 2 * np.pi, 12)
        sum_ = np.sin(2 * np.pi * tones * time_s[:, None] + phase).sum(axis=1)
        shapes[:, axis] = sum_ / np.abs(sum_).max()
    _excite(scene, out, shapes, 1.2)
    return out


def _steps(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Random steps of force and moment on every axis about a hold."""
    out = _hold(scene, count)
    shapes = np.stack(
        [
            _levels(count, (1.0, 5.0), lambda: rng.choice([-1.0, -0.4, 0.0, 0.4, 1.0]), rng)
            for _ in range(6)
        ],
        axis=1,
    )
    _excite(scene, out, shapes, 1.0)
    return out


def _drift(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Pushes along every axis, then all thrusters off: coasting, swinging, floating."""
    out = _steps(scene, count, rng)
    quiet = _levels(count, (8, 14), lambda: float(rng.random() < 0.45), rng) > 0.5
    quiet[: int(5 / CONTROL_S)] = False
    out[quiet] = 0.0
    return out


#: Name -> what is flown.
RUNS: Mapping[str, Run] = {
    "legs": _legs,
    "zigzag": _zigzag,
    "dives": _dives,
    "turns": _turns,
    "tasks": _tasks,
    "multisine": _multisine,
    "steps": _steps,
    "drift": _drift,
}
#: Name -> four runs for the diagnosis and two that are held out.
SETS: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "trial": (("legs", "zigzag", "dives", "multisine"), ("tasks", "steps")),
    "work": (("tasks", "turns", "legs", "drift"), ("zigzag", "dives")),
    "bench": (("multisine", "steps", "dives", "turns"), ("legs", "tasks")),
    "transit": (("legs", "legs", "zigzag", "legs"), ("legs", "zigzag")),
    "unseen": (("drift", "turns", "tasks", "steps"), ("drift", "turns")),
}


def wishes_of(
    name: str, scene: Scene, duration_s: float, rng: np.random.Generator
) -> tuple[FloatArray, float]:
    """Return the wishes (m, 19) of a run and the heading that it starts on [rad]."""
    wishes = RUNS[name](scene, round(duration_s / CONTROL_S), rng)
    return wishes, float(wishes[0, HEADING + 1])
