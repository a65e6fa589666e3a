"""The generated C self-test: the double-precision reference and how far C may be from it.

The reference is `pipeline.physics.thrust_grid` evaluated in double precision at speeds and thrusts
that both C variants take without rounding (multiples of 2^-16).
"""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.export import c_text
from pipeline.export.c_source import Identity, render
from pipeline.export.fixed_point import Q16_ONE
from pipeline.physics.thrust_grid import ThrustGrid, code_from_thrust, thrust_from_code
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic
from pipeline.types import FloatArray, IntArray

#: Up to this largest code every code is tested, above it evenly spaced ones.
EVERY_CODE_UP_TO = 255
#: Thrusts of each sign on the grid of the inverse, up to 1.1 T_max.
_THRUSTS = 45
_SINGLE_EPSILON = 2.0**-23
_Q16_STEP = 2.0**-16


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


@dataclass(frozen=True)
class Reference:
    """Reference on two grids: thrust over (speed, code), code over (speed, thrust)."""

    speed_q16: IntArray
    code: IntArray
    thrust_n: FloatArray
    thrust_q16: IntArray
    unrounded_code: FloatArray
    thrust_max_n: FloatArray
    thrust_min_n: FloatArray


def thrust_grid(branch: FirmwareBranch) -> ThrustGrid:
    """Return the branch as the reference takes it."""
    return ThrustGrid(
        speed_mps=np.asarray(branch.speed_mps, np.float64),
        thrust_max_n=np.asarray(branch.thrust_max_n, np.float64),
        fraction=np.asarray(branch.fraction, np.float64),
        code=np.asarray(branch.code, np.float64),
    )


def reference(characteristic: FirmwareCharacteristic) -> Reference:
    """Evaluate the double-precision characteristic on the self-test's grids.

    Speeds are the tabulated ones of both signs, one between each two of them and one beyond each
    end; codes are all there are, or about 250 evenly spaced ones where there are more.
    """
    positive = thrust_grid(characteristic.positive)
    negative = thrust_grid(characteristic.negative)
    speed_q16 = _speeds(positive, negative)
    speed = speed_q16[:, None] / Q16_ONE
    code = _codes(positive, negative)
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
    return Reference(
        speed_q16=speed_q16,
        code=code,
        thrust_n=thrust_n,
        thrust_q16=thrust_q16,
        unrounded_code=unrounded,
        thrust_max_n=positive.at_speed(np.maximum(speed[:, 0], 0.0))[0],
        thrust_min_n=-negative.at_speed(np.maximum(-speed[:, 0], 0.0))[0],
    )


def _speeds(positive: ThrustGrid, negative: ThrustGrid) -> IntArray:
    knots = np.unique(np.concatenate((-negative.speed_mps, positive.speed_mps)))
    between = (knots[:-1] + knots[1:]) / 2
    beyond = np.array([knots[0] - 1.0, knots[-1] + 1.0])
    speeds = np.concatenate((knots, between, beyond))
    return np.unique(np.rint(speeds * Q16_ONE).astype(np.int64))


def _codes(positive: ThrustGrid, negative: ThrustGrid) -> IntArray:
    signed = []
    for sign, grid in ((-1, negative), (1, positive)):
        # Beyond the last code of a row there is nothing to invert; the edge cases cover it.
        largest = max(int(grid.code[:, -1].min()), 1)
        step = 1 if largest <= EVERY_CODE_UP_TO else math.ceil(largest / (EVERY_CODE_UP_TO // 2))
        signed.append(sign * np.append(np.arange(1, largest, step), largest))
    return np.unique(np.concatenate((*signed, [0])).astype(np.int64))


def _thrusts(positive: ThrustGrid, negative: ThrustGrid, dead_n: float) -> IntArray:
    dead = math.floor(dead_n * Q16_ONE)
    grids = []
    for sign, grid in ((-1, negative), (1, positive)):
        largest = 1.1 * float(grid.thrust_max_n.max()) * Q16_ONE
        even = np.rint(np.linspace(0.0, largest, _THRUSTS + 1)[1:]).astype(np.int64)
        grids.append(sign * np.concatenate((even, [dead, dead + 1])))
    return np.unique(np.concatenate((*grids, [0])).astype(np.int64))


def tolerances(characteristic: FirmwareCharacteristic) -> Tolerances:
    """Bound the rounding of both variants from the steepest parts of the tables.

    With a = max |dT/dN| [N], b = max |dN/dT| [1/N], c = max |dT/dV| [N s/m], the largest thrust T
    and speed V, the largest code N and one step s (2^-16) or relative step e (2^-23):

    fixed point: thrust s (2 + 2 a + c), code s (2 + b (2 + c));
    single precision: thrust e (4 T + 4 a N + c V), code e (4 N + b (4 T + c V)).
    """
    grids = (thrust_grid(characteristic.positive), thrust_grid(characteristic.negative))
    slopes = [_slopes(grid) for grid in grids]
    newtons_per_code = max(slope[0] for slope in slopes)
    codes_per_newton = max(slope[1] for slope in slopes)
    newtons_per_speed = max(slope[2] for slope in slopes)
    thrust = max(float(grid.thrust_max_n.max()) for grid in grids)
    speed = max(float(grid.speed_mps[-1]) for grid in grids)
    code = characteristic.code_max
    along = newtons_per_speed * speed
    return Tolerances(
        thrust_single_n=_SINGLE_EPSILON * (4 * thrust + 4 * newtons_per_code * code + along),
        thrust_fixed_n=_Q16_STEP * (2 + 2 * newtons_per_code + newtons_per_speed),
        code_single=min(
            _SINGLE_EPSILON * (4 * code + codes_per_newton * (4 * thrust + along)), 0.5
        ),
        code_fixed=min(_Q16_STEP * (2 + codes_per_newton * (2 + newtons_per_speed)), 0.5),
    )


def _slopes(grid: ThrustGrid) -> tuple[float, float, float]:
    """Return bounds of |dT/dN|, |dN/dT| and |dT/dV|, also between the tabulated speeds."""
    fractions = np.diff(grid.fraction)
    codes = np.diff(grid.code, axis=1)
    largest, smallest = grid.thrust_max_n.max(), grid.thrust_max_n.min()
    newtons_per_code = float((fractions * largest / codes.min(axis=0)).max())
    codes_per_newton = float((codes.max(axis=0) / (fractions * smallest)).max())
    if len(grid.speed_mps) == 1:
        return newtons_per_code, codes_per_newton, 0.0
    width = np.diff(grid.speed_mps)
    by_limit = np.abs(np.diff(grid.thrust_max_n)) / width
    by_code = newtons_per_code * np.abs(np.diff(grid.code, axis=0)).max(axis=1) / width
    return newtons_per_code, codes_per_newton, float((by_limit + by_code).max())


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
        every_code=characteristic.code_max <= EVERY_CODE_UP_TO,
        speeds=len(grid.speed_q16),
        codes=len(grid.code),
        thrusts=len(grid.thrust_q16),
        dead_n=c_text.double_literal(characteristic.thrust_dead_n),
        thrust_single=f"{limits.thrust_single_n:.6e}",
        thrust_fixed=f"{limits.thrust_fixed_n:.6e}",
        code_single=f"{limits.code_single:.6e}",
        code_fixed=f"{limits.code_fixed:.6e}",
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
