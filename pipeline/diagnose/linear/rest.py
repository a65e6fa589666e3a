r"""The rest: forces that a real vehicle has and its file lacks, linear in physical features.

.. math:: f_a = c_a + (R^T e)_a + \sum_i g_{ai} T_i + l_a \dot{\tau}_a
          - \sum_{b \ne a} D_{ab} \nu_b

by axis a: a constant in the body (ballast, a camera's wash) and in the earth (a cable, the water),
a share of each thruster's thrust that goes elsewhere than its lever says, what of the thrust is
late, and damping that couples axes. What the vehicle file can say itself (damping along an axis,
masses, trim, the scale of all thrusters) is no rest.

Which of it a vehicle has is learned from its sound runs (`reference.learn`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.physics.parameters import read
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.kernel import BODY
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray, IntArray

#: Speed at which damping is compared with damping. [m/s, rad/s]
_USUAL_SPEED = 0.3
#: Share of a typical lever below which a thruster has none on an axis.
_NO_LEVER = 0.1
#: By how much late thrust counts as one unit. [s]
_LATE_S = 0.1


@dataclass(frozen=True)
class RestTerm:
    """One force of the rest: its kind, the axis it acts along, and what it goes with.

    `axis` and `column` are indices of SNAME axes or of a thruster; -1 where there is none. `unit`
    is the coefficient that counts as 1, in the SI unit of the kind.
    """

    kind: str
    axis: int
    column: int
    unit: float

    @property
    def group(self) -> tuple[str, int]:
        """Terms that are believed to be alike before the runs are seen."""
        return self.kind, self.axis


@dataclass(frozen=True)
class RestForces:
    """Forces of unit terms by piece, (windows, 6 pieces, k), in units of the outside force."""

    terms: tuple[RestTerm, ...]
    shape: FloatArray

    @property
    def size(self) -> int:
        """Number of terms."""
        return len(self.terms)

    def of(self, values: FloatArray) -> FloatArray:
        """Sum up the forces (windows, 6 pieces) of some coefficients (k,)."""
        return np.asarray(self.shape @ values)


def no_rest(windows: int, pieces: int) -> RestForces:
    """Return a rest without terms."""
    return RestForces((), np.zeros((windows, 6 * pieces, 0)))


def rest_terms(packed: PackedVehicle, force_unit: FloatArray) -> tuple[RestTerm, ...]:
    """List the terms of a vehicle.

    Parameters
    ----------
    packed : PackedVehicle
        The nominal vehicle.
    force_unit : ndarray, shape (6,)
        What counts as one unit of a constant force. [N, N m]
    """
    count = len(packed.thruster_names)
    lever = _levers(packed)
    vector = packed.vector
    damping = np.diag(read(vector, "linear_damping")) + _USUAL_SPEED * read(
        vector, "quadratic_damping"
    )
    damping = np.maximum(damping, force_unit / _USUAL_SPEED)
    found = [RestTerm("constant", axis, -1, float(force_unit[axis])) for axis in range(6)]
    found += [RestTerm("earth", -1, axis, float(force_unit[:3].mean())) for axis in range(2)]
    direction = read(vector, "thruster_direction")[:count]
    place = read(vector, "thruster_position")[:count]
    own = np.concatenate([direction, np.cross(place, direction)], axis=1)
    # along its own lever a thruster that is off is a weak or a strong one
    found += [
        RestTerm("thrust", axis, thruster, float(lever[axis]))
        for axis in range(6)
        for thruster in range(count)
        if abs(own[thruster, axis]) < _NO_LEVER * lever[axis]
    ]
    found += [RestTerm("late", axis, -1, _LATE_S) for axis in range(6)]
    found += [
        RestTerm("damping", a, b, float(np.sqrt(damping[a] * damping[b])))
        for a in range(6)
        for b in range(6)
        if a != b
    ]
    return tuple(found)


def rest_forces(  # noqa: PLR0917 - one caller
    packed: PackedVehicle,
    terms: Sequence[RestTerm],
    state: FloatArray,
    steps_s: FloatArray,
    bounds: IntArray,
    force_unit: FloatArray,
    windows: int,
) -> RestForces:
    """Compute the forces of unit terms along a motion, averaged over its pieces.

    Parameters
    ----------
    packed : PackedVehicle
        The nominal vehicle: its thrust is what the terms share out.
    terms : sequence of RestTerm
        As `rest_terms` lists them.
    state : ndarray, shape (steps, STATE)
        The motion at the begin of each step.
    steps_s : ndarray, shape (steps,)
        Length of each step. [s]
    bounds : ndarray, shape (pieces + 1,)
        Steps at which the pieces of all windows begin, and the end.
    force_unit : ndarray, shape (6,)
        [N, N m]
    windows : int
        Number of windows: each has as many pieces as the others.
    """
    count = len(packed.thruster_names)
    known: BoolArray = np.asarray(np.isfinite(state).all(axis=1))
    state = np.where(known[:, None], state, 0.0)
    nu = state[:, 7:13]
    wrench, thrust = thruster_wrench(
        packed, np.ascontiguousarray(state[:, BODY : BODY + count]), np.zeros((len(state), 6))
    )
    turn = Rotation.from_quat(
        np.where(known[:, None], state[:, [4, 5, 6, 3]], [0.0, 0.0, 0.0, 1.0])
    ).inv()
    lengths = np.diff(bounds)
    piece = np.repeat(np.arange(lengths.size), lengths)
    # the window's first step has no step before it
    rate = np.zeros_like(wrench)
    rate[1:] = np.diff(wrench, axis=0) / steps_s[1:, None]
    per_window = lengths.size // windows
    rate[bounds[:-1][::per_window]] = 0.0

    def mean(values: FloatArray) -> FloatArray:
        total = np.zeros((lengths.size, *values.shape[1:]))
        np.add.at(total, piece, values)
        return np.asarray(total / np.maximum(lengths, 1).reshape(-1, *[1] * (values.ndim - 1)))

    thrusts, rates, speeds = mean(thrust), mean(rate), mean(nu)
    earth = [mean(turn.apply(np.eye(3)[axis])) for axis in range(2)]
    shape = np.zeros((lengths.size, 6, len(terms)))
    for k, term in enumerate(terms):
        if term.kind == "constant":
            shape[:, term.axis, k] = term.unit
        elif term.kind == "earth":
            shape[:, :3, k] = term.unit * earth[term.column]
        elif term.kind == "thrust":
            shape[:, term.axis, k] = term.unit * thrusts[:, term.column]
        elif term.kind == "late":
            shape[:, term.axis, k] = -term.unit * rates[:, term.axis]
        else:
            shape[:, term.axis, k] = -term.unit * speeds[:, term.column]
    shape /= force_unit[:, None]
    return RestForces(tuple(terms), shape.reshape(windows, 6 * per_window, len(terms)))


def _levers(packed: PackedVehicle) -> FloatArray:
    """By how many N or N m a newton of thrust counts as one unit on each axis (6,)."""
    count = len(packed.thruster_names)
    place = read(packed.vector, "thruster_position")[:count]
    size = float(np.sqrt((place**2).sum(axis=1).mean())) if count else 0.1
    return np.concatenate([np.ones(3), np.full(3, max(size, 0.05))])
