"""Rising and falling sweeps of a mooring test: tare, hysteresis."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Literal

import numpy as np

from pipeline.types import FloatArray
from pipeline.vehicle.supply_voltage import voltage_groups

Sweep = Literal["up", "down"]


def sweeps(codes: Sequence[float]) -> tuple[Sweep, ...]:
    """Tell for each reading whether the size of the code was rising or falling.

    A reading at the same code as the one before belongs to the same sweep; the first one takes
    the sense of what follows; a change of sign passes zero, so what follows it rises.

    Parameters
    ----------
    codes : sequence of float
        In the order of measurement. [-]

    Returns
    -------
    tuple of {"up", "down"}
        One entry a reading.

    Examples
    --------
    >>> sweeps([0, 40, 80, 80, 40, 0, -40])
    ('up', 'up', 'up', 'up', 'down', 'down', 'up')
    >>> sweeps([-80, -40, 0, 40])
    ('down', 'down', 'down', 'up')
    """
    found: list[Sweep | None] = []
    for index, code in enumerate(codes):
        before = codes[index - 1] if index else code
        if index == 0 or code == before:
            found.append(found[-1] if found else None)
        elif code * before < 0 or abs(code) > abs(before):
            found.append("up")
        else:
            found.append("down")
    first: Sweep = next((sense for sense in found if sense is not None), "up")
    return tuple(first if sense is None else sense for sense in found)


def tare(
    positions: FloatArray, zero_positions: FloatArray, zero_readings: FloatArray
) -> FloatArray:
    """Interpolate the reading at code 0 linearly over the order of rows, constant outside.

    Parameters
    ----------
    positions : ndarray, shape (n,)
        Where the readings stand in the order of measurement. [-]
    zero_positions, zero_readings : ndarray, shape (k,)
        Where code was 0, rising, and what was read there. [-], [N]

    Returns
    -------
    ndarray, shape (n,)
        To be subtracted; zero if there is no zero reading. [N]

    Examples
    --------
    >>> tare(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 2.0]), np.array([0.1, 0.3])).round(3)
    array([0.1, 0.2, 0.3, 0.3])
    """
    if len(zero_positions) == 0:
        return np.zeros(len(positions))
    return np.interp(positions, zero_positions, zero_readings)


def hysteresis(
    codes: Sequence[float],
    thrust_n: Sequence[float],
    senses: Sequence[Sweep],
    voltages_v: Sequence[float | None],
) -> float | None:
    """Mean thrust of falling sweeps less that of rising ones, at equal code and voltage.

    Thrust counts in the sense of the code, so that both directions add up.

    Parameters
    ----------
    codes, thrust_n : sequence of float
        Readings; code 0 is left out. [-], [N]
    senses : sequence of {"up", "down"}
        Of each reading.
    voltages_v : sequence of float or None
        Of each reading. [V]

    Returns
    -------
    float or None
        The mean over the codes that were passed both ways; None if there is none. [N]

    Examples
    --------
    >>> hysteresis([40, 80, 40], [5.0, 20.0, 5.5], ["up", "up", "down"], [None] * 3)
    0.5
    >>> hysteresis([-40, -40], [-5.0, -5.5], ["up", "down"], [None] * 2)
    0.5
    """
    groups = voltage_groups(voltage for voltage in voltages_v if voltage is not None)
    held: dict[tuple[float, float | None], dict[Sweep, list[float]]] = defaultdict(
        lambda: {"up": [], "down": []}
    )
    for code, thrust, sense, voltage in zip(codes, thrust_n, senses, voltages_v, strict=True):
        if code == 0.0:
            continue
        group = next(
            (low for low, high in groups if voltage is not None and low <= voltage <= high), None
        )
        size = thrust if code > 0 else -thrust
        held[(round(code, 6), group)][sense].append(size)
    differences = [
        float(np.mean(both["down"]) - np.mean(both["up"]))
        for both in held.values()
        if both["up"] and both["down"]
    ]
    return float(np.mean(differences)) if differences else None
