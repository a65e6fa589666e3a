"""From the readings of one mooring file to points: tare, signs, sweeps, and what is odd."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Sweep, Table, numbers
from pipeline.ingest.rows import listed
from pipeline.records.base import Source
from pipeline.records.measurements import MooringPoint
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.bench_schema import voltage_groups

#: Share of the largest thrust above which a tare, or its change, is worth a word.
_LARGE_TARE_SHARE = 0.05
#: Below this share of the largest one a sign says nothing: noise, tare.
_SIGNIFICANT_SHARE = 0.05
#: Of the largest thrust: a larger tare is looked at twice.
_MOST_TARE, _ALL_TARE = 0.2, 0.9
#: Fewer rows against their code are slips of the pen.
_LEAST_OF_A_SIGN = 3


def points_of_file(tables: Sequence[Table]) -> list[tuple[MooringPoint, ...]]:
    """Turn the tables of one file into points, none of a table that cannot be used.

    The order of the tables in a workbook is taken for the order of measurement.

    Notes
    -----
    Tare: the readings at code 0 of the table itself, interpolated linearly over the order of rows
    and constant outside; a table without one uses those of the whole file; a file without one is
    left as it is, with a note. A reading at code 0 is marked: its residual is zero by construction.
    """
    every = [(table, one) for table in tables for one in table.readings]
    thrust_n = numbers((one for _, one in every), "thrust")
    zero = np.array([one.is_zero for _, one in every], np.bool_)
    if any(table.live() for table in tables) and not zero.any():
        what = "there is no reading at code 0: the tare of the force sensor is not removed."
        remedy = "Take one before and one after each sweep."
        tables[0].problems.append(replace(tables[0].place, sheet=None).note(what, "", remedy))
    points: list[tuple[MooringPoint, ...]] = []
    for table in tables:
        own = np.array([one is table for one, _ in every], np.bool_)
        at = np.flatnonzero(zero & own if (zero & own).any() else zero)
        tares = at.astype(float), thrust_n[at]
        points.append(_points(table, np.flatnonzero(own).astype(float), tares) if own.any() else ())
    return points


def _points(
    table: Table, position: FloatArray, zeros: tuple[FloatArray, FloatArray]
) -> tuple[MooringPoint, ...]:
    codes, thrust_n = numbers(table.readings, "code"), numbers(table.readings, "thrust")
    used = np.array([not one.marks for one in table.readings])
    tare_n = tare(position, *zeros)
    raw_n = thrust_n - tare_n
    _report_tare(table, zeros[1], raw_n[used])
    at_rest = float(np.median(zeros[1])) if len(zeros[1]) else 0.0
    turned = _signs(table, codes, raw_n, used, at_rest)
    if turned is None:
        return ()
    signs, against = turned
    shaft_speed_rpm = _signed_shaft_speed(table, codes)
    senses = _senses(codes, used, table.sense)
    points = []
    for index, reading in enumerate(table.readings):
        marks = list(reading.marks)
        if index in against:
            marks.append("thrust against the code")
        if codes[index] == 0.0 and not marks:
            marks.append("zero reading")
        points.append(
            MooringPoint(
                source=Source(file=table.place.file, sheet=table.place.sheet, row=reading.row),
                code=float(codes[index]),
                thrust_n=float(raw_n[index] * signs[index]),
                tare_n=float(tare_n[index]) * float(signs[index]) + 0.0,  # no -0.0
                speed_mps=reading.values.get("speed", 0.0),
                shaft_speed_rpm=shaft_speed_rpm[index],
                voltage_v=reading.values.get("voltage", table.nominal_voltage_v),
                current_a=reading.values.get("current"),
                sweep=senses[index],
                marks=tuple(marks),
            )
        )
    return tuple(points)


def _report_tare(table: Table, zero_n: FloatArray, thrust_n: FloatArray) -> None:
    """Warn where the tare, or its change, is not small against the thrust of the rows used."""
    if len(zero_n) == 0 or not thrust_n.size:
        return
    largest_n = float(np.max(np.abs(thrust_n)))
    tare_n, drift_n = float(np.max(np.abs(zero_n))), float(np.ptp(zero_n))
    if largest_n > 0.0 and max(tare_n, drift_n) > _LARGE_TARE_SHARE * largest_n:
        what = (
            f"the reading at code 0 is up to {tare_n:.3g} N and changes by {drift_n:.3g} N, "
            f"the largest thrust is {largest_n:.3g} N; it was removed by interpolation."
        )
        expected = "a tare that is small against the thrust."
        remedy = "Zero the force sensor and let it warm up."
        table.problems.append(table.place.warning(what, expected, remedy))


def _senses(codes: FloatArray, used: BoolArray, stated: Sweep | None) -> tuple[Sweep, ...]:
    """Tell the sweeps from the rows that are used; the others take that of the row before."""
    if stated is not None:
        return (stated,) * len(codes)
    senses = iter(sweeps(codes[used].tolist()))
    found: list[Sweep] = []
    for is_used in used:
        found.append(next(senses) if is_used else (found[-1] if found else "up"))
    return tuple(found)


def _signs(
    table: Table, codes: FloatArray, thrust_n: FloatArray, used: BoolArray, tare_n: float
) -> tuple[FloatArray, list[int]] | None:
    """Check that thrust, without its tare, goes with the code; None leaves the table out.

    Returns what each thrust and its tare are to be multiplied by, and the positions that stay
    against their code. Where thrust is never negative although codes are, it was written as a size
    and is given the sign of its code. Where it goes against most codes, the table is left out: a
    sensor the other way round is the engineer's to state. Single rows are named.
    """
    say = table.problems.append
    size = np.abs(thrust_n)
    largest = float(np.max(size[used], initial=0.0))
    counts = used & (size > _SIGNIFICANT_SHARE * largest) & (codes != 0.0)
    wrong = counts & (codes * thrust_n < 0.0)
    right = counts & ~wrong
    one_sided = not ((codes < 0.0) & used).any() or not ((codes > 0.0) & used).any()
    if not wrong.any():
        # a tare that is a good part of the thrust may be the full thrust of the other direction
        before = thrust_n[counts] + tare_n
        both = {-1.0, 1.0} <= set(np.sign(before))
        # one that the thrust of every other row is less than may be full reverse
        both |= abs(tare_n) > _ALL_TARE * max(float(np.abs(before).max(initial=0.0)), largest)
        if one_sided and abs(tare_n) > _MOST_TARE * largest and both:
            say(_both_signs(table, before, codes))
            return None
        return np.ones(len(codes)), []
    number, total = int(wrong.sum()), int(counts.sum())
    if not (wrong & (codes > 0.0)).any() and not (right & (codes < 0.0)).any():
        say(
            table.place.warning(
                f"thrust is positive at all {number} negative codes: read as a size without sign, "
                "and given the sign of its code.",
                "negative thrust at negative codes.",
                "Write the minus signs if the thruster really pulled backwards.",
            )
        )
        return np.where(codes < 0.0, -1.0, 1.0), []
    if one_sided and number >= _LEAST_OF_A_SIGN and total - number >= _LEAST_OF_A_SIGN:
        say(_both_signs(table, thrust_n[counts], codes))
        return None
    if 2 * number > total:
        say(
            table.place.error(
                f"thrust has the sign opposite to its code in {number} of {total} rows; left out.",
                "positive thrust at positive codes.",
                "If the force sensor was mounted the other way round, say so in vehicle.yaml: "
                "columns: {mooring: {thrust: {header: <name of the column>, sign: -1}}}, or take "
                "that sign out if it is there.",
            )
        )
        return None
    against = [int(index) for index in np.flatnonzero(wrong)]
    named = [table.readings[index].row for index in against]
    what = f"thrust has the sign opposite to its code in {listed(named)}; left out."
    expected, remedy = "positive thrust at positive codes.", "Correct the sign or the code."
    say(table.at(named[0]).warning(what, expected, remedy))
    return np.ones(len(codes)), against


def _both_signs(table: Table, thrust_n: FloatArray, codes: FloatArray) -> Problem:
    against = int((thrust_n * (-1.0 if codes.min() < 0.0 else 1.0) < 0.0).sum())
    return table.place.error(
        f"thrust has both signs ({against} of {thrust_n.size} rows against the code), and the "
        "codes have one: rest is not at code 0, or something else parts the rows. So the table was "
        "left out.",
        "codes with signs, 0 at rest.",
        "Write the codes with signs, or state the column of the direction in vehicle.yaml: "
        "columns: {mooring: {direction: {header: ..., reverse: [...]}}}.",
    )


def _signed_shaft_speed(table: Table, codes: FloatArray) -> list[float | None]:
    """Give the shaft speed the sign of its code where it was read without one. [rpm]."""
    speeds = numbers(table.readings, "shaft_speed")
    turning = np.isfinite(speeds) & (speeds != 0.0) & (codes != 0.0)
    number, total = int((turning & (speeds * codes < 0.0)).sum()), int(turning.sum())
    if number and np.all(speeds[turning] > 0.0):
        what = "shaft speed is given without sign: it takes the sign of its code."
        table.problems.append(table.place.note(what))
        speeds = np.where(codes < 0.0, -speeds, speeds)
    elif 0 < number == total:
        what = "shaft speed is negative at positive codes: its sign was turned round."
        table.problems.append(table.place.note(what))
        speeds = -speeds
    elif number:
        what = f"shaft speed has the sign opposite to its code in {number} of {total} rows."
        table.problems.append(table.place.warning(what, "", "Check these rows."))
    # adding 0.0 turns -0.0 into 0.0
    return [None if np.isnan(one) else float(one) + 0.0 for one in speeds]


def sweeps(codes: Sequence[float]) -> tuple[Sweep, ...]:
    """Tell for each reading, in the order taken, whether the size of the code rose or fell.

    A reading at the same code as the one before belongs to the same sweep; the first one takes
    the sense of what follows; a change of sign passes zero, so what follows it rises.

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
    """Interpolate what was read at code 0 (k,) over the order of rows (n,), constant outside.

    >>> tare(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 2.0]), np.array([0.1, 0.3])).round(3)
    array([0.1, 0.2, 0.3, 0.3])
    """
    if len(zero_positions) == 0:
        return np.zeros(len(positions))
    return np.interp(positions, zero_positions, zero_readings)


def hysteresis(points: Sequence[MooringPoint]) -> float | None:
    """Return the mean thrust of falling sweeps less that of rising ones. [N].

    At equal code and voltage, over the codes that were passed both ways; None if there are none.
    Thrust counts in the sense of the code, so that both directions add up.
    """
    groups = voltage_groups(point.voltage_v for point in points if point.voltage_v is not None)
    held: dict[tuple[float, float | None], dict[Sweep, list[float]]] = defaultdict(
        lambda: {"up": [], "down": []}
    )
    for point in points:
        volts = point.voltage_v
        if point.code != 0.0:
            within = (low for low, high in groups if volts is not None and low <= volts <= high)
            size = point.thrust_n if point.code > 0 else -point.thrust_n
            held[(round(point.code, 6), next(within, None))][point.sweep].append(size)
    differences = [
        float(np.mean(both["down"]) - np.mean(both["up"]))
        for both in held.values()
        if both["up"] and both["down"]
    ]
    return float(np.mean(differences)) if differences else None
