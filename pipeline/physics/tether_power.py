"""Pull of the cable and drag of the hull at the edge of a footprint: Kostenko and Mokeeva 2009.

Axes of the paper: X forward, Y up, Z starboard.
"""

import numpy as np

from pipeline.types import FloatArray

#: Table 4 as printed: largest |T_x|, |T_y|, |T_z|, |T| at the vehicle. [N]
PRINTED_TABLE_4_N = (166.0, 132.0, 107.0, 213.0)


def largest_pull(on_vehicle_n: FloatArray) -> tuple[float, float, float, float]:
    """Return the largest size of each component and of the whole (Table 4).

    Examples
    --------
    >>> largest_pull(np.array([[-3.0, 4.0, 0.0], [1.0, 2.0, -2.0]]))
    (3.0, 4.0, 2.0, 5.0)
    """
    x, y, z = np.max(np.abs(on_vehicle_n), axis=0)
    whole = np.max(np.linalg.norm(on_vehicle_n, axis=1))
    return float(x), float(y), float(z), float(whole)


def hull_drag_n(
    speed_mps: float, displacement_m3: float, density_kgpm3: float, coefficient: float = 1.0
) -> float:
    r"""Return the hull's drag, eq. (4): :math:`C \rho V^2 U^{2/3} / 2`.

    Examples
    --------
    >>> round(hull_drag_n(1.0, 0.05, 1025.0), 1), round(hull_drag_n(0.5, 0.05, 1025.0), 1)
    (69.6, 17.4)
    """
    return (
        0.5
        * coefficient
        * density_kgpm3
        * speed_mps
        * abs(speed_mps)
        * float(displacement_m3 ** (2 / 3))
    )
