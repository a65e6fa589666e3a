"""Vehicles and commands of the benchmarks, made here so that they need no vehicle file."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from pipeline.effects.effect import EffectContext
from pipeline.physics.parameters import MOST_THRUSTERS, MOST_WALLS, neutral_vector, read, write
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Method, Trajectory, initial_state, run
from pipeline.types import FloatArray

GRAVITY_MPS2 = 9.81
MASS_KG = 60.0
START = initial_state(
    position_ned_m=(0.0, 0.0, 1.5), attitude_rad=(0.1, -0.1, 0.4), nu=(0.8, -0.1, 0.1, 0, 0, 0.1)
)


def _added_mass() -> FloatArray:
    """Full symmetric added mass, positive definite by diagonal dominance of its correlation."""
    root = np.sqrt([5.0, 50.0, 55.0, 0.5, 9.0, 8.0])
    mixed = np.random.default_rng(1).uniform(-0.1, 0.1, (6, 6))
    correlation = (mixed + mixed.T) / 2.0
    np.fill_diagonal(correlation, 1.0)
    return np.asarray(root[:, None] * correlation * root)


def nominal_vector(thrusters: int) -> FloatArray:
    """Body, hull and thrusters, every effect at its neutral value; the first five as on an AUV."""
    vector = neutral_vector()
    centre = np.array([0.03, -0.02, 0.05])
    c, s = np.cos(np.radians(22.5)), np.sin(np.radians(22.5))
    direction = np.tile([1.0, 0.0, 0.0], (MOST_THRUSTERS, 1))
    direction[:5] = [(c, 0, -s), (c, 0, s), (c, -s, 0), (c, s, 0), (0, 0, -1)]
    angle = np.linspace(0.0, 2.0 * np.pi, MOST_THRUSTERS)
    position = np.stack([-0.9 + 0.0 * angle, 0.2 * np.cos(angle), 0.2 * np.sin(angle)], axis=1)
    position[4] = (0.8, 0.0, 0.0)
    inertia = np.diag([1.0, 9.0, 9.5])
    inertia += MASS_KG * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    for name, value in {
        "mass": MASS_KG,
        "centre_of_mass": centre,
        "inertia": inertia,
        "weight": MASS_KG * GRAVITY_MPS2,
        "buoyancy": MASS_KG * GRAVITY_MPS2 + 2.0,
        "centre_of_buoyancy": np.array([0.0, 0.0, -0.01]),
        "added_mass": _added_mass(),
        "linear_damping": np.diag([3.0, 20.0, 20.0, 0.5, 6.0, 6.0]),
        "quadratic_damping": np.array([20.0, 150.0, 160.0, 1.0, 60.0, 50.0]),
        "thruster_count": float(thrusters),
        "thruster_position": position,
        "thruster_direction": direction,
    }.items():
        write(vector, name, np.asarray(value, float))
    return vector


def switch_on(vector: FloatArray, *, walls: bool = True) -> None:
    """Move every effect off its neutral value, in place."""
    points, normals = np.zeros((MOST_WALLS, 3)), np.zeros((MOST_WALLS, 3))
    points[:, 2] = 12.0 + np.arange(MOST_WALLS)
    normals[:, 2] = -1.0
    for name, value in {
        "current": np.array([0.2, 0.1, 0.02]),
        "crossflow_fraction": 0.9,
        "heave_lift_slope": 30.0,
        "sway_lift_slope": 25.0,
        "pitch_lift_slope": -20.0,
        "yaw_lift_slope": 15.0,
        "turnover_slope": np.array([4.0, -3.0]),
        "coriolis_fraction": 0.95,
        "tether_point": np.array([-0.3, 0.0, -0.1]),
        "tether_drag_area": 0.03,
        "tether_pull": 4.0,
        "tether_anchor": np.array([-5.0, 1.0, 0.0]),
        "lag": 0.25,
        "dead_zone": 3.0,
        "thrust_gain": 0.95,
        "reverse_gain": 0.8,
        "inflow_fraction": 0.9,
        "supply_drop": 0.04,
        "load_drop": 0.06,
        "misalignment_azimuth": 0.02,
        "misalignment_elevation": -0.03,
    }.items():
        write(vector, name, np.asarray(value, float))
    if walls:
        write(vector, "wall_strength", 0.3)
        write(vector, "wall_radius", 1.5)
        write(vector, "wall_count", float(MOST_WALLS))
        write(vector, "wall_point", points)
        write(vector, "wall_normal", normals)


#: Slots that make up one effect each; a test takes them back one by one.
SWITCHES: tuple[tuple[str, ...], ...] = (
    ("current",),
    ("crossflow_fraction",),
    ("heave_lift_slope",),
    ("sway_lift_slope",),
    ("pitch_lift_slope",),
    ("yaw_lift_slope",),
    ("coriolis_fraction",),
    ("tether_drag_area",),
    ("tether_pull",),
    ("lag",),
    ("dead_zone",),
    ("thrust_gain",),
    ("reverse_gain",),
    ("inflow_fraction",),
    ("supply_drop",),
    ("load_drop",),
    ("misalignment_azimuth",),
    ("misalignment_elevation",),
    ("wall_strength",),
)


def reset(vector: FloatArray, neutral: FloatArray, slots: tuple[str, ...]) -> None:
    """Take slots back to their neutral values, in place."""
    for name in slots:
        write(vector, name, read(neutral, name))


def vehicle(
    thrusters: int = 5, *, effects: bool = False, walls: bool = True, shafts: bool = False
) -> PackedVehicle:
    """Benchmark vehicle; `effects` on or neutral, `shafts` solves the torque balance in time."""
    vector = nominal_vector(thrusters)
    if effects:
        switch_on(vector, walls=walls)
    if shafts:
        write(vector, "rotor_inertia", 1e-3)
    code, speed = np.arange(128.0), np.arange(0.0, 2.1, 0.1)
    share = code / 127.0
    table = np.maximum(42.0 * share * (share - speed[:, None] / 5.0), 0.0)
    place = np.linspace(-0.9, 0.9, 10)
    shaft = np.linspace(0.0, 40.0, 400)
    torque = 0.9 * share[:, None] * (1.0 - (shaft / 60.0) ** 2)
    names = ("upper", "lower", "left", "right", "bow", *(f"t{i}" for i in range(6, 13)))
    return PackedVehicle(
        name="benchmark",
        vector=vector,
        strips=np.stack([place, 0.05 + 0.0 * place, 0.04 + 0.0 * place], axis=1),
        thrust_tables=np.stack([table, 0.9 * table])[None],
        screws=np.array([[0.15, 0.139, -0.155, -0.061, 0.016, -0.012, -0.01, shaft[1], 1.0, 0.0]]),
        torque_tables=torque[None],
        steps=np.array([[0.1, 1.0]]),
        context=EffectContext(
            thruster_names=names[:thrusters],
            thrust_falls_with_speed=True,
            coriolis=True,
            strips=True,
            walls=walls,
            gravity_mps2=GRAVITY_MPS2,
        ),
        code_limits=np.array([[-127.0, 127.0]] * thrusters).reshape(-1, 2),
    )


def multisine(steps: int, thrusters: int = 5, dt_s: float = 0.02) -> FloatArray:
    """Codes (steps, thrusters): sums of sines that excite every axis, some of them astern."""
    t = dt_s * np.arange(steps)[:, None]
    rate, phase = 0.3 + 0.17 * np.arange(thrusters), 1.4 * np.arange(thrusters)
    return np.asarray(
        25.0 + 55.0 * np.sin(rate * t + phase) + 25.0 * np.sin(2.7 * rate * t + 2.0 * phase)
    )


def run_many(
    packed: PackedVehicle,
    commands: FloatArray,
    vectors: Sequence[FloatArray],
    *,
    dt_s: float,
    start: FloatArray | None = None,
    method: Method = "rk4",
    threads: int = 2,
) -> list[Trajectory]:
    """Simulate the same commands with several parameter vectors, over threads.

    Parameters as in `run`; the kernel lets go of the interpreter's lock while it computes.
    """

    def one(vector: FloatArray) -> Trajectory:
        return run(packed, commands, dt_s=dt_s, vector=vector, start=start, method=method)

    if threads <= 1 or len(vectors) < 2:
        return [one(vector) for vector in vectors]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(one, vectors))
