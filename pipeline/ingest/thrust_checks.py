"""What thrust at rest cannot be, by its size and by the shape of its curve over the code."""

import math
from collections import defaultdict
from collections.abc import Hashable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Table
from pipeline.ingest.blocks import BlockColumn
from pipeline.ingest.row_directions import column_that_parts
from pipeline.ingest.rows import listed
from pipeline.ingest.unit_text import unit_worth
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray

#: Thrust over the disc's area: a jet of 17 m/s. No thruster of an underwater vehicle has it. [Pa]
MOST_PRESSURE_PA = 150e3
#: Jets of 1 and 9 m/s: less, and more, is doubtful as the largest thrust.
_LEAST_PRESSURE_PA, _DOUBTFUL_PRESSURE_PA = 600.0, 40e3
#: K_T = T / (rho n^2 D^4) at rest: screws and ducted thrusters lie between 0.1 and 0.8.
LEAST_K_T, MOST_K_T = 0.02, 1.2
_USUAL_K_T = (0.1, 0.8)
_DOUBTFUL_K_T = (0.1, 0.9)
#: Ideal power over the power drawn: above 1 for an open propeller, 1.4 in a duct.
MOST_MERIT = 1.6
#: Less is left of it by no motor and propeller at their larger thrusts.
_DOUBTFUL_MERIT = 0.07
_USUAL_MERIT, _USUAL_PRESSURE_PA = 0.4, 10e3
_LARGE = 0.3
_LEAST_POINTS = 2


def thrust_problem(table: Table, points: Sequence[MooringPoint]) -> Problem | None:
    """Doubt or refuse a table whose thrust no propeller of this size gives.

    It names the unit that would fit, if there is one: a warning where the numbers are possible and
    strange, an error where they are not.
    """
    vehicle = table.vehicle
    used = [point for point in points if not point.marks]
    thrust = np.array([abs(point.thrust_n) for point in used])
    if not used or not thrust.any():
        return None
    large = thrust > _LARGE * thrust.max()
    rho, diameter = vehicle.water.density_kgpm3, vehicle.propeller.diameter_m
    area = math.pi / 4.0 * diameter**2
    speed_rps = np.array([abs(point.shaft_speed_rpm or math.nan) for point in used]) / 60.0
    with np.errstate(divide="ignore"):  # the square of a very small speed
        k_t = _median((thrust / (rho * speed_rps**2 * diameter**4))[large])
    merit = _median(_merit(table, used, thrust, rho * area)[large])
    pressure_pa = float(thrust.max()) / area
    usual = math.sqrt(_USUAL_K_T[0] * _USUAL_K_T[1])
    if k_t is not None and not _DOUBTFUL_K_T[0] <= k_t <= _DOUBTFUL_K_T[1]:
        why = (
            f"K_T at rest comes out as {k_t:.3g}, a screw has {_USUAL_K_T[0]:g} to "
            f"{_USUAL_K_T[1]:g}"
        )
        return _problem(table, why, k_t / usual, is_possible=LEAST_K_T <= k_t <= MOST_K_T)
    if merit is not None and not _DOUBTFUL_MERIT <= merit <= MOST_MERIT:
        why = f"an ideal propeller would take {merit:.3g} times the power that was drawn"
        ratio = (merit / _USUAL_MERIT) ** (2.0 / 3.0)
        return _problem(table, why, ratio, is_possible=merit <= MOST_MERIT)
    if not _LEAST_PRESSURE_PA <= pressure_pa <= _DOUBTFUL_PRESSURE_PA:
        is_possible = pressure_pa <= MOST_PRESSURE_PA
        given = "more than most give" if is_possible else "more than any gives"
        if pressure_pa < _LEAST_PRESSURE_PA:
            given = "less than most give"
        why = (
            f"{thrust.max():.3g} N on the disc of a propeller of {diameter:g} m are "
            f"{pressure_pa / 1000.0:.3g} kPa, {given}"
        )
        return _problem(table, why, pressure_pa / _USUAL_PRESSURE_PA, is_possible=is_possible)
    return None


def _median(values: FloatArray) -> float | None:
    there = values[np.isfinite(values)]
    return float(np.median(there)) if there.size >= _LEAST_POINTS else None


def _problem(table: Table, why: str, ratio: float, *, is_possible: bool) -> Problem:
    column = table.block.columns["thrust"]
    return Problem(
        "warning" if is_possible else "error",
        table.place,
        f'thrust "{column.header}" in {column.unit}: {why}.'
        f"{'' if is_possible else ' So the table was left out.'}{_likely(column, ratio)}",
        "thrust, shaft speed and diameter that belong together.",
        "Correct the unit in the file, or state it in vehicle.yaml:\n  columns:\n    mooring:\n"
        f'      thrust: {{header: "{column.header}", unit: ...}}\nor correct the diameter of the '
        "propeller there.",
    )


def _merit(
    table: Table, used: Sequence[MooringPoint], thrust: FloatArray, rho_area: float
) -> FloatArray:
    """Return ideal over drawn power, U I or that of a column."""
    drawn = {one.row: one.values.get("input_power") for one in table.live()}
    both = [(one.voltage_v or math.nan) * (one.current_a or math.nan) for one in used]
    of_column = [drawn.get(one.source.row) for one in used]
    power_w = np.array([a if b is None else b for a, b in zip(both, of_column, strict=True)])
    with np.errstate(divide="ignore", invalid="ignore"):
        merit = thrust**1.5 / math.sqrt(2.0 * rho_area) / np.abs(power_w)
    return np.asarray(np.where(np.isfinite(merit), merit, math.nan))


def _likely(column: BlockColumn, ratio: float) -> str:
    """Name the unit that would bring the thrust nearest to what is usual."""
    unit = unit_worth("force", abs(column.factor) / ratio, most_times=3.0)
    return "" if unit in {None, column.unit} else f" The numbers look like {unit}."


def curves_of(points: Sequence[MooringPoint]) -> dict[Hashable, dict[float, float]]:
    """Return the thrust of a table by voltage and code."""
    volts = [one.voltage_v for one in points if one.voltage_v is not None]
    return {round(float(np.median(volts))) if volts else None: by_code(points)}


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
