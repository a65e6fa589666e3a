"""Load tests of a drive: speed and torque for each control code, from workbooks and text files."""

from collections.abc import Collection, Sequence
from itertools import groupby
from pathlib import Path

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import (
    BenchFile,
    mapped_columns,
    read_bench_file,
    source_name,
    without_copies,
)
from pipeline.ingest.blocks import Block
from pipeline.ingest.columns_stated import sheet_read
from pipeline.ingest.headers import Wanted
from pipeline.ingest.load_test_codes import codes_of_blocks
from pipeline.ingest.load_test_repeats import LoadTable, Repeats
from pipeline.ingest.load_test_rows import WARM_UP, RowWords, row_words
from pipeline.ingest.load_test_table import read_table, summary
from pipeline.ingest.load_test_words import BRANCH_WORDS, REQUIRED, VOCABULARY
from pipeline.ingest.readings import Reading
from pipeline.ingest.rows import counted
from pipeline.ingest.usable import with_cause
from pipeline.records.base import Source
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord, SheetRead
from pipeline.vehicle.schema import Vehicle

_LOOKED_FOR = "table of torque against shaft speed"


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
    columns = vehicle.columns.load_test
    wanted = Wanted(
        vocabulary=VOCABULARY,
        required=REQUIRED,
        kind="load_test",
        mapping=mapped_columns(columns),
        only=columns.only,
        shared=frozenset({"code"}),
        split_words=BRANCH_WORDS,
    )
    points: list[LoadTestPoint] = []
    sheets: list[SheetRead] = []
    kept, problems = without_copies(sorted(paths), raw_root)
    repeats = Repeats()
    for path in kept:
        words: dict[int, RowWords] = {}

        def headings_of(block: Block, words: dict[int, RowWords] = words) -> Collection[int]:
            words[id(block)] = row_words(block, vehicle.drive.code_max)
            return words[id(block)].headings

        shown_as = source_name(path, raw_root)
        found = read_bench_file(
            path, shown_as, wanted, columns, _LOOKED_FOR, headings_of=headings_of
        )
        said = list(found.problems)
        tables, read = _tables(found, path, words, vehicle, said)
        sheets += read
        tables = repeats.marked(tables, said)
        own = [_point(table.place, one) for table in tables for one in table.readings]
        points += own
        if not found.is_blank:
            said = with_cause(said, shown_as, [point.marks for point in own], "load-test")
        problems += [*said, *_of_file(Place(shown_as), own)]
    codes = {point.code for point in points if point.code is not None and not point.marks}
    if len({abs(code) for code in codes}) == 1:
        what = (
            f"there is one control code only ({', '.join(f'{code:g}' for code in sorted(codes))}): "
            "the family M(n, N) over codes cannot be fitted."
        )
        expected = f"several codes between 0 and {vehicle.drive.code_max}."
        folder = Place(source_name(min(paths).parent, raw_root))
        problems.append(Problem("error", folder, what, expected, "Add the records of other codes."))
    return LoadTestRecord(
        points=tuple(points), sheets=tuple(sheets), problems=tuple(dict.fromkeys(problems))
    )


def _tables(
    found: BenchFile,
    path: Path,
    words: dict[int, RowWords],
    vehicle: Vehicle,
    problems: list[Problem],
) -> tuple[list[LoadTable], list[SheetRead]]:
    """Read the tables of a file, sheet by sheet: a heading may state the code of several."""
    tables: list[LoadTable] = []
    read: list[SheetRead] = []
    for _, of_sheet in groupby(found.tables, key=lambda one: one[0].sheet.name):
        own = list(of_sheet)
        codes = codes_of_blocks([block for block, _ in own], path, vehicle.drive.code_max, problems)
        for (block, rows), code in zip(own, codes, strict=True):
            readings, wrong = read_table(block, rows, code, words[id(block)], vehicle)
            problems += wrong
            tables.append(LoadTable(block.sheet.place(), tuple(readings), code.found_in))
            said = summary(readings, code) if readings else "left out"
            read.append(sheet_read(block, vehicle.columns.load_test, len(readings), said))
    return tables, read


def _of_file(file: Place, points: Sequence[LoadTestPoint]) -> list[Problem]:
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
