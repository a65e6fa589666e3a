"""Which readings of a mooring test belong to the supply voltage that the tables are for."""

from collections.abc import Iterable

#: Readings within this share of the wanted voltage belong to it.
VOLTAGE_TOLERANCE = 0.05
#: Voltages further apart than this belong to different tests; a supply sags less between codes.
_VOLTAGE_GAP_V = 0.8


def is_at_supply(voltage_v: float | None, wanted_v: float | None) -> bool:
    """Tell whether a reading belongs to the tables.

    Parameters
    ----------
    voltage_v : float or None
        Voltage of the reading, None where the file does not say it. [V]
    wanted_v : float or None
        Voltage of the tables, None where the vehicle file states none. [V]

    Returns
    -------
    bool
        True also where either is not known.

    Examples
    --------
    >>> [is_at_supply(volts, 16.0) for volts in (15.9, 14.0, None)], is_at_supply(12.0, None)
    ([True, False, True], True)
    """
    if voltage_v is None or wanted_v is None:
        return True
    return abs(voltage_v - wanted_v) <= VOLTAGE_TOLERANCE * wanted_v


def voltage_groups(voltages_v: Iterable[float]) -> tuple[tuple[float, float], ...]:
    """Part voltages into tests: lowest and highest of each group, groups rising.

    Examples
    --------
    >>> voltage_groups([16.0, 15.6, 15.2, 12.1, 12.0])
    ((12.0, 12.1), (15.2, 16.0))
    """
    groups: list[tuple[float, float]] = []
    for voltage in sorted(voltages_v):
        if groups and voltage - groups[-1][1] <= _VOLTAGE_GAP_V:
            groups[-1] = (groups[-1][0], voltage)
        else:
            groups.append((voltage, voltage))
    return tuple(groups)
