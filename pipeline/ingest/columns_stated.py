"""What was understood of a table, as the lines of vehicle.yaml that would state it."""

from pipeline.ingest.blocks import Block, BlockColumn
from pipeline.ingest.row_directions import (
    RowDirections,
    block_rows,
    directions_of,
    reverse_texts,
)
from pipeline.records.measurements import SheetRead
from pipeline.vehicle.bench_schema import BenchColumns, Column, LoadTestColumns, MooringColumns


def sheet_read(block: Block, columns: BenchColumns, rows: int, summary: str) -> SheetRead:
    """Tell what was read of a table, which columns are not used, and what would state the others.

    What its section of vehicle.yaml states already is repeated as it is; `rows` are the readings in
    it, `summary` says what they are.
    """
    known = type(columns).model_fields
    lines = [
        (name, _line(column, getattr(columns, name)))
        for name, column in block.columns.items()
        if name in known
    ]
    found = row_directions(block, columns)
    at = None if found is None else found.column
    if found is not None and at is not None:
        head = block.sheet.cell(block.header_row, at)
        back = ", ".join(map(quoted, reverse_texts(block, found)))
        lines.append(("direction", f"{{header: {quoted(str(head))}, reverse: [{back}]}}"))
    return SheetRead(
        file=block.sheet.file,
        sheet=block.sheet.name,
        rows=rows,
        columns=tuple(column.as_record() for column in block.columns.values()),
        summary=summary,
        not_used=block.columns_not_used(at),
        stated_as=tuple(lines),
    )


def row_directions(block: Block, columns: BenchColumns) -> RowDirections | None:
    """Return the directions of the rows that are applied, None where there are none."""
    if not isinstance(columns, (LoadTestColumns, MooringColumns)):
        return None
    kind = "mooring" if isinstance(columns, MooringColumns) else "load_test"
    found = directions_of(block, block_rows(block), columns.direction, kind)
    return found if found.signs else None


def quoted(text: str) -> str:
    r"""Return a text as YAML has it in double quotes.

    >>> print(quoted('a "b"'))
    "a \"b\""
    """
    escaped = " ".join(text.split()).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _line(column: BlockColumn, stated: Column | None) -> str:
    parts = [f"header: {quoted(column.header)}"]
    if column.unit and column.unit != "1":
        parts.append(f"unit: {quoted(column.unit)}")
    if column.sign < 0:
        parts.append("sign: -1")
    if stated is not None:
        parts += [f"scale: {stated.scale:g}"] if stated.scale != 1.0 else []
        parts += [f"pole_pairs: {stated.pole_pairs}"] if stated.pole_pairs is not None else []
        plus = ", ".join(map(quoted, stated.plus))
        parts += [f"plus: [{plus}]"] if plus else []
    return "{" + ", ".join(parts) + "}"
