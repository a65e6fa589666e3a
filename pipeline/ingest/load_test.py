"""Load tests of a drive: speed and torque for each control code, from workbooks and text files."""

from collections.abc import Hashable, Iterator, Sequence
from itertools import groupby
from pathlib import Path

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import BenchFile
from pipeline.ingest.bench_kind import Kind, read_files
from pipeline.ingest.bench_table import Step, Table
from pipeline.ingest.command_signs import check_signs, with_signs_of_codes
from pipeline.ingest.commands import codes_in_range, command_in_codes, few_codes, pwm_problems
from pipeline.ingest.load_test_checks import (
    check_constant,
    check_magnitudes,
    check_powers,
    odd_codes,
    torque_not_written,
    torque_of_current,
)
from pipeline.ingest.load_test_rows import WARM_UP, mark_early, row_words, tell_codes, with_words
from pipeline.ingest.load_test_sweeps import (
    two_curves,
    with_branches,
)
from pipeline.ingest.load_test_words import BRANCH_WORDS, REQUIRED
from pipeline.ingest.rig_factors import factor_unclear
from pipeline.ingest.row_directions import with_signed_codes
from pipeline.ingest.rows import counted
from pipeline.ingest.settled_steps import settle_loads
from pipeline.records.base import Source
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord
from pipeline.vehicle.schema import Vehicle


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
    name="load_test",
    looked_for="table of torque against shaft speed",
    required=REQUIRED,
    steps=_take_steps,
    points=_points,
    summary=_summary,
    remarks=_remarks,
    over_all=_over_all,
    compared=("shaft speed", _curves_of),
    row_words=row_words,
    shared=frozenset({"code"}),
    split_words=BRANCH_WORDS,
)
