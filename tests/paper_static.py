"""Table 2 of Kostenko 2023 as it is printed, and its exact inverse."""

from dataclasses import dataclass

import numpy as np

from pipeline.types import ArrayLike, FloatArray


@dataclass(frozen=True)
class StaticTable:
    """Table 2: rows of K_F0, K_F1, K_F2 [N] at speeds that rise from 0 [m/s], Kostenko 2023 (4)."""

    speed_mps: FloatArray
    coefficients: FloatArray

    def at_speed(self, speed_mps: ArrayLike) -> FloatArray:
        columns = [np.interp(speed_mps, self.speed_mps, k) for k in self.coefficients.T]
        return np.stack(columns, axis=-1)

    def thrust_n(self, code: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
        """Thrust [N]; against the motion the row at rest holds."""
        codes, speed = np.broadcast_arrays(np.asarray(code, float), np.asarray(speed_mps, float))
        k = np.moveaxis(self.at_speed(np.maximum(np.sign(codes) * speed, 0.0)), -1, 0)
        size = np.abs(codes)
        return np.asarray(np.sign(codes) * np.maximum(k[0] + k[1] * size + k[2] * size**2, 0.0))


def code_from_thrust(thrust_n: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Exact inverse of a row for thrusts above zero, by the root that keeps its digits."""
    k = np.moveaxis(coefficients, -1, 0)
    rise = thrust_n - k[0]
    return np.asarray(2.0 * rise / (k[1] + np.sqrt(k[1] ** 2 + 4.0 * k[2] * rise)))
