"""Current and voltage that the rebuilt rig files show: an invented but plausible 48 V drive.

The paper prints no electrical figure. Losses are taken as a constant, a part that grows with
speed (iron, seals) and a part that grows with torque squared (copper); the supply sags with
current. Nothing in Tables 1-4 depends on these columns.
"""

import math
from dataclasses import dataclass

SUPPLY_V = 48.0
SUPPLY_RESISTANCE_OHM = 0.12


@dataclass(frozen=True)
class Electric:
    """What the supply's meters show."""

    voltage_v: float
    current_a: float


def electric(shaft_speed_rpm: float, torque_nm: float) -> Electric:
    """Voltage and current at the drive's input, for magnitudes of speed and torque.

    Solves U I = P with U = 48 V - R I for the smaller current.

    Parameters
    ----------
    shaft_speed_rpm : float
        Shaft speed. [rpm]
    torque_nm : float
        Torque at the shaft. [N m]

    Examples
    --------
    >>> at_work = electric(1692.0, 0.732)
    >>> round(at_work.voltage_v, 1), round(at_work.current_a, 2)
    (47.6, 3.34)
    """
    output_w = torque_nm * 2.0 * math.pi * shaft_speed_rpm / 60.0
    power_w = output_w + 4.0 + 0.008 * shaft_speed_rpm + 22.0 * torque_nm**2
    discriminant = SUPPLY_V**2 - 4.0 * SUPPLY_RESISTANCE_OHM * power_w
    current_a = (SUPPLY_V - math.sqrt(discriminant)) / (2.0 * SUPPLY_RESISTANCE_OHM)
    return Electric(SUPPLY_V - SUPPLY_RESISTANCE_OHM * current_a, current_a)
