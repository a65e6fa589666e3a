"""Put an effect into a measured run: rewrite the commands that its log claims.

The vehicle flew as it is. With thrust T_0(c) at the logged codes c, a vehicle that had the effect
would have needed other codes c' for the motion that was measured:

    tau_s(c', V) = tau_0(c, V) + [M_s nu' - h_s(nu, R)] - [M_0 nu' - h_0(nu, R)]

with h the forces of the water and of gravity, 0 for the vehicle of its file and s for the same with
the effect of size s. The right-hand side is known from the run, and the characteristic of every
thruster is inverted for c'. Read with c' in place of c the log is that of a vehicle with the
effect, and everything else in it is as it was measured.

The model that reads the log lags its codes, so the commands are those whose lagged codes are c'.
For a longer lag they lead; where that takes them out of the drives' range they stay at its end.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from pipeline.effects.library import apply_effects
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.measured.demand import demanded, settled
from pipeline.measured.lagging import commands_for, lagged
from pipeline.measured.motion import MeasuredMotion, measured_motion
from pipeline.physics.parameters import read, write
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: Effects of the readings: nothing that is commanded explains them.
READINGS = frozenset({"dvl_delay", "dvl_lever_arm", "dvl_misalignment", "dvl_scale"})
#: Halvings of the range of codes: to a hundredth of a code where the range is 800.
_HALVINGS = 16
#: Rows over which a jump through the dead zone is eased, and what is one: a share of full code.
_EASED_ROWS, _JUMP = 3, 0.02
#: How long a level is held of commands that are written for a thruster that stood still. [s]
_HELD_S = 2.0
#: A velocity that was not measured is tried at this. [m/s]
_UNKNOWN_MPS = 0.2
#: Most of the force of an effect that may depend on a velocity that nobody measured. [1]
_MOST_UNKNOWN = 0.1


@dataclass(frozen=True)
class Injection:
    """A run whose commands were rewritten.

    `effect` (m, 6) is the wrench that the effect takes from the vehicle along the run, about the
    body origin [N, N m]. `share` is how much of the effect stands in the log, by the accelerations
    that both mean: no codes of these thrusters may make up for all of it. [1]
    """

    run: RunTable
    effect: FloatArray
    share: float


def injected(
    packed: PackedVehicle,
    run: RunTable,
    specs: Sequence[EffectSpec],
    sensors: Sensors | None = None,
    *,
    motion: MeasuredMotion | None = None,
) -> Injection:
    """Rewrite the commands of a run so that it reads as that of a vehicle with effects.

    `packed` is the vehicle by whose characteristics the commands are read, `motion` that of the
    run, where it is known already.

    Raises `CannotComputeError` for an effect of the readings, one that does nothing in this run, or
    one whose force depends on a velocity that was not measured.
    """
    named = ", ".join(sorted({one.id for one in specs}))
    wrong = sorted({one.id for one in specs} & READINGS)
    if wrong:
        raise CannotComputeError(
            f"{', '.join(wrong)} is an error of the readings: no command explains it. Alter the "
            "readings instead."
        )
    moved = measured_motion(run, sensors) if motion is None else motion
    nominal = settled(packed.vector)
    changed = settled(apply_effects(packed.vector, specs, packed.context))
    if float(read(changed, "load_drop")) != float(read(nominal, "load_drop")):
        raise CannotComputeError(
            "voltage_sag: a drop with the load couples all thrusters, and their codes cannot be "
            "solved for one by one. Inject its drop alone."
        )
    codes = np.nan_to_num(np.array(run.values["command"], float))
    period = run.period_s
    added = _more_demanded(packed, nominal, changed, moved)
    _check_known(packed, nominal, changed, moved, added, named)
    acting = lagged(nominal, codes, period)
    stated, thrust = _pushed(packed, nominal, acting, moved)
    wanted = stated + added
    without, weaker = _pushed(packed, changed, lagged(changed, codes, period), moved)
    # a gain alone needs no other thruster: each makes up for itself
    own = thrust @ layout(packed, changed).T
    asked = thrust + (wanted - own) @ _inverse_layout(packed, changed).T
    new_acting = _acting_for(packed, changed, asked, weaker, acting, moved)
    new = commands_for(packed, changed, new_acting, period)
    made, _ = _pushed(packed, changed, lagged(changed, new, period), moved)
    effect = wanted - without
    size = _accelerating(packed, effect)
    if size == 0.0 or np.allclose(new, codes, atol=1e-6):
        raise CannotComputeError(
            f"{run.name}: {named} does nothing in this run, so there is nothing to put into it."
        )
    share = 1.0 - _accelerating(packed, wanted - made) / size
    table = replace(run, values=run.values | {"command": new})
    return Injection(table, effect, share)


def thrust_wrench(packed: PackedVehicle, run: RunTable, motion: MeasuredMotion) -> FloatArray:
    """Wrench (m, 6) of the thrusters that a run's commands lead to, by the vehicle's file."""
    vector = settled(packed.vector)
    period = run.period_s
    codes = np.nan_to_num(np.array(run.values["command"], float))
    return _pushed(packed, vector, lagged(vector, codes, period), motion)[0]


def _more_demanded(
    packed: PackedVehicle, nominal: FloatArray, changed: FloatArray, moved: MeasuredMotion
) -> FloatArray:
    """Return what the motion demands of the thrusters with the effect, less without (m, 6)."""
    return demanded(packed, changed, moved) - demanded(packed, nominal, moved)


def _check_known(  # noqa: PLR0917 - one caller
    packed: PackedVehicle,
    nominal: FloatArray,
    changed: FloatArray,
    moved: MeasuredMotion,
    added: FloatArray,
    named: str,
) -> None:
    """Refuse an effect whose force is made of velocities that were not measured."""
    for axis in np.flatnonzero(~moved.measured):
        state = moved.state.copy()
        state[:, 7 + axis] += _UNKNOWN_MPS
        tried = _more_demanded(packed, nominal, changed, replace(moved, state=state))
        if _accelerating(packed, tried - added) > _MOST_UNKNOWN * _accelerating(packed, tried):
            raise CannotComputeError(
                f"{named} acts by the velocity in {('surge', 'sway', 'heave')[axis]}, which this "
                "run does not show: its force cannot be known."
            )


def _pushed(
    packed: PackedVehicle, vector: FloatArray, codes: FloatArray, moved: MeasuredMotion
) -> tuple[FloatArray, FloatArray]:
    """Wrench (m, 6) and thrusts (m, n) of codes that act."""
    return thruster_wrench(packed, codes, _flow(vector, moved), vector=vector)


def _flow(vector: FloatArray, moved: MeasuredMotion) -> FloatArray:
    """Velocity relative to the water, body axes (m, 6)."""
    flow = moved.nu.copy()
    if read(vector, "current").any():
        turn = Rotation.from_quat(moved.state[:, [4, 5, 6, 3]])
        flow[:, :3] -= turn.apply(read(vector, "current"), inverse=True)
    return flow


def layout(packed: PackedVehicle, vector: FloatArray) -> FloatArray:
    """Wrench (6, n) of a newton of each thruster, as it really points."""
    count = len(packed.thruster_names)
    one = vector.copy()
    write(one, "thrust_gain", 1.0)
    # the kernel knows the directions; a code that gives thrust shows them
    code = np.diag(0.5 * packed.code_limits[:, 1])
    wrench, thrust = thruster_wrench(packed, code, np.zeros((count, 6)), vector=one)
    return np.asarray((wrench / np.diag(thrust)[:, None]).T)


def _inverse_layout(packed: PackedVehicle, vector: FloatArray) -> FloatArray:
    """Thrusts (n, 6) for a wrench, so that as little acceleration as can be is left over."""
    weight = np.linalg.cholesky(np.linalg.inv(mass_of(packed.vector))).T
    return np.asarray(np.linalg.pinv(weight @ layout(packed, vector), rcond=1e-6) @ weight)


def _accelerating(packed: PackedVehicle, wrench: FloatArray) -> float:
    """Size of a wrench (m, 6) by the acceleration that it means: rms of F' M^-1 F [N/kg^1/2]."""
    return float(np.sqrt(np.mean(np.einsum("ki,ki->k", wrench, _solved(packed, wrench)))))


