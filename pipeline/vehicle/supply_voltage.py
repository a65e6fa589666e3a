"""Which readings of a mooring test belong to the supply voltage that the tables are for."""

#: Readings within this share of the wanted voltage belong to it.
VOLTAGE_TOLERANCE = 0.05


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
