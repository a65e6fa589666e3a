"""Run the kernel: one trajectory, or many with perturbed parameters over threads."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import cycle
from typing import Literal, Protocol

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.records.run_table import AS_STATED, Conditions
from pipeline.simulate.kernel import BODY, RK4, SEMI_IMPLICIT, STATE
from pipeline.simulate.kernel_alone import lag_pieces, simulate_pieces
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pack_hull import vector_under
from pipeline.types import FloatArray, IntArray

Method = Literal["rk4", "semi_implicit"]
_METHODS = {"rk4": RK4, "semi_implicit": SEMI_IMPLICIT}
#: Step times rate of a shaft that is still computed well: half to two thirds of the stable one.
_SHAFT_REACH = {"rk4": 2.0, "semi_implicit": 1.0}


@dataclass(frozen=True)
class Trajectory:
    """A simulated run, sampled at every step; n thrusters, m + 1 samples.

    `time_s` (m + 1,); `position_ned_m` (m + 1, 3); `quaternion` (m + 1, 4) as w, x, y, z, body to
    NED; `nu` (m + 1, 6) u v w p q r over ground [m/s, rad/s]; `nu_dot` (m + 1, 6); `command`
    (m + 1, n) codes; `actuator` (m + 1, n) effective code, or shaft speed [rev/s] where the
    balance is solved in time; `thrust_n` (m + 1, n).
    """

    time_s: FloatArray
    position_ned_m: FloatArray
    quaternion: FloatArray
    nu: FloatArray
    nu_dot: FloatArray
    command: FloatArray
    actuator: FloatArray
    thrust_n: FloatArray
    final_state: FloatArray


def initial_state(
    *,
    position_ned_m: Sequence[float] = (0.0, 0.0, 0.0),
    attitude_rad: Sequence[float] = (0.0, 0.0, 0.0),
    nu: Sequence[float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
) -> FloatArray:
    """Kernel state from position, attitude and velocity over ground. [m], [rad], [m/s, rad/s].

    The attitude is roll, pitch, yaw (rotation order z, y, x).
    """
    from scipy.spatial.transform import Rotation

    roll, pitch, yaw = attitude_rad
    x, y, z, w = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()
    state = np.zeros(STATE)
    state[:3] = position_ned_m
    state[3:7] = (w, x, y, z)
    state[7:13] = nu
    return state


def largest_step_s(
    packed: PackedVehicle, vector: FloatArray | None = None, method: Method = "rk4"
) -> float:
    r"""Largest step for shafts whose torque balance is solved in time; infinite without. [s].

    A shaft settles with the rate (dM_propeller/dn - dM_drive/dn) / (2 pi J), which is taken at its
    largest over the table of the drive. Beyond the limit of the integrator the shaft speed would
    not become infinite but go round in circles, at a thrust that is far off.
    """
    p = packed.vector if vector is None else vector
    inertias, kinds = read(p, "rotor_inertia"), read(p, "thruster_type")
    fastest = 0.0
    for k in np.flatnonzero(inertias[: len(packed.thruster_names)] > 0.0).tolist():
        inertia, kind = inertias[k], kinds[k]
        rate = packed.fastest_shaft_rate(int(kind), float(read(p, "density")))
        fastest = max(fastest, rate / float(inertia))
    return _SHAFT_REACH[method] / fastest if fastest > 0.0 else float("inf")


def run(
    packed: PackedVehicle,
    commands: FloatArray,
    *,
    dt_s: float,
    vector: FloatArray | None = None,
    start: FloatArray | None = None,
    external: FloatArray | None = None,
    method: Method = "rk4",
    start_time_s: float = 0.0,
) -> Trajectory:
    """Simulate `commands` (m, n), codes of the n thrusters, held for one step `dt_s` each. [s].

    `vector` takes the place of the nominal one; `start` is the kernel state at `start_time_s`, at
    rest at the origin otherwise. `external` (m, 6) or (1, 6) is a force [N] and moment [N m] on the
    body from outside the model (gripper, snag). "rk4" is of fourth order, "semi_implicit" of first
    with the pose moved by the new velocity.

    Raises
    ------
    CannotComputeError
        For commands that are not finite or not (m, n), and when the state leaves the finite
        numbers: the step is too large for this vehicle.
    """
    p = packed.vector if vector is None else vector
    codes = checked_codes(packed, commands, p, dt_s, start_time_s=start_time_s, method=method)
    outside = np.zeros((1, 6)) if external is None else np.ascontiguousarray(external, float)
    begin = (initial_state() if start is None else np.array(start, float))[None]
    whole = Pieces(codes, np.array([0, len(codes)]), np.array([dt_s], float))
    states, accelerations, thrusts = run_pieces(packed, whole, p, begin, outside, _METHODS[method])
    if not np.isfinite(states[-1]).all():
        last = int(np.argmax(~np.isfinite(states).all(axis=1)))
        raise CannotComputeError(
            f"the simulation of {packed.name} left the finite numbers at "
            f"{start_time_s + last * dt_s:.3f} s: a step of {dt_s:g} s is too large for this "
            "vehicle's fastest motion; try half of it"
        )
    return trajectory(packed, codes, states, accelerations, thrusts, dt_s, start_time_s)


def checked_codes(
    packed: PackedVehicle,
    commands: FloatArray,
    vector: FloatArray,
    dt_s: float,
    *,
    start_time_s: float,
    method: Method = "rk4",
) -> FloatArray:
    """Return commands (m, n) as the kernel takes them, (m, 12); raises as `run`."""
    count = len(packed.thruster_names)
    codes = np.asarray(commands, float)
    if codes.ndim != 2 or codes.shape[1] != count or not len(codes):
        raise CannotComputeError(
            f"commands of shape {codes.shape} were given; (steps, {count}) are expected, one "
            f"column for each of {', '.join(packed.thruster_names)}"
        )
    if not np.isfinite(codes).all():
        row, column = np.argwhere(~np.isfinite(codes))[0]
        raise CannotComputeError(
            f"the command of {packed.thruster_names[column]} at {row * dt_s + start_time_s:.3f} s "
            "is not a number"
        )
    check_step(dt_s)
    limit = largest_step_s(packed, vector, method)
    if dt_s > limit:
        raise CannotComputeError(
            f"a step of {dt_s:g} s is too large for the shafts of {packed.name}, whose torque "
            f"balance is solved in time: at most {limit:.2g} s"
        )
    padded = np.zeros((len(codes), MOST_THRUSTERS))
    padded[:, :count] = codes
    return padded


def check_step(dt_s: float) -> None:
    """Refuse a step that is none."""
    if not (np.isfinite(dt_s) and dt_s > 0.0):
        raise CannotComputeError(f"a step of {dt_s:g} s cannot be; a time above zero is expected")


def trajectory(  # noqa: PLR0917 - what the kernel filled
    packed: PackedVehicle,
    codes: FloatArray,
    states: FloatArray,
    accelerations: FloatArray,
    thrusts: FloatArray,
    dt_s: float,
    start_time_s: float,
) -> Trajectory:
    """Return a run from what the kernel took and filled."""
    count = len(packed.thruster_names)
    return Trajectory(
        time_s=start_time_s + dt_s * np.arange(len(states), dtype=float),
        position_ned_m=states[:, 0:3],
        quaternion=states[:, 3:7],
        nu=states[:, 7:13],
        nu_dot=accelerations,
        command=np.concatenate([codes[:, :count], codes[-1:, :count]]),
        actuator=states[:, BODY : BODY + count],
        thrust_n=thrusts[:, :count],
        final_state=states[-1].copy(),
    )


class Mover(Protocol):
    """Simulates commands held for one step each; `run` is one.

    One that carries a state of its own (a tether) goes on from where its last call ended.
    """

    def __call__(
        self,
        packed: PackedVehicle,
        commands: FloatArray,
        *,
        dt_s: float,
        vector: FloatArray | None = None,
        start: FloatArray | None = None,
        start_time_s: float = 0.0,
    ) -> Trajectory:
        """Return the run of commands (m, n); arguments as `run` takes them."""
        ...


#: What effective codes follow from, beside commands and starts.
_OF_DRIVES = (
    *("thruster_count", "code_max", "code_min", "dead_zone", "supply_drop", "load_drop"),
    *("drive_dead", "lag_dead_share", "lag", "lag_power", "lag_fall", "rotor_inertia"),
)


@dataclass(frozen=True)
class Pieces:
    """Stretches: `commands` (m, n) of all of them, `bounds` (k + 1,), `steps_s` (k,) their steps.

    `conditions` (k,) of each, or of all. Of the results a stretch fills one row more than it has
    steps: rows `first_row` (k,) to `last_row` (k,), both included.
    """

    commands: FloatArray
    bounds: IntArray
    steps_s: FloatArray
    conditions: tuple[Conditions, ...] = (AS_STATED,)
    late: dict[bytes, FloatArray] = field(default_factory=dict, compare=False)
    """Effective codes by what they follow from: the same for many simulations in turn."""

    @property
    def first_row(self) -> IntArray:
        """Row of the start of each stretch."""
        return np.asarray(self.bounds[:-1] + np.arange(self.steps_s.size))

    @property
    def last_row(self) -> IntArray:
        """Row of the end of each stretch."""
        return np.asarray(self.bounds[1:] + np.arange(self.steps_s.size))


def run_pieces(  # noqa: PLR0917 - what is flown, and by what
    packed: PackedVehicle,
    pieces: Pieces,
    vector: FloatArray,
    starts: FloatArray,
    external: FloatArray,
    method: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """States (m + k, STATE), accelerations (m + k, 6) and thrusts (m + k, 12) of all stretches.

    A simulation that leaves the finite numbers is not refused: its rows are not finite. `vector` is
    the vehicle's, whatever ran with more ballast or less, or (k, p) that of each stretch; `starts`
    (k, STATE) are first states, `external` (m, 6) or (1, 6) force [N] and moment [N m] from
    outside, held for each step.
    """
    rows = len(pieces.commands) + len(starts)
    found = np.empty((rows, STATE)), np.empty((rows, 6)), np.empty((rows, MOST_THRUSTERS))
    if vector.ndim > 1 or len(set(pieces.conditions)) > 1:
        lengths, numbers = np.diff(pieces.bounds), np.arange(pieces.steps_s.size)
        step_of, row_of = np.repeat(numbers, lengths), np.repeat(numbers, lengths + 1)
        of_each = np.broadcast_to(vector, (numbers.size, vector.shape[-1]))
        known = [one for one, _ in zip(cycle(pieces.conditions), numbers, strict=False)]
        kinds = [(one, row.tobytes()) for one, row in zip(known, of_each, strict=True)]
        for first in {kind: kinds.index(kind) for kind in kinds}.values():
            own = np.array([kind == kinds[first] for kind in kinds])
            bounds = np.concatenate([[0], np.cumsum(lengths[own])])
            one = (known[first],)
            part = Pieces(pieces.commands[own[step_of]], bounds, pieces.steps_s[own], one)
            outside = external if len(external) == 1 else external[own[step_of]]
            parts = run_pieces(packed, part, of_each[first], starts[own], outside, method)
            for whole, values in zip(found, parts, strict=True):
                whole[own[row_of]] = values
        return found
    under = vector_under(pieces.conditions[0], vector)
    begin, steps_s = np.ascontiguousarray(starts, float), np.ascontiguousarray(pieces.steps_s)
    bounds, outside = pieces.bounds.astype(np.int64), np.ascontiguousarray(external, float)
    key = b"".join(read(under, name).tobytes() for name in _OF_DRIVES) + begin[:, BODY:].tobytes()
    late = pieces.late.get(key)
    if late is None:
        codes = np.zeros((len(pieces.commands), MOST_THRUSTERS))
        codes[:, : pieces.commands.shape[1]] = pieces.commands
        # at the start, the middle and the end of each step
        late = np.empty((len(codes), 3, MOST_THRUSTERS))
        lag_pieces(under, begin, codes, bounds, steps_s, late)
        for oldest in list(pieces.late)[:-3]:
            pieces.late.pop(oldest, None)
        pieces.late[key] = late
    simulate_pieces(under, begin, late, outside, bounds, steps_s, method, *packed.tables, *found)
    return found
