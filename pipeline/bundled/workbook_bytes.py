"""An xlsx workbook as bytes that depend on its contents alone."""

import io
import os
import re
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass

Cell = str | float | int | None

#: The earliest moment that a zip archive can state.
_ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)
_FIXED_TIME = b"1980-01-01T00:00:00Z"
_W3C_TIME = re.compile(rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")


@dataclass(frozen=True)
class SheetContents:
    """One sheet: rows from the first, merged areas ("A1:C1"), widths of the columns from A."""

    title: str
    rows: Sequence[Sequence[Cell]]
    merged: Sequence[str] = ()
    widths: Sequence[int] = ()


def workbook_bytes(sheets: Sequence[SheetContents]) -> bytes:
    """Write a workbook without clock, without compression, with its parts in a fixed order.

    openpyxl writes the time of saving into the archive and into its core properties; both are
    replaced. The parts are stored and not deflated, because different builds of zlib compress to
    different bytes.

    Parameters
    ----------
    sheets : sequence of SheetContents
        At least one.

    Returns
    -------
    bytes
        The xlsx file.
    """
    fixed = io.BytesIO()
    with zipfile.ZipFile(_saved(sheets)) as source, zipfile.ZipFile(fixed, "w") as target:
        # Excel looks for the list of content types first.
        for name in sorted(source.namelist(), key=lambda n: (n != "[Content_Types].xml", n)):
            data = source.read(name)
            if name == "docProps/core.xml":
                data = _W3C_TIME.sub(_FIXED_TIME, data)
            part = zipfile.ZipInfo(name, date_time=_ZIP_EPOCH)
            part.compress_type = zipfile.ZIP_STORED
            part.create_system = 3
            part.external_attr = 0o644 << 16
            target.writestr(part, data)
    return fixed.getvalue()


def _saved(sheets: Sequence[SheetContents]) -> io.BytesIO:
    # the same bytes whether lxml is installed or not: it declares its namespaces elsewhere
    os.environ.setdefault("OPENPYXL_LXML", "False")
    from openpyxl import Workbook  # type: ignore[import-untyped]  # it has no stubs
    from openpyxl.utils import get_column_letter  # type: ignore[import-untyped]  # openpyxl has no annotations

    workbook = Workbook()
    workbook.remove(workbook.worksheets[0])
    for contents in sheets:
        sheet = workbook.create_sheet(contents.title)
        for row in contents.rows:
            sheet.append(list(row))
        for area in contents.merged:
            sheet.merge_cells(area)
        for index, width in enumerate(contents.widths, start=1):
            sheet.column_dimensions[get_column_letter(index)].width = width
    saved = io.BytesIO()
    workbook.save(saved)
    saved.seek(0)
    return saved
