"""Load tests of a drive: speed and torque for each control code, from workbooks and text files."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import FoundTable
from pipeline.ingest.bench_kind import FileFound, Kind, read_files
from pipeline.ingest.blocks import Block
from pipeline.ingest.commands import codes_in_range, command_in_codes, pwm_problems
from pipeline.ingest.load_test_checks import check_magnitudes, check_powers, drop_dead_channels
from pipeline.ingest.load_test_rows import (
    WARM_UP,
    RowWords,
    TableCode,
    codes_of_blocks,
    mark_early,
    row_words,
    with_words,
)
from pipeline.ingest.load_test_signs import check_signs, two_curves, with_signs_of_codes
from pipeline.ingest.load_test_sweeps import mark_drift, with_branches
from pipeline.ingest.load_test_words import ANY_POWER, BRANCH_WORDS, REQUIRED, VOCABULARY
from pipeline.ingest.readings import Reading
from pipeline.ingest.repeats import BenchTable
from pipeline.ingest.row_directions import with_signed_codes
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.settled_steps import settle_loads
from pipeline.ingest.usable import is_refused
from pipeline.ingest.vocabulary import name_score, split_header, unit_fits
from pipeline.records.base import Source
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord
from pipeline.vehicle.schema import Vehicle


def read_load_tests(paths: Sequence[Path], vehicle: Vehicle, raw_root: Path) -> LoadTestRecord:
    """Read all load-test files of a vehicle.

    A file or sheet that cannot be read becomes a problem of the record; the others are read.

    Parameters
    ----------
    paths : sequence of Path
        The files, xlsx or text.
    vehicle : Vehicle
        Mapping of columns, range of codes, propeller.
    raw_root : Path
        Folder of all vehicles' raw files; sources are named relative to it.

    Returns
    -------
    LoadTestRecord
        Points in rpm, N m, A, V, W with marks, what was read of each table, and all problems.
    """
    read = read_files(_KIND, sorted(paths), vehicle, raw_root)
    return LoadTestRecord(points=read.points, sheets=read.sheets, problems=read.problems)


def _tables(file: FileFound) -> list[BenchTable]:
    """Read the tables of a file, sheet by sheet: a heading may state the code of several."""
    tables: list[BenchTable] = []
    for _, of_sheet in groupby(file.tables, key=lambda one: one.block.sheet.name):
        own = list(of_sheet)
        blocks, code_max = [one.block for one in own], file.vehicle.drive.code_max
        codes = codes_of_blocks(blocks, file.path, code_max, file.problems)
        for one, code in zip(own, codes, strict=True):
            readings = _read_table(one, code, file.vehicle, file.problems)
            tables.append(BenchTable(one.block.place(), tuple(readings), code.found_in))
    return tables


def _read_table(
    found: FoundTable, code: TableCode, vehicle: Vehicle, problems: list[Problem]
) -> list[Reading]:
    """Tell code, direction, branch and steadiness of a table's readings, and check them.

    Returns the readings in the order of the rows, marked where they are not to be fitted; none of
    a table that is left out. `code` is that of the table, where no column holds it.
    """
    block, readings, words = found.block, found.readings, found.words or RowWords()
    mapping, drive = vehicle.columns.load_test, vehicle.drive
    problems += words.problems
    wrong = pwm_problems(block, readings, vehicle, "shaft_speed")
    problems += wrong
    if is_refused([*words.problems, *wrong]):
        return []
    done = command_in_codes(block, readings, vehicle, "load_test", problems)
    done = with_words(done, words, code.value, drive.code_max)
    if mapping.warm_up_s is not None:
        done = mark_early(done, mapping.warm_up_s)
    steps = settle_loads(block.place(), done)
    problems += steps.problems
    signed = with_signed_codes(block, steps.readings, mapping.direction, "load_test", problems)
    if signed is None or is_refused(steps.problems):
        return []
    done = signed
    for check in (with_signs_of_codes, drop_dead_channels, _sweeps, check_signs):
        done, wrong = check(block, done)
        problems += wrong
    done = codes_in_range(block, done, drive, problems)
    curves = two_curves(block, done)
    if curves is not None:
        problems.append(curves)
        return []
    problems += check_powers(block, done)
    problems += check_magnitudes(
        block, done, vehicle.water.density_kgpm3, vehicle.propeller.diameter_m
    )
    problems += [*_no_clock(block, readings, mapping.warm_up_s), *_powers_not_read(block)]
    return done


def _no_clock(block: Block, readings: Sequence[Reading], warm_up_s: float | None) -> list[Problem]:
    if warm_up_s is None or any("time" in one.values for one in readings):
        return []
    what = f"vehicle.yaml states warm_up_s: {warm_up_s:g}, but there is no time to count it by."
    remedy = "Add one, or mark the rows with a word (warm-up) in a column named status."
    return [Problem("warning", block.place(block.header_row), what, "a time column.", remedy)]


def _sweeps(block: Block, readings: Sequence[Reading]) -> tuple[list[Reading], list[Problem]]:
    """Tell branches and warm-up, code by code, in the order of the rows."""
    by_code: dict[float | None, list[int]] = {}
    for index, reading in enumerate(readings):
        if not reading.marks:
            by_code.setdefault(reading.values.get("code"), []).append(index)
    done = list(readings)
    problems: list[Problem] = []
    for code, indices in by_code.items():
        sweep, drifting = mark_drift([readings[index] for index in indices])
        if drifting:
            rows = [reading.row for reading in sweep[:drifting]]
            problems.append(
                Problem(
                    "note",
                    block.place(rows[0]),
                    f"{listed(rows)}{_at(code)}: no load and a speed that still drifts; taken for "
                    "warm-up and not fitted.",
                    "",
                    "To say it yourself, add a time column and warm_up_s in vehicle.yaml, or a "
                    'column "status".',
                )
            )
        settled = with_branches(sweep[drifting:])
        for index, reading in zip(indices, [*sweep[:drifting], *settled], strict=True):
            done[index] = reading
    return done, problems


def _at(code: float | None) -> str:
    return "" if code is None else f", code {code:g}"


def _powers_not_read(block: Block) -> list[Problem]:
    return [
        Problem(
            "note",
            block.place(block.header_row),
            f'"{header}" says neither input nor output power; it was not read.',
            "input (electric) or output (shaft) power in the name.",
            "Rename it, or state it in vehicle.yaml under columns: load_test: input_power or "
            "output_power.",
        )
        for header in (one.header for one in block.columns_not_used(None))
        if _is_power(header)
    ]


def _is_power(header: str) -> bool:
    return any(
        name_score(text, ANY_POWER) > 0 and (text.unit is None or unit_fits(text.unit, ANY_POWER))
        for text in split_header(header)
    )


def _points(_file: FileFound, tables: Sequence[BenchTable]) -> list[tuple[LoadTestPoint, ...]]:
    return [tuple(_point(table.place, one) for one in table.readings) for table in tables]


def _point(place: Place, one: Reading) -> LoadTestPoint:
    values = one.values
    return LoadTestPoint(
        source=Source(file=place.file, sheet=place.sheet, row=one.row),
        code=values.get("code"),
        shaft_speed_rpm=values["shaft_speed"],
        torque_nm=values["torque"],
        current_a=values.get("current"),
        voltage_v=values.get("voltage"),
        input_power_w=values.get("input_power"),
        output_power_w=values.get("output_power"),
        branch=one.branch or "loading",
        marks=one.marks,
    )


def _remarks(file: Place, points: Sequence[LoadTestPoint]) -> list[Problem]:
    """Say what is said once for a file: no code, rows of warm-up."""
    problems: list[Problem] = []
    codeless = list(dict.fromkeys(one.source.sheet for one in points if one.code is None))
    if codeless:
        names = [f'"{name}"' for name in codeless if name is not None]
        on = f" on sheet{'s' if len(names) > 1 else ''} {', '.join(names)}" if names else ""
        problems.append(
            Problem(
                "warning",
                file,
                f"there is no control code{on}: neither a code column, nor a code in a heading, "
                "the sheet's name or the file's name. Speed and torque were read, but the drive's "
                "family M(n, N) cannot be fitted from them.",
                'a column "code", or "Code 90" as heading or sheet name.',
                "Name it in the file, or state the column in vehicle.yaml under columns: "
                "load_test: code.",
            )
        )
    warm = [point.source.sheet for point in points if WARM_UP in point.marks]
    if warm:
        on = counted(len(set(warm)), "sheet")
        what = f"warm-up: {counted(len(warm), 'row')} on {on}; kept but not fitted."
        problems.append(Problem("note", file, what))
    return problems


def _one_code(points: Sequence[LoadTestPoint], folder: Place, vehicle: Vehicle) -> list[Problem]:
    """Say where all files together have one code only."""
    codes = {point.code for point in points if point.code is not None}
    if len({abs(code) for code in codes}) != 1:
        return []
    what = (
        f"there is one control code only ({', '.join(f'{code:g}' for code in sorted(codes))}): "
        "the family M(n, N) over codes cannot be fitted."
    )
    expected = f"several codes between 0 and {vehicle.drive.code_max}."
    return [Problem("error", folder, what, expected, "Add the records of other codes.")]


def _summary(table: BenchTable, points: Sequence[LoadTestPoint]) -> str:
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


_KIND = Kind(
    name="load_test",
    noun="load-test",
    looked_for="table of torque against shaft speed",
    vocabulary=VOCABULARY,
    required=REQUIRED,
    tables=_tables,
    points=_points,
    summary=_summary,
    remarks=_remarks,
    over_all=_one_code,
    row_words=lambda block, vehicle: row_words(block, vehicle.drive.code_max),
    shared=frozenset({"code"}),
    split_words=BRANCH_WORDS,
    copies_by_row=True,
)
