"""The generated C self-test: the double-precision reference and how far C may be from it.

The reference is `pipeline.physics.thrust_grid` evaluated in double precision at speeds and thrusts
that both C variants take without rounding (multiples of 2^-16).
"""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.control.inverse import thrust_grid
from pipeline.export import c_text
from pipeline.export.c_source import Identity, render
from pipeline.export.fixed_point import Q16_ONE
from pipeline.export.grid_check import LARGEST_CODE
from pipeline.physics.thrust_grid import (
    ThrustGrid,
    code_from_thrust,
    thrust_from_code,
    thrust_limits,
)
from pipeline.records.fits import FirmwareCharacteristic
from pipeline.types import FloatArray, IntArray

#: Up to this largest code every code is tested, above it evenly spaced ones.
EVERY_CODE_UP_TO = 255
#: Thrusts of each sign on the grid of the inverse, up to 1.1 T_max.
_THRUSTS = 45
_SINGLE_EPSILON = 2.0**-23
_Q16_STEP = 2.0**-16
#: Ends of int32, the same with either sign: what is beyond them cannot be asked of the _q variant.
_LARGEST_INT32 = 2**31 - 1
_Q30_STEP = 2.0**-30


@dataclass(frozen=True)
class Tolerances:
    """How far the C variants may be from real arithmetic; codes before they are rounded.

    Derived from the tables, not from what the code was seen to do: each number that is rounded
    on the way counts with one step of its format, times how strongly it acts on the result.
    """

    thrust_single_n: float
    thrust_fixed_n: float
    code_single: float
    code_fixed: float

    @property
    def trip_single(self) -> float:
        """Code to thrust to code: both ways, the thrust between them, and the last rounding."""
        return max(1.0, 0.5 + 3.0 * self.code_single)

    @property
    def trip_fixed(self) -> float:
        """The same in fixed point."""
        return max(1.0, 0.5 + 3.0 * self.code_fixed)


@dataclass(frozen=True)
class ReferenceGrid:
    """Reference on two grids: thrust over (speed, code), code over (speed, thrust)."""

    speed_q16: IntArray
    code: IntArray
    thrust_n: FloatArray
    thrust_q16: IntArray
    unrounded_code: FloatArray
    thrust_max_n: FloatArray
    thrust_min_n: FloatArray


def reference(characteristic: FirmwareCharacteristic) -> ReferenceGrid:
    """Evaluate the double-precision characteristic on the self-test's grids.

    Speeds are the tabulated ones of both signs, one between each two of them and one beyond each
    end; codes are all there are, or about 250 evenly spaced ones where there are more.
    """
    positive = thrust_grid(characteristic.positive)
    negative = thrust_grid(characteristic.negative)
    speed_q16 = _speeds(positive, negative)
    speed = speed_q16[:, None] / Q16_ONE
    code_min = characteristic.code_min
    code = _codes(positive, negative, code_min)
    thrust_n = thrust_from_code(
        code[None, :].astype(np.float64), speed, positive=positive, negative=negative
    )
    thrust_q16 = _thrusts(positive, negative, characteristic.thrust_dead_n)
    unrounded = code_from_thrust(
        thrust_q16[None, :] / Q16_ONE,
        speed,
        positive=positive,
        negative=negative,
        thrust_dead_n=characteristic.thrust_dead_n,
    )
    largest, smallest = thrust_limits(
        speed[:, 0], positive=positive, negative=negative, code_min=code_min
    )
    return ReferenceGrid(
        speed_q16=speed_q16,
        code=code,
        thrust_n=thrust_n,
        thrust_q16=thrust_q16,
        unrounded_code=np.maximum(unrounded, code_min),
        thrust_max_n=largest,
        thrust_min_n=smallest,
    )


def _speeds(positive: ThrustGrid, negative: ThrustGrid) -> IntArray:
    knots = np.unique(np.concatenate((-negative.speed_mps, positive.speed_mps)))
    between = (knots[:-1] + knots[1:]) / 2
    beyond = np.array([knots[0] - 1.0, knots[-1] + 1.0])
    speeds = np.concatenate((knots, between, beyond))
    return np.unique(_q16(speeds))


