"""Body frames in which a vehicle file may state its positions, and the way from them to SNAME.

Each frame has its axes along those of SNAME, so the way is a proper rotation C of right angles:
vectors become C v, tensors C I C^T, the sensor's mounting C R C^T. What is named by its motion
(surge, sway, heave, roll, pitch, yaw), what is a scalar and what is NED stays.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel

from pipeline.vehicle.model_schema import Matrix6, Vector6
from pipeline.vehicle.schema import Frame, Vector3, Vehicle

if TYPE_CHECKING:  # the command line answers --help without numpy
    from pipeline.types import FloatArray

#: Frame -> its axes in words.
AXES: dict[Frame, str] = {
    "sname": "x forward, y to starboard, z down",
    "paper": "x forward, y up, z to starboard",
    "ros": "x forward, y to port, z up (REP 103)",
}
Section = TypeVar("Section", bound=BaseModel)
Rows = tuple[Vector3, Vector3, Vector3]
#: What a key of the file is set to.
Change = float | str | bool | tuple[float, ...]
_MATRIX, _INERTIA = "model.added_mass.matrix", "inertia_kgm2"
_VECTORS = ("position_m", "direction", "centre_of_mass_m", "centre_of_buoyancy_m", "attachment_m")
#: Frame -> rows of C: SNAME coordinates of a vector by its stated ones.
TO_SNAME: dict[Frame, Rows] = {
    "sname": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "paper": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),
    "ros": ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)),
}


def vector_in_sname(vector: Vector3, frame: Frame) -> Vector3:
    """Turn a body vector into SNAME axes.

    1 m forward, 2 m up, 3 m to starboard in the papers' axes:

    >>> vector_in_sname((1.0, 2.0, 3.0), "paper")
    (1.0, 3.0, -2.0)
    """
    x, y, z = (
        sum(c * part for c, part in zip(row, vector, strict=True)) + 0.0 for row in TO_SNAME[frame]
    )
    return (x, y, z)


def in_sname(vehicle: Vehicle) -> Vehicle:
    """Return a vehicle, to be converted once, with every body vector and tensor in SNAME axes.

    `frame` goes on telling how the file states them.
    """
    if vehicle.frame == "sname":
        return vehicle
    parts = ("thrusters", "model", "sensors")
    changes = {name: _value(name, getattr(vehicle, name), vehicle.frame) for name in parts}
    return vehicle.model_copy(update=changes)


def _section(section: Section, frame: Frame) -> Section:
    """Return a section with what it and the sections in it state in body axes in SNAME."""
    changes = {}
    for name in type(section).model_fields:
        old = getattr(section, name)
        new = _value(name, old, frame)
        if new is not old:
            changes[name] = new
    return section.model_copy(update=changes) if changes else section


def _value(name: str, value: Any, frame: Frame) -> Any:  # noqa: ANN401 - whatever a file states
    """Return a value of a section in SNAME; the name of its key says what it is."""
    if isinstance(value, BaseModel):
        return _section(value, frame)
    if not isinstance(value, tuple):
        return value
    if value and isinstance(value[0], BaseModel):
        return tuple(_section(one, frame) for one in value)
    turned = _TURNED.get(name)
    return value if turned is None else turned(value, frame)


def changes_as_stated(changes: Mapping[str, Change], frame: Frame) -> dict[str, Change]:
    """Turn values that are to be written into a vehicle file from SNAME into its own frame.

    `changes` are new values by dotted path: whole vectors (``..._m``), the whole inertia and single
    entries of the added-mass matrix. Anything else is the same in every frame.

    >>> changes_as_stated({"model.rigid_body.centre_of_mass_m": (0.1, 0.0, 0.02)}, "paper")
    {'model.rigid_body.centre_of_mass_m': (0.1, -0.02, 0.0)}
    >>> changes_as_stated({"model.added_mass.matrix.1.5": 4.0}, "paper")
    {'model.added_mass.matrix.2.4': -4.0}
    """
    if frame == "sname":
        return dict(changes)
    rows = TO_SNAME[frame]
    found: dict[str, Change] = {}
    for path, value in changes.items():
        head, _, rest = path.partition(f"{_MATRIX}.")
        if not head and rest and isinstance(value, float):
            (row, first), (column, second) = (_stated_axis(int(i), rows) for i in rest.split("."))
            found[f"{_MATRIX}.{row}.{column}"] = first * second * value + 0.0
        elif path.rpartition(".")[2] in _VECTORS and isinstance(value, tuple):
            # the inverse of a rotation is its transpose
            columns = zip(*rows, strict=True)
            found[path] = tuple(
                sum(c * float(part) for c, part in zip(column, value, strict=True)) + 0.0
                for column in columns
            )
        elif path.endswith(f".{_INERTIA}") and isinstance(value, tuple):
            xx, yy, zz, xy, xz, yz = value
            inverse = tuple(zip(*rows, strict=True))
            found[path] = _turned((xx, yy, zz, xy, xz, yz), inverse)
        elif path.endswith(".rotation_deg") and isinstance(value, tuple):
            roll, pitch, yaw = value
            found[path] = _mounting((roll, pitch, yaw), tuple(zip(*rows, strict=True)))
        else:
            found[path] = value
    return found


def _stated_axis(index: int, rows: Rows) -> tuple[int, float]:
    """Index and sign, in the stated frame, of a force, moment or velocity 0 to 5 of SNAME."""
    half, axis = divmod(index, 3)
    stated = next(k for k, part in enumerate(rows[axis]) if part)
    return 3 * half + stated, rows[axis][stated]


def frame_shown(vehicle: Vehicle) -> tuple[str, ...]:
    """Say what `in_sname` converted, for a person to compare; empty for a file in SNAME."""
    if vehicle.frame == "sname":
        return ()
    lines = [f"frame {vehicle.frame}: {AXES[vehicle.frame]}; converted to SNAME, {AXES['sname']}:"]
    lines += [
        f"  {one.name}: position {_numbers(one.position_m)} m, direction {_numbers(one.direction)}"
        for one in vehicle.thrusters
    ]
    model, sensors = vehicle.model, vehicle.sensors
    named: dict[str, Vector3 | None] = {}
    if model is not None:
        named["centre of mass"] = model.rigid_body.centre_of_mass_m
        named["centre of buoyancy"] = model.rigid_body.centre_of_buoyancy_m
        named |= {f"payload {one.name}": one.position_m for one in model.payloads}
        named["tether"] = None if model.tether is None else model.tether.attachment_m
    if sensors is not None:
        parts = {"imu": sensors.imu, "dvl": sensors.dvl, "depth": sensors.depth}
        named |= {name: None if one is None else one.position_m for name, one in parts.items()}
    lines += [f"  {name}: {_numbers(place)} m" for name, place in named.items() if place]
    if sensors is not None and sensors.dvl is not None and any(sensors.dvl.rotation_deg):
        lines.append(f"  dvl: rotation {_numbers(sensors.dvl.rotation_deg)} deg")
    return tuple(lines)


def _numbers(values: Sequence[float]) -> str:
    return f"[{', '.join(f'{value + 0.0:.6g}' for value in values)}]"


def rotation_in_sname(rotation_deg: Vector3, frame: Frame) -> Vector3:
    """Turn a mounting (roll, pitch, yaw in degrees, as yaw, then pitch, then roll) into SNAME.

    The sensor's own axes are taken to be of the stated frame, too: at zero they are the body's.

    A sensor turned to port by 30 degrees, about the upward z of REP 103:

    >>> rotation_in_sname((0.0, 0.0, 30.0), "ros")
    (0.0, 0.0, -30.0)
    """
    return _mounting(rotation_deg, TO_SNAME[frame])


def _mounting(rotation_deg: Vector3, rows: Sequence[Sequence[float]]) -> Vector3:
    """Angles of C R C^T for a mounting R, `rows` those of C."""
    import numpy as np

    if not any(rotation_deg):
        return rotation_deg
    roll, pitch, yaw = np.radians(rotation_deg)
    turn = _about(2, yaw) @ _about(1, pitch) @ _about(0, roll)
    c = np.array(rows)
    r = c @ turn @ c.T
    angles = (
        math.atan2(r[2, 1], r[2, 2]),
        math.asin(max(-1.0, min(1.0, -r[2, 0]))),
        math.atan2(r[1, 0], r[0, 0]),
    )
    x, y, z = (round(math.degrees(angle), 10) + 0.0 for angle in angles)
    return (x, y, z)


def _about(axis: int, angle_rad: float) -> "FloatArray":
    """Rotation (3, 3) about an axis."""
    import numpy as np

    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = math.cos(angle_rad)
    turn[j, i], turn[i, j] = math.sin(angle_rad), -math.sin(angle_rad)
    return turn


def _turned(inertia_kgm2: Vector6, rows: Sequence[Sequence[float]]) -> Vector6:
    """C I C^T of an inertia, `rows` those of C."""
    import numpy as np

    xx, yy, zz, xy, xz, yz = inertia_kgm2
    c = np.array(rows)
    tensor = c @ np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]]) @ c.T
    (a, d, e), (_, b, f), (_, _, g) = (tensor + 0.0).tolist()
    return (a, b, g, -d + 0.0, -e + 0.0, -f + 0.0)


def _matrix(matrix: Matrix6, frame: Frame) -> Matrix6:
    """Turn a matrix of forces and moments (X, Y, Z, K, M, N of the frame) by velocities."""
    import numpy as np

    both = np.kron(np.eye(2), np.array(TO_SNAME[frame]))
    a, b, c, d, e, f = (tuple(row) for row in (both @ np.array(matrix) @ both.T + 0.0).tolist())
    return (a, b, c, d, e, f)


def _inertia(inertia_kgm2: tuple[float, ...], frame: Frame) -> tuple[float, ...]:
    """Turn three moments of inertia, or six entries, into SNAME."""
    xx, yy, zz, xy, xz, yz = (*inertia_kgm2, 0.0, 0.0, 0.0)[:6]
    return _turned((xx, yy, zz, xy, xz, yz), TO_SNAME[frame])[: len(inertia_kgm2)]


#: Key of a section -> what turns its value, where that is a tuple.
_TURNED: dict[str, Callable[[Any, Frame], Any]] = {
    **dict.fromkeys(_VECTORS, vector_in_sname),
    "rotation_deg": rotation_in_sname,
    _INERTIA: _inertia,
    "matrix": _matrix,
}
