"""What thrust over code cannot look like: jumps between neighbours, two values at one code."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.rows import listed
from pipeline.records.measurements import MooringPoint

#: Neighbouring codes give thrust within this factor, where it is above a twentieth of the largest.
_JUMP = 8.0
_CLEAR = 0.05
#: Readings at one code that lie further apart than this share are of two characteristics.
_APART = 0.12
_LEAST_CODES = 4
#: No dead zone is larger than this share of the largest code tested.
_LATE = 0.5


def shape_problem(place: Place, points: Sequence[MooringPoint]) -> Problem | None:
    """Refuse a table whose thrust falls by a large factor, or has two values at most codes."""
    used = [point for point in points if not point.marks and point.code != 0.0]
    for sign in (1.0, -1.0):
        own = [point for point in used if sign * point.code > 0.0]
        if own:
            found = (
                _fall(place, own, sign)
                or _two_values(place, own, sign)
                or _late_start(place, own, sign)
            )
            if found is not None:
                return found
    return None


def _fall(place: Place, points: Sequence[MooringPoint], sign: float) -> Problem | None:
    ordered = sorted(points, key=lambda point: abs(point.code))
    largest = max(sign * point.thrust_n for point in ordered)
    last = ordered[0]
    for point in ordered[1:]:
        before, here = sign * last.thrust_n, sign * point.thrust_n
        if before > _CLEAR * largest and abs(here) < before / _JUMP and point.code != last.code:
            row = point.source.row
            return Problem(
                "error",
                Place(place.file, place.sheet, row),
                f"thrust falls from {before:.3g} N at code {last.code:g} to {here:.3g} N at code "
                f"{point.code:g}: a sign that parts thousands was lost, or the force was. So the "
                "table was left out.",
                "thrust that changes little from one code to the next.",
                'Correct the numbers, or mark the rows with "#" in column A.',
            )
        last = point
    return None


def _late_start(place: Place, points: Sequence[MooringPoint], sign: float) -> Problem | None:
    """Look for a thrust that begins in the middle of the codes: these count from elsewhere."""
    largest = max(sign * point.thrust_n for point in points)
    codes = sorted({abs(point.code) for point in points})
    going = [abs(p.code) for p in points if sign * p.thrust_n > _CLEAR * largest]
    if len(codes) < _LEAST_CODES or not going:
        return None
    least, low = min(going), codes[0]
    # what was tested begins far from code 0, and right where the thrust does
    if not low > _LATE * codes[-1] or least > codes[_LEAST_CODES - 1] or largest <= 0.0:
        return None
    first = [sign * point.thrust_n for point in points if abs(point.code) == low]
    if max(first) > _CLEAR * largest:
        return None
    return Problem(
        "error",
        place,
        f"thrust begins at code {least:g}, {100 * low / codes[-1]:.0f} % of the largest, "
        f"{codes[-1]:g}: the codes seem to count from elsewhere, as a duty cycle does. So the "
        "table was left out.",
        "codes, or per cent of full throttle, that are 0 at rest.",
        "Write codes or pulse widths, or state the right column in vehicle.yaml under columns: "
        "mooring: code or pwm.",
    )


def _two_values(place: Place, points: Sequence[MooringPoint], sign: float) -> Problem | None:
    """Look for two groups of readings at most codes, at equal voltage."""
    groups: dict[tuple[float, float | None], list[MooringPoint]] = defaultdict(list)
    for point in points:
        voltage = None if point.voltage_v is None else round(point.voltage_v)
        groups[point.code, voltage].append(point)
    largest = max(sign * point.thrust_n for point in points)
    shares: list[float] = []
    for own in groups.values():
        thrust = [sign * point.thrust_n for point in own]
        if len(own) > 1 and max(thrust) > 0.2 * largest:
            shares.append((max(thrust) - min(thrust)) / max(thrust))
    if len(shares) < _LEAST_CODES or float(np.median(shares)) < _APART:
        return None
    widest = max(groups.values(), key=lambda own: np.ptp([point.thrust_n for point in own]))
    values = sorted(sign * point.thrust_n for point in widest)
    return Problem(
        "error",
        Place(place.file, place.sheet, widest[0].source.row),
        f"at code {widest[0].code:g} thrust is {values[0]:.3g} and {values[-1]:.3g} N "
        f"({listed([point.source.row for point in widest])}), and so at most codes: something "
        "parts the rows, such as a direction or a voltage that no column states. So the table was "
        "left out.",
        "one characteristic in a table.",
        "Write reverse with negative codes, the voltage into a column, or each test on a sheet of "
        "its own.",
    )
