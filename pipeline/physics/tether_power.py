"""Forces and power that hold the edge of a footprint: Kostenko and Mokeeva 2009, Tables 4 to 6.

Axes of the paper: X forward, Y up, Z starboard.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.types import FloatArray

#: Table 4 as printed: largest |T_x|, |T_y|, |T_z|, |T| at the vehicle. [N]
PRINTED_TABLE_4_N = (166.0, 132.0, 107.0, 213.0)
#: Table 5 as printed: hull drag and needed force along X, Y, Z. [N]
PRINTED_TABLE_5_N = ((70.0, 18.0, 70.0), (236.0, 160.0, 236.0))
#: Table 6 as printed: towing power along X, Y, Z, its sum, and the power consumed, likewise. [W]
PRINTED_TABLE_6_W = ((236.0, 80.0, 236.0, 552.0), (572.0, 194.0, 572.0, 1338.0))


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


@dataclass(frozen=True)
class RequiredDrive:
    """What the thrusters must give, along X, Y, Z (Tables 5 and 6).

    Attributes
    ----------
    drag_n, force_n : tuple of 3 floats
        Hull drag and needed force. [N]
    towing_power_w, consumed_power_w : tuple of 3 floats
        Power on the vehicle and taken from its supply. [W]
    """

    drag_n: tuple[float, float, float]
    force_n: tuple[float, float, float]
    towing_power_w: tuple[float, float, float]
    consumed_power_w: tuple[float, float, float]


def required_drive(
    cable_pull_n: tuple[float, float, float] = (166.0, 132.0, 166.0),
    *,
    water_speed_mps: tuple[float, float, float] = (1.0, 0.5, 1.0),
    displacement_m3: float = 0.05,
    residual_buoyancy_n: float = 10.0,
    density_kgpm3: float = 1025.0,
    propeller_efficiency: float = 0.55,
    drive_efficiency: float = 0.75,
) -> RequiredDrive:
    r"""Return forces and power that hold the footprint's edge, eqs. (3) to (6); defaults: paper's.

    .. math:: F_i = T_i + R_i + Q_i, \qquad N_i = F_i V_i, \qquad
        N_{i,\text{consumed}} = N_i / (\eta_p \eta_d)

    Parameters
    ----------
    cable_pull_n : tuple of 3 floats
        Largest pull of the cable; the paper takes that along X for Z too, for a current from the
        side. [N]
    water_speed_mps : tuple of 3 floats
        Vehicle's speed plus the current, along X, Y, Z. [m/s]
    displacement_m3 : float
        U. [m^3]
    residual_buoyancy_n : float
        Q_a, along Y. [N]
    density_kgpm3 : float
        Water. [kg/m^3]
    propeller_efficiency, drive_efficiency : float
        Efficiencies. [-]

    Returns
    -------
    RequiredDrive

    Notes
    -----
    The paper rounds on the way: R_y = 17.4 N becomes 18 N, hence F_y = 160 N where this gives
    159.4 N, and the powers follow from the rounded forces (552 W where this gives 550.8 W).

    Examples
    --------
    >>> drive = required_drive()
    >>> [round(f, 1) for f in drive.force_n]
    [235.6, 159.4, 235.6]
    """
    drag = [hull_drag_n(v, displacement_m3, density_kgpm3) for v in water_speed_mps]
    buoyancy = (0.0, residual_buoyancy_n, 0.0)
    force = [t + r + q for t, r, q in zip(cable_pull_n, drag, buoyancy, strict=True)]
    towing = [f * v for f, v in zip(force, water_speed_mps, strict=True)]
    efficiency = propeller_efficiency * drive_efficiency
    return RequiredDrive(
        drag_n=(drag[0], drag[1], drag[2]),
        force_n=(force[0], force[1], force[2]),
        towing_power_w=(towing[0], towing[1], towing[2]),
        consumed_power_w=(towing[0] / efficiency, towing[1] / efficiency, towing[2] / efficiency),
    )
