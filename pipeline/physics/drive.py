"""Mechanical characteristic of a drive: torque against shaft speed and control code."""

from dataclasses import dataclass

import numpy as np

from pipeline.types import ArrayLike, FloatArray, IntArray


@dataclass(frozen=True)
class TorqueSurface:
    r"""The family M(n, N) as one polynomial around the speeds at which each code is used.

    .. math:: M(n, N) = \sum_k c_k x^{i_k} y^{j_k}, \quad
              x = \frac{n - n_c(y)}{n_s}, \quad y = \frac{|N|}{N_s}, \quad
              n_c(y) = \sum_l b_l y^l

    A drive under torque control is measured in a band of speeds that moves with the code; powers
    of n itself would be all but the same within it. Outside the band M goes on along its tangent:
    a polynomial continued further would be anything.

    `exponents` shape (k, 2) holds (i_k, j_k); `coefficients` shape (k,) [N m]; `centre_rps` shape
    (l,) holds b_l [rev/s]; `shaft_speed_scale_rps` is n_s [rev/s], `code_scale` N_s; `band_code`,
    `slowest_rps`, `fastest_rps` shape (f,) hold the ends of the measured band at code 0 and at the
    tested codes, linear between.
    """

    exponents: IntArray
    coefficients: FloatArray
    centre_rps: FloatArray
    shaft_speed_scale_rps: float
    code_scale: float
    band_code: FloatArray
    slowest_rps: FloatArray
    fastest_rps: FloatArray


def surface_basis(
    shaft_speed_rps: ArrayLike, code: ArrayLike, surface: TorqueSurface
) -> FloatArray:
    """Terms of the surface, shape (..., k): the derivative of M to each coefficient.

    At shaft speed [rev/s] and control code that broadcast to shape (...); the `coefficients` of the
    surface are not used.
    """
    x, inside, y = _coordinates(shaft_speed_rps, code, surface)
    power = surface.exponents[:, 0]
    in_speed = inside[..., None] ** power
    slope = power * inside[..., None] ** np.maximum(power - 1, 0)
    return np.asarray(
        (in_speed + (x - inside)[..., None] * slope) * y[..., None] ** surface.exponents[:, 1]
    )


def _coordinates(
    shaft_speed_rps: ArrayLike, code: ArrayLike, surface: TorqueSurface
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """x, x held to the measured band, and y."""
    n, codes = np.broadcast_arrays(
        np.asarray(shaft_speed_rps, float), np.abs(np.asarray(code, float))
    )
    y = codes / surface.code_scale
    centre = np.polynomial.polynomial.polyval(y, surface.centre_rps)
    slowest = np.interp(codes, surface.band_code, surface.slowest_rps)
    fastest = np.interp(codes, surface.band_code, surface.fastest_rps)
    held = np.clip(n, slowest, fastest)
    scale = surface.shaft_speed_scale_rps
    return np.asarray((n - centre) / scale), np.asarray((held - centre) / scale), y


def drive_torque(shaft_speed_rps: ArrayLike, code: ArrayLike, surface: TorqueSurface) -> FloatArray:
    """Torque of the drive [N m], shape (...), at shaft speeds [rev/s] and codes.

    The sign of a code is ignored: the drive is taken as symmetric.

    Examples
    --------
    A drive whose torque falls from 1 N m at rest to nothing at 20 rev/s for code 100:

    >>> s = TorqueSurface(np.array([[0, 1], [1, 0]]), np.array([1.0, -1.0]), np.zeros(1), 20.0,
    ...                   100.0, np.array([0.0, 100.0]), np.zeros(2), np.array([0.0, 20.0]))
    >>> drive_torque(np.array([0.0, 10.0, 20.0]), 100, s).tolist()
    [1.0, 0.5, 0.0]
    """
    return np.asarray(surface_basis(shaft_speed_rps, code, surface) @ surface.coefficients)


def drive_torque_slope(
    shaft_speed_rps: ArrayLike, code: ArrayLike, surface: TorqueSurface
) -> FloatArray:
    """Slope dM/dn of the drive's torque, negative for a stable drive [N m s].

    Parameters as in `drive_torque`.
    """
    _, inside, y = _coordinates(shaft_speed_rps, code, surface)
    power = surface.exponents[:, 0]
    slope = power * inside[..., None] ** np.maximum(power - 1, 0)
    basis = slope * y[..., None] ** surface.exponents[:, 1]
    return np.asarray(basis @ surface.coefficients) / surface.shaft_speed_scale_rps
