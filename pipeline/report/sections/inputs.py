"""What came in: files, sheets, columns, units, and what became of every point."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence

from pipeline.records.base import Source
from pipeline.records.measurements import (
    LoadTestRecord,
    MooringRecord,
    OpenWaterRecord,
    SheetRead,
)
from pipeline.report.blocks import Block, Details, Heading, Paragraph, Section, Table
from pipeline.report.numbers import code, fixed, general, plural, signed
from pipeline.report.results import VehicleResults, mooring_points_of_tables

#: With more sheets than this the table goes by file and the sheets are folded away.
SHEETS_SHOWN = 8

Marked = tuple[Source, tuple[str, ...]]


def inputs_section(results: VehicleResults) -> Section:
    """Show the three kinds of raw file as they were understood."""
    kinds: tuple[tuple[str, str, LoadTestRecord | MooringRecord | OpenWaterRecord | None], ...] = (
        ("Load test of the drive", "load_test", results.load_test),
        ("Mooring test", "mooring", results.mooring),
        ("Open-water curves", "open_water", results.open_water),
    )
    blocks: list[Block] = []
    for title, stage, record in kinds:
        kind = stage.replace("_", "-")
        blocks.append(Heading(title, f"inputs-{kind}"))
        if record is None:
            reason = results.missing.get(stage) or f"There is no {kind} data."
            blocks.append(Paragraph(reason, tone="warning"))
            continue
        if isinstance(record, LoadTestRecord):
            texts = [_load_test(record)]
        elif isinstance(record, MooringRecord):
            texts = _mooring(results, record)
        else:
            texts = [_open_water(record)]
        marked = [(point.source, point.marks) for point in record.points]
        blocks += [*map(Paragraph, texts), *_tables(record.sheets, marked)]
    return Section("inputs", "What came in", tuple(blocks))


def _load_test(record: LoadTestRecord) -> str:
    used = [point for point in record.points if not point.marks]
    codes = sorted({point.code for point in used if point.code is not None})
    loading = sum(point.branch == "loading" for point in used)
    text = f"{_usage(record.points, used)} {_codes(codes)}"
    if used:
        text += (
            f" {plural(loading, 'point')} with rising load, {len(used) - loading} with falling "
            f"load; shaft speed {fixed(min(abs(p.shaft_speed_rpm) for p in used), 0)} to "
            f"{fixed(max(abs(p.shaft_speed_rpm) for p in used), 0)} rpm, torque "
            f"{general(min(abs(p.torque_nm) for p in used))} to "
            f"{general(max(abs(p.torque_nm) for p in used))} N m."
        )
    return text


def _mooring(results: VehicleResults, record: MooringRecord) -> list[str]:
    used = [point for point in record.points if not point.marks]
    codes = sorted({point.code for point in used})
    text = f"{_usage(record.points, used)} {_codes(codes)}"
    if used:
        voltages = sorted({round(p.voltage_v, 1) for p in used if p.voltage_v is not None})
        text += (
            f" Thrust {fixed(min(p.thrust_n for p in used), 1)} to "
            f"{fixed(max(p.thrust_n for p in used), 1)} N."
        )
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
    return [text, f"{sweeps} {drift}"]


def _open_water(record: OpenWaterRecord) -> str:
    used = [point for point in record.points if not point.marks]
    text = _usage(record.points, used)
    if used:
        text += (
            f" J from {fixed(min(p.advance_ratio for p in used), 3)} to "
            f"{fixed(max(p.advance_ratio for p in used), 3)}."
        )
    return text


def _usage(points: Sequence[object], used: Sequence[object]) -> str:
    left_out = len(points) - len(used)
    return f"{plural(len(points), 'point')} read, {len(used)} used, {left_out} left out."


def _codes(codes: Sequence[float]) -> str:
    if not codes:
        return "No usable code."
    listed = (
        ", ".join(code(value) for value in codes)
        if len(codes) <= 30
        else f"{code(codes[0])} to {code(codes[-1])}"
    )
    return f"{plural(len(codes), 'code')}: {listed}."


def _tables(sheets: Sequence[SheetRead], points: Sequence[Marked]) -> list[Block]:
    table = _sheet_table(sheets, points)
    blocks: list[Block] = (
        [table]
        if len(sheets) <= SHEETS_SHOWN
        else [
            _file_table(sheets, points),
            Details(f"The same by sheet ({plural(len(sheets), 'sheet')})", (table,)),
        ]
    )
    left_out = [(source, marks) for source, marks in points if marks]
    if left_out:
        blocks.append(
            Details(
                f"{plural(len(left_out), 'point')} left out, by row", (_left_out_table(left_out),)
            )
        )
    if any(sheet.columns for sheet in sheets):
        blocks.append(Details("Columns and units as understood", (_column_table(sheets),)))
    return blocks


def _sheet_table(sheets: Sequence[SheetRead], points: Sequence[Marked]) -> Table:
    used: Counter[tuple[str, str | None]] = Counter()
    reasons: defaultdict[tuple[str, str | None], Counter[str]] = defaultdict(Counter)
    for source, marks in points:
        key = (source.file, source.sheet)
        if marks:
            reasons[key].update(marks)
        else:
            used[key] += 1
    return Table(
        "Sheets and what became of their points",
        ("File", "Worksheet", "Understood as", "Used", "Left out, by reason"),
        tuple(
            (
                sheet.file,
                sheet.sheet if sheet.sheet is not None else "–",
                sheet.summary,
                str(used[sheet.file, sheet.sheet]),
                _counted(reasons[sheet.file, sheet.sheet]),
            )
            for sheet in sheets
        ),
    )


def _file_table(sheets: Sequence[SheetRead], points: Sequence[Marked]) -> Table:
    rows = []
    for file in dict.fromkeys(sheet.file for sheet in sheets):
        own = [marks for source, marks in points if source.file == file]
        reasons = Counter(mark for marks in own for mark in marks)
        used = sum(not marks for marks in own)
        count = sum(sheet.file == file for sheet in sheets)
        rows.append((file, str(count), str(len(own)), str(used), _counted(reasons)))
    return Table(
        "Files and what became of their points",
        ("File", "Sheets", "Points", "Used", "Left out, by reason"),
        tuple(rows),
    )


def _counted(reasons: Counter[str]) -> str:
    return ", ".join(f"{count} {mark}" for mark, count in sorted(reasons.items())) or "–"


def _left_out_table(left_out: Sequence[Marked]) -> Table:
    rows: defaultdict[tuple[str, str | None, str], list[int]] = defaultdict(list)
    for source, marks in left_out:
        rows[source.file, source.sheet, ", ".join(marks)].append(source.row)
    return Table(
        "Points left out, by row",
        ("File", "Worksheet", "Rows", "Why"),
        tuple(
            (file, sheet if sheet is not None else "–", row_ranges(numbers), mark)
            for (file, sheet, mark), numbers in rows.items()
        ),
    )


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


def _column_table(sheets: Sequence[SheetRead]) -> Table:
    # sheets of one file mostly share their layout: one row for each distinct reading of a column
    where: defaultdict[tuple[str, ...], list[str]] = defaultdict(list)
    for sheet in sheets:
        for column in sheet.columns:
            key = (
                sheet.file,
                column.quantity,
                column.header,
                column.column,
                column.unit,
                column.unit_from,
            )
            where[key].append(sheet.sheet if sheet.sheet is not None else "–")
    return Table(
        "Columns and units as understood",
        ("File", "Sheets", "Quantity", "Column header", "Column", "Unit", "Unit taken from"),
        tuple((key[0], _shortened(names), *key[1:]) for key, names in where.items()),
    )


def _shortened(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 3 else f"{names[0]} … {names[-1]} ({len(names)})"
