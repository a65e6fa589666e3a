"""The raw files: what went wrong there, what came in, and what became of every point."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.records.base import Source
from pipeline.records.fits import Check
from pipeline.records.measurements import (
    LoadTestPoint,
    LoadTestRecord,
    MooringRecord,
    OpenWaterRecord,
    SheetRead,
)
from pipeline.report.blocks import Block, Blocks, Bullets, Details, Heading, Table, Text, chapter
from pipeline.report.numbers import code, fixed, general, plural, signed
from pipeline.report.results import (
    STAGE_TITLES,
    VehicleResults,
    all_checks,
    all_problems,
    missing_reasons,
    mooring_points_of_tables,
)

#: With more sheets than this the table is folded away.
SHEETS_SHOWN = 8

Marked = tuple[Source, tuple[str, ...]]


@chapter("inputs", "What came in")
def inputs_section(results: VehicleResults) -> Blocks:
    """Show the three kinds of raw file as they were understood."""
    kinds: tuple[tuple[str, str, LoadTestRecord | MooringRecord | OpenWaterRecord | None], ...] = (
        ("Load test of the drive", "load_test", results.load_test),
        ("Mooring test", "mooring", results.mooring),
        ("Open-water curves", "open_water", results.open_water),
    )
    for title, stage, record in kinds:
        kind = stage.replace("_", "-")
        yield Heading(title, f"inputs-{kind}")
        if record is None:
            reason = results.missing.get(stage) or f"There is no {kind} data."
            yield Text(reason, tone="warning")
            continue
        used = sum(not point.marks for point in record.points)
        text = (
            f"{plural(len(record.points), 'point')} read, {used} used, "
            f"{len(record.points) - used} left out."
        )
        if isinstance(record, LoadTestRecord):
            text += _load_test([point for point in record.points if not point.marks])
        elif isinstance(record, MooringRecord):
            text += _mooring(results, record)
        elif ratios := [p.advance_ratio for p in record.points if not p.marks]:
            text += f" J from {fixed(min(ratios), 3)} to {fixed(max(ratios), 3)}."
        yield Text(text)
        yield from _tables(record.sheets, [(point.source, point.marks) for point in record.points])


def _load_test(used: Sequence[LoadTestPoint]) -> str:
    text = _codes(point.code for point in used)
    if not used:
        return text
    loading = sum(point.branch == "loading" for point in used)
    rpm, torque = np.sort(np.abs([(p.shaft_speed_rpm, p.torque_nm) for p in used]), axis=0).T
    counted = (
        f"{plural(loading, 'point')} with rising load, {len(used) - loading} with falling "
        f"load; shaft speed {fixed(rpm[0], 0)} to {fixed(rpm[-1], 0)} rpm, torque "
        f"{general(torque[0])} to {general(torque[-1])} N m."
    )
    return f"{text} {counted}"


def _mooring(results: VehicleResults, record: MooringRecord) -> str:
    used = [point for point in record.points if not point.marks]
    text = _codes(point.code for point in used)
    if used:
        thrust = [p.thrust_n for p in used]
        voltages = sorted({round(p.voltage_v, 1) for p in used if p.voltage_v is not None})
        text += f" Thrust {fixed(min(thrust), 1)} to {fixed(max(thrust), 1)} N."
        if voltages:
            upper = f" to {fixed(voltages[-1], 1)}" if len(voltages) > 1 else ""
            text += f" Supply {fixed(voltages[0], 1)}{upper} V."
        wanted = results.vehicle.tables.supply_voltage_v
        chosen = len(mooring_points_of_tables(results))
        if wanted is not None and chosen < len(used):
            text += f" The tables are for {general(wanted)} V: {plural(chosen, 'point')} of these."
    sweeps = (
        "Only one direction of sweep was flown: hysteresis is unknown."
        if record.hysteresis_n is None
        else "Hysteresis: at equal code the falling sweeps read "
        f"{signed(record.hysteresis_n, 2)} N against the rising ones on average."
    )
    drift = (
        "No reading at code 0 was repeated: the drift of the tare is unknown."
        if record.tare_drift_n is None
        else f"Tare: the reading at code 0 moved by up to {fixed(record.tare_drift_n, 2)} N "
        "within a file; it was subtracted."
    )
    return f"{text} {sweeps} {drift}"


def _codes(every: Iterable[float | None]) -> str:
    codes = sorted({one for one in every if one is not None})
    if not codes:
        return " No usable code."
    listed = (
        ", ".join(map(code, codes))
        if len(codes) <= 30
        else f"{code(codes[0])} to {code(codes[-1])}"
    )
    return f" {plural(len(codes), 'different code')}: {listed}."


def _tables(sheets: Sequence[SheetRead], points: Sequence[Marked]) -> Blocks:
    """Say what became of the points, folded where there are many sheets, and how it was read."""
    reasons: defaultdict[tuple[str, str | None], Counter[str]] = defaultdict(Counter)
    used: Counter[tuple[str, str | None]] = Counter()
    rows: defaultdict[tuple[str, str | None, str], list[int]] = defaultdict(list)
    for source, marks in points:
        reasons[source.file, source.sheet].update(marks)
        used[source.file, source.sheet] += not marks
        if marks:
            rows[source.file, source.sheet, ", ".join(marks)].append(source.row)
    table = Table.of(
        "Sheets and what became of their points",
        sheets,
        lambda one: {
            "File": one.file,
            "Worksheet": one.sheet or "–",
            "Understood as": one.summary,
            "Used": str(used[one.file, one.sheet]),
            "Left out, by reason": ", ".join(
                f"{n} {mark}" for mark, n in sorted(reasons[one.file, one.sheet].items())
            )
            or "–",
        },
    )
    many = f"{plural(len(sheets), 'sheet')} and what became of their points"
    yield table if len(sheets) <= SHEETS_SHOWN else Details(many, (table,))
    if rows:
        left_out = [
            {"File": file, "Worksheet": sheet or "–", "Rows": row_ranges(own), "Why": mark}
            for (file, sheet, mark), own in rows.items()
        ]
        many = plural(sum(map(len, rows.values())), "point")
        table = Table.of("Points left out, by row", left_out)
        yield Details(f"{many} left out, by row", (table,))
    # sheets of one file mostly share their layout: one row for each distinct reading of a column
    where: defaultdict[tuple[str, ...], list[str]] = defaultdict(list)
    for sheet in sheets:
        for column in sheet.columns:
            read = (column.quantity, column.header, column.column, column.unit, column.unit_from)
            where[sheet.file, *read].append(sheet.sheet if sheet.sheet is not None else "–")
    if where:
        found = [
            (file, ", ".join(o) if len(o) <= 3 else f"{o[0]} … {o[-1]} ({len(o)})", *read)
            for (file, *read), o in where.items()
        ]
        table = Table.of(
            "Columns and units as understood",
            found,
            "File: {0} | Sheets: {1} | Quantity: {2} | Column header: {3} | Column: {4} | "
            "Unit: {5} | Unit taken from: {6}",
        )
        yield Details("Columns and units as understood", (table,))


def row_ranges(rows: Iterable[int]) -> str:
    """Write row numbers with runs shortened.

    >>> row_ranges([9, 4, 5, 6, 12])
    '4–6, 9, 12'
    """
    runs: list[list[int]] = []
    for row in sorted(set(rows)):
        if runs and row == runs[-1][1] + 1:
            runs[-1][1] = row
        else:
            runs.append([row, row])
    return ", ".join(str(a) if a == b else f"{a}–{b}" for a, b in runs)


#: More places than this with the same message are counted instead of listed in the first table.
PLACES_SHOWN = 4


@chapter("warnings", "Warnings")
def warnings_section(results: VehicleResults) -> Blocks:
    """List problems by severity, failed checks and missing results; notes are folded away."""
    problems, checks, missing = all_problems(results), all_checks(results), missing_reasons(results)
    failed, passed = (
        [own for own in checks if own[1].passed is wanted] for wanted in (False, True)
    )
    none = "No errors or warnings in the raw files."
    yield from problem_blocks("Problems in the raw files", problems, none)
    if failed:
        yield _checks("Checks that failed", failed)
    elif checks:
        yield Text(f"All {len(checks)} physical and numerical checks passed.")
    if missing:
        yield Table.of(
            "Results that could not be computed",
            missing.items(),
            lambda own: {"Result": STAGE_TITLES[own[0]], "Why": own[1]},
            lambda _: True,
        )
    if results.notes:
        yield Bullets(results.notes)
    yield note_block(problems)
    if passed:
        table = _checks("Checks that passed", passed)
        yield Details(f"{plural(len(passed), 'check')} passed", (table,))


def _checks(caption: str, checks: Sequence[tuple[str, Check]]) -> Table:
    return Table.of(
        caption,
        checks,
        "Result: {0} | Check: {1.name} | What was found: {1.text}",
        lambda own: not own[1].passed,
    )


def problem_blocks(caption: str, problems: Sequence[Problem], none: str) -> Blocks:
    """Tabulate errors and warnings, and list the places that the table counts."""
    serious = [problem for problem in problems if problem.severity != "note"]
    yield _problem_table(caption, serious, PLACES_SHOWN) if serious else Text(none)
    for (_, what, _, _), places in _grouped(serious).items():
        if len(places) > PLACES_SHOWN:
            yield Details(f"All {len(places)} places: {what}", (Bullets(tuple(places)),))


def note_block(problems: Sequence[Problem]) -> Block | None:
    """Fold away what was assumed; nothing where there is nothing."""
    notes = [problem for problem in problems if problem.severity == "note"]
    table = _problem_table("Notes", notes, len(notes))
    return (
        Details(f"{plural(len(table.rows), 'note')}: what was assumed", (table,)) if notes else None
    )


def _problem_table(caption: str, problems: Sequence[Problem], shown: int) -> Table:
    """Group problems with the same message; places beyond those shown are counted."""

    def places(own: list[str]) -> str:
        first, rest = "; ".join(own[:shown]), len(own) - shown
        if len(own) == 1:
            return first
        return (
            f"each of {first}" if rest <= 0 else f"each of {first}; and {rest} more, listed below"
        )

    return Table.of(
        caption,
        _grouped(problems).items(),
        lambda own: {
            "Severity": own[0][0],
            "Where": places(own[1]),
            "What": own[0][1],
            "Expected": own[0][2] or "–",
            "What to do": own[0][3] or "–",
        },
        lambda own: own[0][0],
    )


def _grouped(problems: Sequence[Problem]) -> dict[tuple[str, str, str, str], list[str]]:
    groups: dict[tuple[str, str, str, str], list[str]] = {}
    for problem in problems:
        key = (problem.severity, problem.what, problem.expected, problem.remedy)
        groups.setdefault(key, []).append(str(problem.place))
    return groups