def _solved(packed: PackedVehicle, wrench: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.solve(mass_of(packed.vector), wrench.T).T)


def _acting_for(  # noqa: PLR0917 - one caller
    packed: PackedVehicle,
    vector: FloatArray,
    asked: FloatArray,
    now: FloatArray,
    acting: FloatArray,
    moved: MeasuredMotion,
) -> FloatArray:
    """Acting codes (m, n) that give the thrusts asked for, within the drives' ranges.

    A code that gives it already, `now`, stays: in a dead zone every code does. A thrust that
    changes its sign takes the code through the dead zone at once, which a short mean eases.
    """
    low = np.broadcast_to(packed.code_limits[:, 0], acting.shape).copy()
    high = np.broadcast_to(packed.code_limits[:, 1], acting.shape).copy()
    flow = _flow(vector, moved)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        _, thrust = thruster_wrench(packed, middle, flow, vector=vector)
        less = thrust < asked
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    # outside the dead zone on the side that is asked for
    found = np.where(asked > 0.0, high, low)
    largest = max(float(np.abs(packed.thrust_tables[:, :, 0]).max()), 1e-9)
    more = np.where(np.abs(asked - now) < 1e-9 * largest, 0.0, found - acting)
    eased = uniform_filter1d(more, _EASED_ROWS, axis=0, mode="nearest")
    jumps = np.abs(eased - more) > _JUMP * packed.code_limits[:, 1]
    return np.asarray(acting + np.where(jumps, eased, more))


def commanded_without_effect(
    packed: PackedVehicle, run: RunTable, thruster: str, share: float = 0.4, seed: int = 0
) -> RunTable:
    """Write commands for a thruster that stood still: in truth they had no effect.

    Every 2 s another level is drawn, of at most `share` of the drive's range. [1]

    Raises `CannotComputeError` when the thruster did not stand still.
    """
    column = packed.thruster_names.index(thruster)
    codes = np.nan_to_num(np.array(run.values["command"], float))
    vector, period = settled(packed.vector), run.period_s
    still = np.zeros((len(codes), 6))
    _, thrust = thruster_wrench(packed, lagged(vector, codes, period), still, vector=vector)
    if np.abs(thrust[:, column]).max() > 0.0:
        raise CannotComputeError(
            f"{run.name}: {thruster} gave thrust in this run, so that it cannot have had none. "
            "Choose a run in which it stood still."
        )
    held = max(round(_HELD_S / period), 1)
    generator = np.random.default_rng([seed, column])
    levels = share * generator.choice([-1.0, -0.5, 0.5, 1.0], size=len(codes) // held + 1)
    largest = np.where(levels > 0.0, packed.code_limits[column, 1], -packed.code_limits[column, 0])
    codes[:, column] = np.repeat(np.round(levels * largest), held)[: len(codes)]
    return replace(run, values=run.values | {"command": codes})
