"""Forms of the inverse that only the validation needs, around those of `pipeline.control`."""

from dataclasses import dataclass, field

import numpy as np

from pipeline.control.allocation import ThrustLimits
from pipeline.control.inverse import Inverse
from pipeline.export import fixed_point
from pipeline.export.fixed_point import Q16_ONE, FixedTables
from pipeline.types import ArrayLike, FloatArray

#: Limits are worked out once for each step of speed. [m/s]
_SPEED_STEP = 1e-3


@dataclass(frozen=True)
class Remembered:
    """An inverse whose limits are kept for speeds to the millimetre per second: they are slow."""

    inverse: Inverse
    _limits: dict[int, ThrustLimits] = field(default_factory=dict, init=False, repr=False)

    @property
    def name(self) -> str:
        """That of the inverse within."""
        return self.inverse.name

    def limits(self, speed_mps: float) -> ThrustLimits:
        """Limits at the nearest millimetre per second."""
        key = round(speed_mps / _SPEED_STEP)
        if key not in self._limits:
            self._limits[key] = self.inverse.limits(key * _SPEED_STEP)
        return self._limits[key]

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Return that of the inverse within."""
        return self.inverse.code(thrust_n, speed_mps)


@dataclass(frozen=True)
class FixedPoint:
    """The firmware's fixed-point code, bit for bit: whole codes, limits as the C functions say."""

    tables: FixedTables
    floating: Inverse
    """For the limits against the motion, which the C code leaves to its caller."""
    name: str = "firmware grid in fixed point"

    def limits(self, speed_mps: float) -> ThrustLimits:
        """Limits of the grid."""
        return self.floating.limits(speed_mps)

    def code(self, thrust_n: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Whole codes."""
        thrust = np.rint(np.asarray(thrust_n, float) * Q16_ONE).astype(np.int64)
        speed = np.rint(np.asarray(speed_mps, float) * Q16_ONE).astype(np.int64)
        codes = fixed_point.code_from_thrust(self.tables, np.atleast_1d(thrust), speed)
        return codes.reshape(thrust.shape).astype(float)
