"""One load-test table: readings with branches and marks, and what is odd about them."""

from collections.abc import Sequence
from dataclasses import replace

from pipeline.errors import Problem
from pipeline.ingest.bench_file import COMMENTED
from pipeline.ingest.blocks import Block
from pipeline.ingest.cells import is_number, shorten
from pipeline.ingest.code_units import fractional_codes
from pipeline.ingest.load_test_checks import (
    check_magnitudes,
    check_powers,
    check_signs,
    drop_dead_channels,
    with_signs_of_codes,
)
from pipeline.ingest.load_test_codes import TableCode
from pipeline.ingest.load_test_rows import LoadTestReading, read_rows, with_mark
from pipeline.ingest.load_test_sweeps import mark_drift, with_branches
from pipeline.ingest.load_test_words import ANY_POWER, Branch, branch_in_text
from pipeline.ingest.row_directions import against_codes, directions_of
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.vocabulary import name_score, split_header, unit_fits
from pipeline.vehicle.bench_schema import LoadTestColumns
from pipeline.vehicle.schema import Vehicle


def read_table(
    block: Block, code: TableCode, vehicle: Vehicle, mapping: LoadTestColumns
) -> tuple[list[LoadTestReading], list[Problem]]:
    """Read one table and check it.

    Parameters
    ----------
    block : Block
        Where it stands and what its columns are.
    code : TableCode
        Its control code, where no column holds it.
    vehicle : Vehicle
        Range of codes, propeller and water.
    mapping : LoadTestColumns
        What vehicle.yaml states about load tests.

    Returns
    -------
    tuple of (list of LoadTestReading, list of Problem)
        Readings in the order of the rows, marked where they are not to be fitted.
    """
    drive = vehicle.drive
    pwm = vehicle.columns.mooring.pwm_range
    rows = read_rows(block, code.value, _branch_of(block), (drive.code_max, pwm), mapping.warm_up_s)
    problems = list(rows.problems)
    readings = list(rows.readings)
    if not readings:
        cause = _without_points(block)
        return [], [cause] if cause.place.column else [*problems, cause]
    if mapping.warm_up_s is not None and all(reading.time_s is None for reading in readings):
        problems.append(
            Problem(
                "warning",
                block.place(block.header_row),
                f"vehicle.yaml states warm_up_s: {mapping.warm_up_s:g}, but there is no time to "
                "count it by.",
                "a time column.",
                "Add one, or mark the rows with a word (warm-up) in a column named status.",
            )
        )
    readings, wrong = _with_directions(block, readings, mapping)
    problems += wrong
    if not readings:
        return [], problems
    readings, wrong = with_signs_of_codes(block, readings)
    problems += wrong
    readings, wrong = drop_dead_channels(block, readings)
    problems += wrong
    readings, wrong = _sweeps(block, readings)
    problems += wrong
    readings, wrong = check_signs(block, readings)
    problems += wrong
    readings, wrong = _check_codes(block, readings, drive.code_min, drive.code_max)
    problems += wrong
    problems += [] if rows.in_shares else _fractional_codes(block, readings)
    problems += check_powers(block, readings)
    problems += check_magnitudes(
        block, readings, vehicle.water.density_kgpm3, vehicle.propeller.diameter_m
    )
    problems += _notes(block, readings)
    return readings, problems


def _with_directions(
    block: Block, readings: list[LoadTestReading], mapping: LoadTestColumns
) -> tuple[list[LoadTestReading], list[Problem]]:
    """Give codes without signs those of the direction that a column or a heading states."""
    codes = {one.row: one.code for one in readings if one.code is not None}
    if not codes:
        return readings, []
    found = directions_of(block, list(codes), mapping.direction, "load_test")
    if any(problem.severity == "error" for problem in found.problems):
        return ([] if min(codes.values()) >= 0.0 else readings), list(found.problems)
    signed, wrong = against_codes(block, codes, found)
    return (
        [replace(one, code=signed.get(one.row, one.code)) for one in readings],
        [*found.problems, *wrong],
    )


def _branch_of(block: Block) -> Branch | None:
    """Return the branch that a group heading, a heading or the sheet's name states."""
    torque = block.columns["torque"]
    headings = [cell for cell in block.above if isinstance(cell.value, str)]
    texts = [torque.header, torque.group, *(str(cell.value) for cell in reversed(headings))]
    for text in (*texts, block.sheet.name or ""):
        branch = branch_in_text(text)
        if branch is not None:
            return branch
    return None


