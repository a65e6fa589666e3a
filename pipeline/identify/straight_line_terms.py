"""The terms that the slope of acceleration against thrust leaves out, as regressors."""

from collections.abc import Collection

import numpy as np

from pipeline.identify.channel_noise import was_measured
from pipeline.physics.parameters import read
from pipeline.records.run_components import down_axis
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray

WEIGHT, WALLS = "weight along the axis", "nearness of walls x thrust"
#: Units of the coefficients that are no plain ratio.
UNITS = {
    "linear drag": "1/s",
    "quadratic drag": "1/m",
    WEIGHT: "m/s^2",
    WALLS: "1/kg",
}
#: A regressor counts if at least this share of it is not in the others already.
OWN_SHARE = 0.02
#: Largest coefficients to expect: of rotation (m + A_jj) / (m + A_ii), of the weight along the axis
#: (W - B) / M at 2 % residual buoyancy [m/s^2]. Drag and walls are always asked for.
_LARGEST = {"rotation": 3.0, "weight": 0.2}
#: A term that at its largest moves the acceleration by less than this share of its noise is left
#: out: its coefficient could only be noise.
_NOTICEABLE = 0.1

_ROTATION = (
    (("sway speed x yaw rate", 1, 2, 1.0), ("heave speed x pitch rate", 2, 1, -1.0)),
    (("surge speed x yaw rate", 0, 2, -1.0), ("heave speed x roll rate", 2, 0, 1.0)),
    (("sway speed x roll rate", 1, 0, -1.0), ("surge speed x pitch rate", 0, 1, 1.0)),
)


def omitted_terms(
    packed: PackedVehicle,
    run: RunTable,
    velocity: FloatArray,
    thrust: FloatArray,
    along: int,
) -> dict[str, FloatArray]:
    """Return the regressors (m,) of one axis at every sample of a run.

    Rotation: the parts of -(omega x v), each with its own coefficient, as the added masses of the
    other axes are not this one's. Drag: -v and -v|v|. Buoyancy: the component of "down" along the
    axis. Walls: the nearness sum (R / distance)^3 times the thrust, where the vehicle file states
    walls and the run has a position: 1 / (m + A (1 + c s)) is 1 / M - s c A / M^2 to first order.
    `velocity` (m, 3) is that of the body origin [m/s], `thrust` (m,) goes along the axis [N].
    """
    omega = np.nan_to_num(run.values["angular_velocity"])
    v = velocity[:, along]
    terms = {
        name: sign * velocity[:, speed] * omega[:, rate]
        for name, speed, rate, sign in _ROTATION[along]
    }
    terms["linear drag"] = -v
    terms["quadratic drag"] = -v * np.abs(v)
    if was_measured(run, "attitude"):
        terms[WEIGHT] = down_axis(np.nan_to_num(run.values["attitude"]))[:, along]
    walls = int(read(packed.vector, "wall_count"))
    if walls and was_measured(run, "position"):
        points = read(packed.vector, "wall_point")[:walls]
        normals = read(packed.vector, "wall_normal")[:walls]
        radius = float(read(packed.vector, "wall_radius"))
        place = np.nan_to_num(run.values["position"])
        distance = np.einsum("mkj,kj->mk", place[:, None, :] - points, normals)
        near = np.sum((radius / np.maximum(distance, radius)) ** 3, axis=1)
        # a vehicle beyond a wall: the walls of the file are not those of this run
        if distance[run.valid["position"]].min(initial=np.inf) > 0.0:
            terms[WALLS] = near * thrust
    return terms


def terms_known(run: RunTable, terms: Collection[str]) -> BoolArray:
    """Rows (m,) of a run at which all that terms of `omitted_terms` are made of is known.

    Elsewhere a term holds zeros in place of readings, and whatever is taken over such a row is not
    to be used.
    """
    known = run.valid["angular_velocity"]
    for name, quantity in ((WEIGHT, "attitude"), (WALLS, "position")):
        if name in terms:
            known = known & run.valid[quantity]
    return known


def usable_terms(
    thrust: FloatArray, terms: dict[str, FloatArray], acceleration_noise: float
) -> tuple[str, ...]:
    """Names of the terms that vary enough to be seen, and not only together with the others.

    A term enters if at least `OWN_SHARE` of its variation is left after the thrust, a constant and
    the terms before it are taken out, and if it could move the acceleration noticeably. Terms (m,)
    are filtered as the acceleration, whose noise is in m/s^2.
    """
    columns = [thrust, np.ones_like(thrust)]
    used = []
    for name, signal in terms.items():
        varies = float(np.linalg.norm(signal - signal.mean()))
        kind = "rotation" if " rate" in name else "weight" if "weight" in name else ""
        largest = _LARGEST.get(kind, np.inf) * varies / np.sqrt(max(signal.size, 1))
        if varies <= 1e-9 * max(float(np.linalg.norm(signal)), 1e-9):
            continue
        if largest < _NOTICEABLE * acceleration_noise:
            continue
        basis, _ = np.linalg.qr(np.column_stack(columns))
        rest = signal - basis @ (basis.T @ signal)
        if float(np.linalg.norm(rest)) > OWN_SHARE * varies:
            used.append(name)
            columns.append(signal)
    return tuple(used)
