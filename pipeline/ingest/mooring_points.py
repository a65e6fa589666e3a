"""From the readings of one mooring file to points: tare, signs, sweeps, and what is odd."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.ingest.bench_table import Sweep, Table, numbers
from pipeline.ingest.command_signs import signed_thrust
from pipeline.records.base import Source
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import voltage_groups

#: Share of the largest thrust above which a tare, or its change, is worth a word.
_LARGE_TARE_SHARE = 0.05


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
    turned = signed_thrust(table, codes, raw_n, used, at_rest)
    if turned is None:
        return ()
    signs, against = turned
    # at rest in the water a shaft turns as it is told, whatever the sign of its sensor
    speeds = np.abs(numbers(table.readings, "shaft_speed")) * np.where(codes < 0.0, -1.0, 1.0)
    told = iter(sweeps(codes[used].tolist()))
    sweep: Sweep = "up"
    points = []
    for at, one in enumerate(table.readings):
        # those that are not used take that of the row before
        sweep = next(told) if used[at] else sweep
        marks = (*one.marks, *("thrust against the code",) * bool(against[at]))
        points.append(
            MooringPoint(
                source=Source(file=table.place.file, sheet=table.place.sheet, row=one.row),
                code=float(codes[at]),
                thrust_n=float(raw_n[at] * signs[at]),
                tare_n=float(tare_n[at]) * float(signs[at]) + 0.0,  # no -0.0
                speed_mps=one.values.get("speed", 0.0),
                shaft_speed_rpm=None if np.isnan(speeds[at]) else float(speeds[at]) + 0.0,
                voltage_v=one.values.get("voltage", table.nominal_voltage_v),
                current_a=one.values.get("current"),
                thruster=table.block.thruster,
                sweep=table.sense or sweep,
                marks=marks or ("zero reading",) * bool(codes[at] == 0.0),
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
    if not len(zero_positions):
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
