"""Load tests of a drive: speed and torque for each control code, from workbooks and text files."""

import math
from collections import defaultdict
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import BenchFile
from pipeline.ingest.bench_kind import Kind, read_files
from pipeline.ingest.bench_table import Reading, Step, Table, numbers
from pipeline.ingest.command_signs import check_signs, with_signs_of_codes
from pipeline.ingest.commands import codes_in_range, command_in_codes, few_codes, pwm_problems
from pipeline.ingest.header_rows import Wanted
from pipeline.ingest.load_test_checks import (
    check_constant,
    check_magnitudes,
    check_powers,
    odd_codes,
    torque_not_written,
    torque_of_current,
)
from pipeline.ingest.load_test_rows import WARM_UP, mark_early, row_words, tell_codes, with_words
from pipeline.ingest.load_test_words import BRANCH_WORDS, REQUIRED, Branch
from pipeline.ingest.rig_factors import factor_unclear
from pipeline.ingest.row_directions import with_signed_codes
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.settled_steps import settle_loads
from pipeline.records.base import Source
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

#: Two curves: readings of one group at least, how far apart of the largest speed, and of the
#: scatter about each. One curve, parted at its middle, is 2.6 times its scatter apart.
_LEAST_OF_TWO, _TWO_SHARE, _TWO_SIGMAS = 6, 0.05, 6.0
#: Share of the torque's range by which it must come back before the branch changes.
_TURN_SHARE = 0.08


def two_curves(table: Table) -> Iterator[Problem]:
    """Refuse a table whose drive turns at two speeds under one torque at most of its codes.

    Readings of one code, branch and voltage make one curve n(M). Rows that lie on two curves, far
    apart for how little each scatters, are of two directions, or of two drives: nothing in the
    table tells which.
    """
    groups: dict[tuple[object, ...], list[Reading]] = defaultdict(list)
    for one in table.live():
        volts = one.values.get("voltage")
        if one.values.get("code", 0.0) != 0.0:
            group = (one.values["code"], one.branch, volts and round(math.log(abs(volts)) / 0.1))
            groups[group].append(one)
    large = [own for own in groups.values() if len(own) >= _LEAST_OF_TWO]
    parted = [(own, apart) for own in large if (apart := _apart(own))]
    if not parted or 2 * len(parted) < len(large):
        return
    own, apart = max(parted, key=lambda one: one[1])
    yield table.leave_out(
        table.at(own[0].row, "shaft_speed").error(
            f"at code {own[0].values['code']:g} the shaft turns at two speeds under one torque, "
            f"{apart:.0f} rpm apart ({listed([one.row for one in own])}), and so at most codes: "
            "something parts the rows, such as a direction that no column states. So the table "
            "was left out.",
            "one characteristic in a table.",
            "Write reverse with negative codes, each test on a sheet of its own, or state the "
            "column of the direction in vehicle.yaml:\n  columns:\n    load_test:\n      "
            'direction: {header: "...", reverse: ["..."]}',
        )
    )


def _apart(own: Sequence[Reading]) -> float:
    """Return how far apart two curves of speed over torque are, 0 where there is one. [rpm]."""
    torque, speed = np.abs(numbers(own, "torque")), np.abs(numbers(own, "shaft_speed"))
    scale = float(torque.max())
    if scale == 0.0 or np.ptp(torque) < 0.2 * scale:
        return 0.0
    degree = 2 if len(own) >= 2 * _LEAST_OF_TWO else 1
    off = speed - np.polyval(_curve(torque / scale, speed, degree), torque / scale)
    if np.ptp(off) <= _TWO_SHARE * float(speed.max()):
        return 0.0  # no two rows are so far apart
    above = off > 0.0
    if min(above.sum(), (~above).sum()) < degree + 2:
        return 0.0
    curves = [_curve(torque[side] / scale, speed[side], degree) for side in (above, ~above)]
    rest = [
        speed[side] - np.polyval(curve, torque[side] / scale)
        for side, curve in zip((above, ~above), curves, strict=True)
    ]
    middle = float(np.median(torque / scale))
    apart = abs(float(np.polyval(curves[0], middle) - np.polyval(curves[1], middle)))
    scatter = float(np.sqrt(np.mean(np.concatenate(rest) ** 2)))
    return apart if apart > max(_TWO_SHARE * float(speed.max()), _TWO_SIGMAS * scatter) else 0.0


def _curve(x: FloatArray, y: FloatArray, degree: int) -> FloatArray:
    """Coefficients of the polynomial of least squares, the smallest ones where few x differ."""
    return np.asarray(np.linalg.lstsq(np.vander(x, degree + 1), y, rcond=None)[0])


def with_branches(table: Table) -> tuple[Problem, ...]:
    """Tell the branches that no word tells, code by code, in the order of the rows."""
    by_code: dict[float | None, list[int]] = defaultdict(list)
    for index, reading in enumerate(table.readings):
        if not reading.marks and reading.branch is None:
            by_code[reading.values.get("code")].append(index)
    for indices in by_code.values():
        torque = np.abs(numbers((table.readings[index] for index in indices), "torque"))
        for index, branch in zip(indices, branches_of(torque), strict=True):
            table.readings[index] = replace(table.readings[index], branch=branch)
    return ()


