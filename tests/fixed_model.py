"""A model of what the fixed-point firmware makes of a code, to the bit; a module of the tests."""

import numpy as np
import numpy.typing as npt

from pipeline.export.fixed_point import (
    Q16_ONE,
    FixedBranch,
    FixedTables,
    IntLike,
    _along,
    _at,
    _between,
    _locate,
    _ratio,
    _row_at,
)
from pipeline.types import IntArray


def _drag_at(branch: FixedBranch, speed: IntArray) -> IntArray:
    """Drag of the undriven propeller at speeds of either sign."""
    knots = np.broadcast_to(branch.speed_q16, (len(speed), len(branch.speed_q16)))
    return _at(branch.drag_q16, _locate(knots, np.abs(speed)))


def thrust_from_code(
    tables: FixedTables, code: IntLike, speed_q16: IntLike
) -> npt.NDArray[np.int64]:
    """Do what ``<vehicle>_thrust_from_code_q`` does, to the bit.

    Parameters
    ----------
    tables : FixedTables
        The tables in the C source.
    code, speed_q16 : int or ndarray of int, broadcast together
        Arguments of the C function: an int16_t, and an int32_t in Q16.16. [-], [m/s]

    Returns
    -------
    ndarray of int64
        Thrust in Q16.16; inside the dead zone the drag's share. [N]
    """
    held = np.maximum(np.asarray(code, np.int64), tables.code_min)
    codes, speed = np.broadcast_arrays(held, np.asarray(speed_q16, np.int64))
    thrust = np.zeros(codes.shape, np.int64)
    for sign, branch in ((1, tables.positive), (-1, tables.negative)):
        mask = (sign * codes > 0) | ((codes == 0) & (sign * speed > 0))
        along, size = _along(speed[mask], sign), sign * codes[mask] * Q16_ONE
        largest, knots = _row_at(branch, along)
        place = _locate(knots, size)
        fraction = _between(
            branch.fraction_q30[place.low], branch.fraction_q30[place.high], place.share
        )
        driven, drag = (
            _between(np.zeros_like(largest), largest, fraction),
            _drag_at(branch, speed[mask]),
        )
        edge = knots[:, 0]
        inside = size < edge
        share = _ratio(np.where(inside, size, 0), np.maximum(edge, 1))
        dragged = np.where(inside, -_between(drag, np.zeros_like(drag), share), driven)
        thrust[mask] = sign * np.where(along > 0, dragged, np.maximum(driven, drag))
    return thrust


def thrust_limit(tables: FixedTables, speed_q16: IntLike, *, sign: int) -> npt.NDArray[np.int64]:
    """Do what ``<vehicle>_thrust_max_q`` (sign 1) and ``_min_q`` (sign -1) do, to the bit."""
    speed = np.asarray(speed_q16, np.int64)
    if sign < 0:
        along, rest = (thrust_from_code(tables, tables.code_min, v) for v in (-np.abs(speed), 0))
        return np.minimum(np.where(speed > 0, np.maximum(along, rest), along), 0)
    size = np.abs(speed).reshape(-1)
    limit, at_rest = (
        _row_at(tables.positive, v)[0].reshape(speed.shape) for v in (size, np.zeros_like(size))
    )
    return np.where(speed < 0, np.minimum(limit, at_rest), limit)
