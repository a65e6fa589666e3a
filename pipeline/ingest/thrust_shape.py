"""What the curve of thrust at rest over the code cannot be, and what of it is odd."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Table
from pipeline.ingest.row_directions import column_that_parts
from pipeline.ingest.rows import listed
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray

#: Neighbouring codes give thrust within this factor, where it is above a twentieth of the largest.
_JUMP = 8.0
_CLEAR = 0.05
#: What is left of the thrust where another unit or setting begins; and it grows as much on.
_STEP = 0.65
#: A reading this many times larger, or smaller, than those beside it; thrust of one sign over that
#: of the other.
_ODD, _LEAST_OF_BOTH = 3.0, 0.35
#: Readings at one code that lie further apart than this share are of two characteristics.
_APART = 0.12
#: By so much at every code readings of one characteristic do not differ.
_DIFFERS = 0.03
_LEAST_CODES = 4
#: No dead zone is larger than this share of the largest code tested.
_LATE = 0.5
#: Of the largest thrust: more on both sides of where there is none is thrust both ways.
_SIDE = 0.2


def shape_problem(table: Table, points: Sequence[MooringPoint]) -> Problem | None:
    """Refuse a table whose thrust falls by a large factor, or has two values at most codes."""
    used = [point for point in points if not point.marks and point.code != 0.0]
    for sign in (1.0, -1.0):
        own = [point for point in used if sign * point.code > 0.0]
        for check in (_falls, _two_values, _rests_elsewhere) if own else ():
            if (found := check(table, own, sign)) is not None:
                return found
    return None


def _falls(table: Table, points: Sequence[MooringPoint], sign: float) -> Problem | None:
    """Look for thrust that falls by a large factor, or at one code and grows on from there.

    One bad reading is back where it was at the next code; an overloaded supply grows no more.
    """
    ordered = sorted(points, key=lambda point: abs(point.code))
    largest = max(sign * point.thrust_n for point in ordered)
    for last, point in pairwise(ordered):
        before, here = sign * last.thrust_n, sign * point.thrust_n
        if before > _CLEAR * largest and abs(here) < before / _JUMP and point.code != last.code:
            how = ": a sign that parts thousands was lost, or the force was"
            return _fallen(table, (last.code, before), (point.code, here), how, point.source.row)
    codes, thrust = _sizes(points, sign)
    for at in range(2, len(codes) - 2):
        before, here, after = thrust[at - 1], thrust[at], thrust[at + 1 :]
        falls = before > _CLEAR * thrust.max() and here < min(_STEP * before, thrust[at - 2])
        if falls and here < after[0] < before and after[-1] > here / _STEP:
            how = " and grows on from there, as in another unit or with another setting"
            row = next(one.source.row for one in points if one.code == codes[at])
            return _fallen(table, (codes[at - 1], before), (codes[at], here), how, row)
    return None


def _fallen(
    table: Table, last: tuple[float, float], here: tuple[float, float], how: str, row: int
) -> Problem:
    return table.at(row).error(
        f"thrust falls from {last[1]:.3g} N at code {last[0]:g} to {here[1]:.3g} N at code "
        f"{here[0]:g}{how}. So the table was left out.",
        "thrust that changes little from one code to the next.",
        'Correct the numbers, or mark the rows with "#" in column A.',
    )


def odd_sizes(table: Table, points: Sequence[MooringPoint]) -> Iterator[Problem]:
    """Say where one code has thrust of another size than those beside it, or one sign than both.

    A screw pushes astern with a third of what it gives ahead at least, or the other way round.
    """
    both = [_sizes(points, sign) for sign in (1.0, -1.0)]
    for codes, thrust in both:
        clear = _CLEAR * float(np.median([*thrust, 0.0]))
        for at in range(1, len(codes) - 1):
            before, here, after = thrust[at - 1 : at + 2].tolist()
            low, high = sorted((before, after))
            if low > clear > 0.0 and not low / _ODD < here < _ODD * high:
                row = next(one.source.row for one in points if one.code == codes[at])
                yield table.at(row, "thrust").warning(
                    f"thrust is {here:.3g} N at code {codes[at]:g}, and {before:.3g} and "
                    f"{after:.3g} N at the codes beside it.",
                    "thrust that changes little from one code to the next.",
                    'Correct the number, or mark the row with "#" in column A.',
                )
    if min(len(codes) for codes, _ in both) < _LEAST_CODES:
        return
    common = min((np.abs(codes) for codes, _ in both), key=max)[-_LEAST_CODES:]
    ahead, astern = (
        float(np.median(np.interp(common, np.abs(codes), thrust))) for codes, thrust in both
    )
    share = min(ahead, astern) / max(ahead, astern, 1e-12)
    if share < _LEAST_OF_BOTH:
        must_go = share < _LEAST_OF_BOTH / 2.0
        yield Problem(
            "error" if must_go else "warning",
            table.at(table.head, "thrust"),
            f"thrust is {ahead:.3g} N at large codes ahead and {astern:.3g} N at those astern: one "
            f"of them may be in another unit.{' So the table was left out.' * must_go}",
            "thrust ahead and astern of about one size.",
            "Correct the numbers, or write each direction on a sheet of its own.",
        )


def _rests_elsewhere(table: Table, points: Sequence[MooringPoint], sign: float) -> Problem | None:
    """Look for codes that count from elsewhere: thrust begins, or is least, in the middle of them.

    What was tested begins far from code 0, and right where the thrust does; or thrust without a
    sign falls to nothing and rises again.
    """
    codes, thrust = _sizes(points, sign)
    largest = float(thrust.max(initial=0.0))
    going = np.flatnonzero(thrust > _CLEAR * largest)
    if len(codes) < _LEAST_CODES or largest <= 0.0:
        return None
    least, first, last = int(np.argmin(thrust)), abs(codes[0]), abs(codes[-1])
    begins = abs(codes[going[0]])
    valley = thrust[least] <= _CLEAR * largest and min(thrust[0], thrust[-1]) > _SIDE * largest
    if valley:
        what = f"thrust is least at code {codes[least]:g} and grows to both sides"
    elif first >= _LATE * last and 0 < going[0] < _LEAST_CODES:
        what = (
            f"thrust begins at code {begins:g}, {100 * first / last:.0f} % of the largest, {last:g}"
        )
    else:
        return None
    return table.place.error(
        f"{what}: the codes seem to count from elsewhere, as a duty cycle does. So the table was "
        "left out.",
        "codes, or per cent of full throttle, that are 0 at rest.",
        "Write codes or pulse widths, or state the right column in vehicle.yaml under columns: "
        "mooring: code or pwm.",
    )


def _two_values(table: Table, points: Sequence[MooringPoint], sign: float) -> Problem | None:
    """Look for two groups of readings at most codes, at equal voltage."""
    groups: dict[tuple[float, float | None], list[MooringPoint]] = defaultdict(list)
    for point in points:
        voltage = None if point.voltage_v is None else round(point.voltage_v)
        groups[point.code, voltage].append(point)
    largest = max(sign * point.thrust_n for point in points)
    shares: list[float] = []
    later: list[float] = []
    low: list[int] = []
    high: list[int] = []
    for own in groups.values():
        thrust = [sign * point.thrust_n for point in own]
        if len(own) > 1 and max(thrust) > 0.1 * largest:
            shares.append((max(thrust) - min(thrust)) / max(thrust))
            later += [(thrust[-1] - thrust[0]) / max(thrust)] * (own[0].sweep <= own[-1].sweep)
            for point, one in zip(own, thrust, strict=True):
                (high if 2.0 * one > max(thrust) + min(thrust) else low).append(point.source.row)
    if len(shares) < _LEAST_CODES or float(np.median(shares)) < _APART:
        return _other_the_second_time(table, later)
    widest = max(groups.values(), key=lambda own: np.ptp([point.thrust_n for point in own]))
    values = sorted(sign * point.thrust_n for point in widest)
    by = "something parts the rows, such as a direction or a voltage that no column states"
    remedy = (
        "Write reverse with negative codes, the voltage into a column, or each test on a sheet of "
        "its own."
    )
    if head := column_that_parts(table.block, low, high):
        by = f'column "{head}" parts the rows'
        remedy = (
            "State in vehicle.yaml which rows are meant, or which are of reverse:\n"
            f'  columns:\n    mooring:\n      only: {{"{head}": ...}}\n'
            f'      direction: {{header: "{head}", reverse: ["..."]}}'
        )
    return table.at(widest[0].source.row).error(
        f"at code {widest[0].code:g} thrust is {values[0]:.3g} and {values[-1]:.3g} N "
        f"({listed([point.source.row for point in widest])}), and so at most codes: {by}. So the "
        "table was left out.",
        "one characteristic in a table.",
        remedy,
    )


def _other_the_second_time(table: Table, later: Sequence[float]) -> Problem | None:
    """Doubt a second sweep whose thrust differs from that of the first one at every code.

    `later` is by how much, a share; without what a falling sweep comes back to: hysteresis.
    """
    middle = float(np.median(later)) if len(later) >= _LEAST_CODES else 0.0
    if abs(middle) < _DIFFERS or min(np.sign(middle) * np.array(later)) <= 0.0:
        return None
    return table.place.warning(
        f"the second time thrust is {100.0 * abs(middle):.0f} % "
        f"{'more' if middle > 0.0 else 'less'} at each code: that may be a direction or a "
        "voltage that no column states; all of it was fitted together.",
        "one characteristic in a table.",
        "Write reverse with negative codes, or each test on a sheet of its own.",
    )


def saturated(table: Table, points: Sequence[MooringPoint]) -> Iterator[Problem]:
    """Say where several of the largest codes give exactly the same reading."""
    for sign in (1.0, -1.0):
        own = {
            (abs(one.code), round(sign * (one.thrust_n + one.tare_n), 6)): one
            for one in points
            if not one.marks and sign * one.code > 0.0
        }
        most = max((force for _, force in own), default=0.0)
        codes = sorted({code for code, force in own if force == most})
        if most > 0.0 and len(codes) >= _LEAST_CODES and codes[-1] == max(code for code, _ in own):
            yield table.at(own[codes[0], most].source.row, "thrust").warning(
                f"the force is exactly {most:.4g} N at {len(codes)} codes from {sign * codes[0]:g} "
                f"to {sign * codes[-1]:g}: the sensor or its amplifier is at the end of its range.",
                "thrust that grows with the code.",
                'Mark these rows with "#" in column A if it is so.',
            )


def _sizes(points: Sequence[MooringPoint], sign: float) -> tuple[FloatArray, FloatArray]:
    """Return the codes of a sign from the smallest on, and the thrust in their sense at each."""
    own = {code: force for code, force in by_code(points).items() if sign * code > 0.0}
    codes = sorted(own, key=abs)
    return np.array(codes), np.array([sign * own[code] for code in codes])


def by_code(points: Sequence[MooringPoint]) -> dict[float, float]:
    """Return the mean thrust at each code of the readings that count."""
    thrust: dict[float, list[float]] = defaultdict(list)
    for point in points:
        if not point.marks:
            thrust[point.code].append(point.thrust_n)
    return {code: float(np.mean(values)) for code, values in thrust.items()}