def branches_of(torque: FloatArray) -> list[Branch]:
    """Tell loading from unloading by turning points of the torque that exceed its scatter.

    `torque` (n,) are sizes in the order taken.

    >>> branches_of(np.array([0.0, 1.0, 2.0, 1.5, 0.5]))
    ['loading', 'loading', 'loading', 'unloading', 'unloading']
    """
    count = len(torque)
    if count == 0:
        return []
    turn = _TURN_SHARE * float(np.ptp(torque))
    if turn == 0.0:
        return ["loading"] * count
    branches: list[Branch] = []
    low = high = 0
    branch: Branch | None = None  # until the torque has moved by more than its scatter
    for index in range(count):
        high = index if torque[index] > torque[high] else high
        low = index if torque[index] < torque[low] else low
        if branch != "unloading" and torque[high] - torque[index] > turn:
            if branch is not None:
                branches += [branch] * (high + 1 - len(branches))
            branch, low = "unloading", index
        elif branch != "loading" and torque[index] - torque[low] > turn:
            if branch is not None:
                branches += [branch] * (low + 1 - len(branches))
            branch, high = "loading", index
    return branches + [branch or "loading"] * (count - len(branches))


def read_load_tests(paths: Sequence[Path], vehicle: Vehicle, raw_root: Path) -> LoadTestRecord:
    """Read all load-test files of a vehicle; sources are named relative to `raw_root`.

    A file or sheet that cannot be read becomes a problem of the record; the others are read.
    """
    read = read_files(_KIND, sorted(paths), vehicle, raw_root)
    return LoadTestRecord(points=read.points, sheets=read.sheets, problems=read.problems)


def _take_steps(file: BenchFile) -> None:
    """Go sheet by sheet: a heading may state the code of several tables."""
    for _, of_sheet in groupby(file.tables, key=lambda one: one.block.sheet.name):
        tables = list(of_sheet)
        tell_codes(tables, file.path)
        for table in tables:
            table.problems += table.words.problems
            table.take(_STEPS)


_STEPS: tuple[Step, ...] = (
    *(factor_unclear, pwm_problems, command_in_codes, with_words),
    *(mark_early, settle_loads, with_signed_codes, with_signs_of_codes),
    *(with_branches, check_signs, codes_in_range, torque_not_written),
    *(two_curves, check_powers, check_constant, torque_of_current),
)


def _points(file: BenchFile) -> list[tuple[LoadTestPoint, ...]]:
    return [
        tuple(
            LoadTestPoint(
                source=Source(file=table.place.file, sheet=table.place.sheet, row=one.row),
                code=one.values.get("code"),
                shaft_speed_rpm=one.values["shaft_speed"],
                torque_nm=one.values["torque"],
                current_a=one.values.get("current"),
                voltage_v=one.values.get("voltage"),
                input_power_w=one.values.get("input_power"),
                output_power_w=one.values.get("output_power"),
                branch=one.branch or "loading",
                marks=one.marks,
            )
            for one in table.readings
        )
        for table in file.tables
    ]


def _remarks(file: Place, points: Sequence[LoadTestPoint]) -> Iterator[Problem]:
    """Say what is said once for a file: no code, rows of warm-up."""
    codeless = list(dict.fromkeys(one.source.sheet for one in points if one.code is None))
    if codeless:
        names = [f'"{name}"' for name in codeless if name is not None]
        on = f" on sheet{'s' if len(names) > 1 else ''} {', '.join(names)}" if names else ""
        yield file.warning(
            f"there is no control code{on}: neither a code column, nor a code in a heading, "
            "the sheet's name or the file's name. Speed and torque were read, but the drive's "
            "family M(n, N) cannot be fitted from them.",
            'a column "code", or "Code 90" as heading or sheet name.',
            "Name it in the file, or state the column in vehicle.yaml under columns: "
            "load_test: code.",
        )
    warm = [point.source.sheet for point in points if WARM_UP in point.marks]
    if warm:
        on = counted(len(set(warm)), "sheet")
        yield file.note(f"warm-up: {counted(len(warm), 'row')} on {on}; kept but not fitted.")


def _over_all(
    points: Sequence[LoadTestPoint], folder: Place, vehicle: Vehicle
) -> Iterator[Problem]:
    codes = [one.code for one in points if one.code is not None]
    yield from few_codes(codes, folder, vehicle)
    yield from check_magnitudes(points, folder, vehicle)
    yield from odd_codes(points, folder)


def _summary(table: Table, points: Sequence[LoadTestPoint]) -> str:
    codes = sorted({one.code for one in points if one.code is not None})
    if not codes:
        what = "no control code"
    elif len(codes) == 1:
        what = f"code {codes[0]:g} ({table.code_from})"
    else:
        what = f"{len(codes)} codes from {codes[0]:g} to {codes[-1]:g} ({table.code_from})"
    speeds = [one.shaft_speed_rpm for one in points]
    torques = [one.torque_nm for one in points]
    return (
        f"{what}, {counted(len(points), 'point')}, {min(speeds):.0f} to {max(speeds):.0f} rpm, "
        f"{min(torques):.3g} to {max(torques):.3g} N m"
    )


def _curves_of(points: Sequence[LoadTestPoint]) -> dict[Hashable, dict[float, float]]:
    """Return the size of the shaft speed by code, voltage and size of the torque."""
    curves: dict[Hashable, dict[float, float]] = {}
    for one in points:
        volts = None if one.voltage_v is None else round(one.voltage_v)
        if one.code is not None:
            curves.setdefault((one.code, volts), {})[abs(one.torque_nm)] = abs(one.shaft_speed_rpm)
    return curves


_KIND = Kind(
    Wanted("load_test", REQUIRED, shared=frozenset({"code"}), split_words=BRANCH_WORDS),
    "table of torque against shaft speed",
    steps=_take_steps,
    points=_points,
    summary=_summary,
    remarks=_remarks,
    over_all=_over_all,
    compared=("shaft speed", _curves_of),
    row_words=row_words,
)