def _without_points(block: Block) -> Problem:
    for quantity in ("torque", "shaft_speed"):
        column = block.columns[quantity]
        cells = [row[column.index] for _, row in block.rows() if column.index < len(row)]
        if not any(is_number(cell) for cell in cells):
            return Problem(
                "error",
                block.place(block.first_row, quantity),
                f"{quantity.replace('_', ' ')} holds no number in any of the "
                f"{block.last_row - block.first_row + 1} rows; the table was left out.",
                f"numbers in {column.unit_stated()}.",
                "Export the record again; formulas must be saved with their values.",
            )
    return Problem(
        "error",
        block.place(block.first_row),
        "no row has both a speed and a torque; the table was left out.",
        "speed and torque in every row.",
        "Export the record again.",
    )


def _sweeps(
    block: Block, readings: Sequence[LoadTestReading]
) -> tuple[list[LoadTestReading], list[Problem]]:
    """Tell branches and warm-up, code by code, in the order of the rows."""
    by_code: dict[float | None, list[int]] = {}
    for index, reading in enumerate(readings):
        if not reading.marks:
            by_code.setdefault(reading.code, []).append(index)
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


def _fractional_codes(block: Block, readings: Sequence[LoadTestReading]) -> list[Problem]:
    if "code" not in block.columns:
        return []
    codes = [(one.row, one.code) for one in readings if one.code is not None and not one.marks]
    return fractional_codes(codes, lambda row: block.place(row, "code"), "load_test")


def _check_codes(
    block: Block, readings: Sequence[LoadTestReading], code_min: int, code_max: int
) -> tuple[list[LoadTestReading], list[Problem]]:
    wrong = [
        reading
        for reading in readings
        if reading.code is not None and not code_min <= reading.code <= code_max
    ]
    if not wrong:
        return list(readings), []
    codes = sorted({reading.code for reading in wrong if reading.code is not None})
    problem = Problem(
        "warning",
        block.place(wrong[0].row, "code"),
        f"code {', '.join(f'{code:g}' for code in codes[:6])} is outside of the drive's range; the "
        f"{len(wrong)} points are kept but not fitted.",
        f"codes from {code_min} to {code_max}, as vehicle.yaml states for the drive.",
        "Correct the code in the file, or code_min and code_max in vehicle.yaml.",
    )
    rows = {reading.row for reading in wrong}
    marked = [
        with_mark(reading, "code out of range") if reading.row in rows else reading
        for reading in readings
    ]
    return marked, [problem]


def _notes(block: Block, readings: Sequence[LoadTestReading]) -> list[Problem]:
    notes: list[Problem] = []
    rows = [reading.row for reading in readings if COMMENTED in reading.marks]
    if rows:
        what = f'commented out with "#": {listed(rows)}; kept but not fitted.'
        notes.append(Problem("note", block.place(rows[0]), what))
    notes += [
        Problem(
            "note",
            block.place(block.header_row, quantity),
            f'no unit is stated for "{shorten(column.header)}"; {column.unit} was assumed.',
        )
        for quantity, column in block.columns.items()
        if column.unit_from == "assumed"
        and column.unit
        and column.quantity != "time"
        and column.unit.casefold() not in column.header.casefold()
    ]
    notes += [
        Problem(
            "note",
            block.place(block.header_row),
            f'"{header}" says neither input nor output power; it was not read.',
            "input (electric) or output (shaft) power in the name.",
            "Rename it, or state it in vehicle.yaml under columns: load_test: input_power or "
            "output_power.",
        )
        for header in block.other_headers
        if _is_power(header)
    ]
    return notes


def _is_power(header: str) -> bool:
    return any(
        name_score(text, ANY_POWER) > 0 and (text.unit is None or unit_fits(text.unit, ANY_POWER))
        for text in split_header(header)
    )


def summary(readings: Sequence[LoadTestReading], code: TableCode) -> str:
    """Return one line about a table, for a person."""
    codes = sorted({reading.code for reading in readings if reading.code is not None})
    if not codes:
        what = "no control code"
    elif len(codes) == 1:
        what = f"code {codes[0]:g} ({code.found_in})"
    else:
        what = f"{len(codes)} codes from {codes[0]:g} to {codes[-1]:g} ({code.found_in})"
    speeds = [reading.shaft_speed_rpm for reading in readings]
    torques = [reading.torque_nm for reading in readings]
    return (
        f"{what}, {counted(len(readings), 'point')}, {min(speeds):.0f} to {max(speeds):.0f} rpm, "
        f"{min(torques):.3g} to {max(torques):.3g} N m"
    )
