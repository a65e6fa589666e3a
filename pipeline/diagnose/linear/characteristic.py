"""What a bench leaves uncertain of a thruster beside its scale: both signs, shape, transients.

A stated thrust uncertainty is one factor. The two signs of a thruster are measured apart, each with
an error of its own. Near the dead zone, and while the code changes, the thrust of a healthy
thruster differs from its static characteristic by more: friction sticks, and the wash takes time.
Forces of that kind are unknowns of every diagnosis, so that they are not taken for a fault.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.identify.windows import Window
from pipeline.physics.parameters import read
from pipeline.simulate.applied_wrench import levers, thruster_wrench
from pipeline.simulate.kernel import BODY
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pieces import Pieces, run_pieces
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import FromBollard
from pipeline.vehicle.schema import Vehicle

#: Codes over the largest at which the curve may be off, of each sign by itself.
KNOTS = (0.07, 0.16, 0.35, 0.7)
#: By how much of the largest thrust: of a curve from the bench's own tables, and of a formula with
#: one dead zone and one exponent for both signs. Fitted to a measured thruster it leaves an rms of
#: 1 % (docs/vehicles.md, rov8); most of that is next to the dead zone.
TABLE_SHARE, FORMULA_SHARE = 0.005, 0.007
#: Standard deviation of the lag of thrust, as a share of the stated one.
LAG_SHARE = 0.3
#: Of two signs with an error of their own each, half the difference: over the error.
_HALF_DIFFERENCE = 0.5**0.5


@dataclass(frozen=True)
class CurveErrors:
    """By how much the curves of the thrusters may be off.

    `shape` (n,) at a knot, of the largest thrust of each; `scale` of the thrust, as stated.
    """

    shape: FloatArray
    scale: float


def curve_errors(vehicle: Vehicle, thrust_share: float) -> CurveErrors:
    """By how much the curves of a vehicle's thrusters may be off.

    Parameters
    ----------
    vehicle : Vehicle
        A formula leaves more than the bench's own tables.
    thrust_share : float
        Stated standard uncertainty of thrust.
    """
    stated = {} if vehicle.model is None else vehicle.model.thrusters

    def share(drive: str) -> float:
        of_drive = stated.get(drive)
        formula = of_drive is not None and isinstance(of_drive.characteristic, FromBollard)
        return FORMULA_SHARE if formula else TABLE_SHARE

    shape = np.array([share(thruster.drive) for thruster in vehicle.thrusters])
    return CurveErrors(shape, thrust_share)


def characteristic_profiles(
    packed: PackedVehicle,
    windows: Sequence[Window],
    pieces: Pieces,
    errors: CurveErrors,
) -> FloatArray:
    """Compute forces (steps, 6, k) of one standard deviation of each unknown of the characteristic.

    Parameters
    ----------
    packed : PackedVehicle
        The nominal vehicle.
    windows : sequence of Window
        With their starts.
    pieces : Pieces
        The windows as stretches.
    errors : CurveErrors
        Of the vehicle's thrusters.
    """
    count = len(packed.thruster_names)
    starts = np.stack([window.start for window in windows])
    states, _ = run_pieces(
        packed, pieces, packed.vector, starts, np.zeros((len(pieces.commands), 6))
    )
    steps = np.arange(len(pieces.commands))
    window_of = np.searchsorted(pieces.bounds, steps, "right") - 1
    actuator = np.nan_to_num(states[steps + window_of, BODY : BODY + count])
    still = np.zeros((len(steps), 6))
    unit = levers(packed).T
    in_time = bool((read(packed.vector, "rotor_inertia")[:count] > 0.0).any())
    # what turns in time has shaft speeds for states
    code = pieces.commands if in_time else actuator
    found = _off_the_curve(packed, code, errors.shape, unit)
    reached, thrust = thruster_wrench(packed, actuator, still)
    found.extend(
        _HALF_DIFFERENCE * errors.scale * np.abs(thrust[:, [i]]) * unit[i] for i in range(count)
    )
    if not in_time and bool((read(packed.vector, "lag")[:count] > 0.0).any()):
        wanted, _ = thruster_wrench(packed, pieces.commands, still)
        found.append(LAG_SHARE * (wanted - reached))
    return np.stack(found, axis=2)


def _off_the_curve(
    packed: PackedVehicle, code: FloatArray, shape_share: FloatArray, unit: FloatArray
) -> list[FloatArray]:
    """Compute forces (steps, 6) of a curve that is off at one knot, by kind and sign."""
    count = len(packed.thruster_names)
    level = np.abs(code) / read(packed.vector, "code_max")[:count]
    kinds = read(packed.vector, "thruster_type")[:count].astype(int)
    found = []
    for kind in np.unique(kinds):
        own = np.flatnonzero(kinds == kind)
        for side, sign in enumerate((1.0, -1.0)):
            most = float(packed.thrust_tables[kind, side, 0].max())
            driven = np.where(sign * code[:, own] > 0.0, sign, 0.0)
            for one in np.eye(len(KNOTS)):
                # a hat; the last one goes on to the largest code
                size = np.interp(level[:, own], (0.0, *KNOTS), (0.0, *one))
                found.append((shape_share[own] * most * driven * size) @ unit[own])
    return found