def _q16(values: FloatArray) -> IntArray:
    scaled = np.rint(values * Q16_ONE)
    return np.clip(scaled, -_LARGEST_INT32, _LARGEST_INT32).astype(np.int64)


def _codes(positive: ThrustGrid, negative: ThrustGrid, code_min: int) -> IntArray:
    signed = []
    for sign, grid, end in ((-1, negative, -code_min), (1, positive, LARGEST_CODE)):
        # Beyond the last code of a row there is nothing to invert; the edge cases cover it.
        largest = min(max(int(grid.code[:, -1].min()), 1), end)
        step = 1 if largest <= EVERY_CODE_UP_TO else math.ceil(largest / (EVERY_CODE_UP_TO // 2))
        signed.append(sign * np.append(np.arange(1, largest, step), largest))
    return np.unique(np.concatenate((*signed, [0])).astype(np.int64))


def _thrusts(positive: ThrustGrid, negative: ThrustGrid, dead_n: float) -> IntArray:
    dead = math.floor(dead_n * Q16_ONE)
    grids = []
    for sign, grid in ((-1, negative), (1, positive)):
        even = _q16(np.linspace(0.0, 1.1 * float(grid.thrust_max_n.max()), _THRUSTS + 1)[1:])
        grids.append(sign * np.concatenate((even, [dead, dead + 1])))
    return np.unique(np.concatenate((*grids, [0])).astype(np.int64))


def tolerances(characteristic: FirmwareCharacteristic) -> Tolerances:
    """Bound the rounding of both variants, cell by cell of the tables, and take the largest.

    With one step s (2^-16) or relative step e (2^-23), thrust T, speed V, code N, a = |dT/dN| [N],
    b = |dN/dT| [1/N] and c = |dT/dV| [N s/m] over the whole tables:

    fixed point: thrust s (2 + 2 a + c); single precision: thrust e (4 T + 4 a N + c V).

    The bounds of the codes are those of `_code_errors`: b is large where c is small, near the dead
    zone, so the product of their largest values would say nothing.
    """
    grids = (thrust_grid(characteristic.positive), thrust_grid(characteristic.negative))
    slopes = [_slopes(grid) for grid in grids]
    newtons_per_code = max(slope[0] for slope in slopes)
    newtons_per_speed = max(slope[1] for slope in slopes)
    thrust = max(float(grid.thrust_max_n.max()) for grid in grids)
    speed = max(float(grid.speed_mps[-1]) for grid in grids)
    code = max(float(grid.code.max()) for grid in grids)
    along = newtons_per_speed * speed
    code_fixed, code_single = (
        max(errors) for errors in zip(*map(_code_errors, grids), strict=True)
    )
    return Tolerances(
        thrust_single_n=_SINGLE_EPSILON * (4 * thrust + 4 * newtons_per_code * code + along),
        thrust_fixed_n=_Q16_STEP * (2 + 2 * newtons_per_code + newtons_per_speed),
        code_single=code_single,
        code_fixed=code_fixed,
    )


def _slopes(grid: ThrustGrid) -> tuple[float, float]:
    """Return bounds of |dT/dN| and |dT/dV|, also between the tabulated speeds."""
    fractions = np.diff(grid.fraction)
    codes = np.diff(grid.code, axis=1)
    newtons_per_code = float((fractions * grid.thrust_max_n.max() / codes.min(axis=0)).max())
    if len(grid.speed_mps) == 1:
        return newtons_per_code, 0.0
    width = np.diff(grid.speed_mps)
    drag_per_code = float((grid.drag_at(grid.speed_mps) / np.maximum(grid.code[:, 0], 1e-9)).max())
    drag_per_speed = float((np.diff(grid.drag_at(grid.speed_mps)) / width).max())
    newtons_per_code = max(newtons_per_code, drag_per_code)
    by_limit = np.abs(np.diff(grid.thrust_max_n)) / width
    by_code = newtons_per_code * np.abs(np.diff(grid.code, axis=0)).max(axis=1) / width
    return newtons_per_code, float((by_limit + by_code).max()) + drag_per_speed


def _code_errors(grid: ThrustGrid) -> tuple[float, float]:
    """Bound the error of code from thrust in fixed point and in single precision.

    Between two speeds and two fractions, with f the fraction, N' = dN/df, N_V = dN/dV at equal f
    and T_V = dT_max/dV, each the largest in the cell:

    fixed point: s (2 + N_V) + N' / T_max (s (2 + f T_V) + 2^-29 T_max): two steps of code, one of
    speed, one each of thrust and T_max, and two of the fraction (2^-30);
    single precision: e (4 N + N_V V + N' f (4 + T_V V / T_max)).
    """
    speed, largest, fraction = grid.speed_mps, grid.thrust_max_n, grid.fraction[1:]
    per_fraction = np.diff(grid.code, axis=1) / np.diff(grid.fraction)
    code, fastest, smallest = grid.code[:, 1:], speed[:, None], largest[:, None]
    code_per_speed, thrust_per_speed = np.zeros_like(per_fraction), np.zeros((1, 1))
    if len(speed) > 1:
        width = np.diff(speed)[:, None]
        per_fraction = np.maximum(per_fraction[:-1], per_fraction[1:])
        by_column = np.abs(np.diff(grid.code, axis=0)) / width
        code_per_speed = np.maximum(by_column[:, :-1], by_column[:, 1:])
        thrust_per_speed = np.abs(np.diff(largest))[:, None] / width
        code, fastest = np.maximum(code[:-1], code[1:]), fastest[1:]
        smallest = np.minimum(largest[:-1], largest[1:])[:, None]
    newtons = _Q16_STEP * (2 + fraction * thrust_per_speed) + 2 * _Q30_STEP * smallest
    fixed = _Q16_STEP * (2 + code_per_speed) + per_fraction / smallest * newtons
    relative = 4 + thrust_per_speed * fastest / smallest
    single = _SINGLE_EPSILON * (
        4 * code + code_per_speed * fastest + per_fraction * fraction * relative
    )
    return float(fixed.max()), float(single.max())


def render_self_test(identity: Identity, characteristic: FirmwareCharacteristic) -> str:
    """Return the text of ``<vehicle>_thruster_self_test.c``, a program that returns 0 or 1."""
    grid = reference(characteristic)
    limits = tolerances(characteristic)

    def array(ctype: str, name: str, values: FloatArray | IntArray, comment: str) -> str:
        rows = values.reshape(1, -1) if values.ndim == 1 else values
        titles = [""] if values.ndim == 1 else [f"at {v / Q16_ONE:g} m/s" for v in grid.speed_q16]
        literals = [
            [str(v) if isinstance(v, int) else c_text.double_literal(round(v, 9)) for v in row]
            for row in rows.tolist()
        ]
        return c_text.c_array(
            ctype, name, list(zip(titles, literals, strict=True)), comment=comment
        )

    return render(
        "self_test.c.j2",
        identity,
        every_code=max(characteristic.code_max, -characteristic.code_min) <= EVERY_CODE_UP_TO,
        speeds=len(grid.speed_q16),
        codes=len(grid.code),
        thrusts=len(grid.thrust_q16),
        dead_n=c_text.double_literal(characteristic.thrust_dead_n),
        thrust_single=f"{limits.thrust_single_n:.6e}",
        thrust_fixed=f"{limits.thrust_fixed_n:.6e}",
        code_single=f"{limits.code_single:.6e}",
        code_fixed=f"{limits.code_fixed:.6e}",
        trip_single=f"{limits.trip_single:.6e}",
        trip_fixed=f"{limits.trip_fixed:.6e}",
        reverses=characteristic.code_min < 0,
        arrays=[
            array("int32_t", "speed_q16", grid.speed_q16, "Speed along the thruster; Q16.16 m/s."),
            array("int16_t", "code", grid.code, "Control codes."),
            array("int32_t", "thrust_q16", grid.thrust_q16, "Wanted thrusts; Q16.16 N."),
            array("double", "max_n", grid.thrust_max_n, "Largest thrust at each speed. [N]"),
            array("double", "min_n", grid.thrust_min_n, "Most negative thrust. [N]"),
            array(
                "double", "reference_thrust_n", grid.thrust_n, "Thrust at each speed and code. [N]"
            ),
            array(
                "double",
                "reference_code",
                grid.unrounded_code,
                "Code, not rounded, at each speed and wanted thrust.",
            ),
        ],
    )
