"""What a bench leaves uncertain of a thruster beside its scale: both signs, shape, transients.

A stated thrust uncertainty is one factor. The two signs of a thruster are measured apart, each with
an error of its own. Near the dead zone, and while the code changes, the thrust of a healthy
thruster differs from its static characteristic by more: friction sticks, and the wash takes time.
Forces of that kind are unknowns of every diagnosis, so that they are not taken for a fault.
"""

from collections.abc import Sequence

import numpy as np

from pipeline.identify.windows import Window
from pipeline.physics.parameters import read
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.kernel import BODY
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pieces import Pieces, run_pieces
from pipeline.types import FloatArray

#: Codes over the largest at which the curve may be off, and by how much of the largest thrust.
KNOTS = (0.1, 0.3, 0.6)
KNOT_SHARE = 0.005
#: Standard deviation of the lag of thrust, as a share of the stated one.
LAG_SHARE = 0.3
#: Of two signs with an error of their own each, half the difference: over the error.
_HALF_DIFFERENCE = 0.5**0.5


def characteristic_profiles(
    packed: PackedVehicle, windows: Sequence[Window], pieces: Pieces, thrust_share: float
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
    thrust_share : float
        Stated standard uncertainty of thrust.
    """
    count = len(packed.thruster_names)
    starts = np.stack([window.start for window in windows])
    states, _ = run_pieces(
        packed, pieces, packed.vector, starts, np.zeros((len(pieces.commands), 6))
    )
    steps = np.arange(len(pieces.commands))
    window_of = np.searchsorted(pieces.bounds, steps, "right") - 1
    actuator = np.nan_to_num(states[steps + window_of, BODY : BODY + count])
    largest = read(packed.vector, "code_max")[:count]
    still = np.zeros((len(steps), 6))
    level = np.abs(pieces.commands) / largest
    sign = np.sign(pieces.commands)
    found = []
    unit = _unit_wrenches(packed)
    most = float(packed.thrust_tables[:, :, 0].max())
    for number, knot in enumerate(KNOTS):
        left = KNOTS[number - 1] if number else 0.0
        right = KNOTS[number + 1] if number + 1 < len(KNOTS) else 1.0
        size = np.interp(level, [left, knot, right], [0.0, 1.0, 0.0 if right < 1.0 else 1.0])
        found.append(KNOT_SHARE * most * (sign * size) @ unit)
    reached, thrust = thruster_wrench(packed, actuator, still)
    found.extend(
        _HALF_DIFFERENCE * thrust_share * np.abs(thrust[:, [i]]) * unit[i] for i in range(count)
    )
    in_time = bool((read(packed.vector, "rotor_inertia")[:count] > 0.0).any())
    if not in_time and bool((read(packed.vector, "lag")[:count] > 0.0).any()):
        wanted, _ = thruster_wrench(packed, pieces.commands, still)
        found.append(LAG_SHARE * (wanted - reached))
    return np.stack(found, axis=2)


def _unit_wrenches(packed: PackedVehicle) -> FloatArray:
    """Force and moment of one newton of each thruster (n, 6)."""
    count = len(packed.thruster_names)
    direction = read(packed.vector, "thruster_direction")[:count]
    place = read(packed.vector, "thruster_position")[:count]
    return np.concatenate([direction, np.cross(place, direction)], axis=1)
