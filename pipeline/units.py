"""Conversions between fixed units; `pipeline.ingest.unit_text` reads unit *texts* of files."""

#: Standard acceleration of gravity, exact by definition (3rd CGPM, 1901); for kgf and lbf only.
STANDARD_GRAVITY_MPS2 = 9.80665


def rpm_to_rps(shaft_speed_rpm: float) -> float:
    """Convert revolutions per minute to revolutions per second.

    >>> rpm_to_rps(90.0)
    1.5
    """
    return shaft_speed_rpm / 60.0


def rps_to_rpm(shaft_speed_rps: float) -> float:
    """Convert revolutions per second to revolutions per minute.

    >>> rps_to_rpm(1.5)
    90.0
    """
    return shaft_speed_rps * 60.0
