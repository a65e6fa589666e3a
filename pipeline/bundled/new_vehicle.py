"""A raw folder to fill in: a commented ``vehicle.yaml``, a form for each kind of test, what to do.

The forms have names and units and no number: a reader knows a blank one by its first cell. Notes of
pool runs have a template beside where the logs go.
"""

import io
import os
import re
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.vehicle.bench_schema import FORM_MARK

Cell = str | float | int | None

#: The earliest moment that a zip archive can state.
_ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)
_FIXED_TIME = b"1980-01-01T00:00:00Z"
_W3C_TIME = re.compile(rb"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")

#: File of the vehicle's folder -> its form.
_TEXTS = {
    "vehicle.yaml": "vehicle.yaml",
    "README.md": "README.md",
    "pool/README.md": "pool_README.md",
}
#: Kind of test -> (name, unit) of each column; the readers need the first three (mooring: two).
COLUMNS: dict[str, tuple[tuple[str, str | None], ...]] = {
    "load_test": (
        ("Code", None),
        ("Shaft speed", "rpm"),
        ("Torque", "N m"),
        ("Current", "A"),
        ("Voltage", "V"),
        ("Status", None),
    ),
    "mooring": (
        ("Code", None),
        ("Thrust", "N"),
        ("Shaft speed", "rpm"),
        ("Voltage", "V"),
        ("Current", "A"),
        ("Remarks", None),
    ),
    "open_water": (("J", None), ("KT", None), ("KM", None), ("Remarks", None)),
}
_WIDTH = 14
#: Before what a vehicle file has from the bundled vehicle @LIKE@.
LIKE_HEAD = """\
# Vehicle file of @NAME@. It began as that of the bundled vehicle @LIKE@: replace each number by
# yours, and its comment with it. All keys with their meaning: docs/formats.md.
name: "@NAME@"
title: "@NAME@, like @LIKE@"
data_note: Model and sensors of the bundled vehicle @LIKE@, to be replaced by those of @NAME@.

"""


@dataclass(frozen=True)
class SheetContents:
    """One sheet: rows from the first, merged areas ("A1:C1"), widths of the columns from A."""

    title: str
    rows: Sequence[Sequence[Cell]]
    merged: Sequence[str] = ()
    widths: Sequence[int] = ()


def workbook_bytes(sheets: Sequence[SheetContents]) -> bytes:
    """Return an xlsx workbook without clock, without compression, with its parts in a fixed order.

    openpyxl writes the time of saving into the archive and into its core properties; both are
    replaced. The parts are stored and not deflated, because different builds of zlib compress to
    different bytes.
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


def new_vehicle_files(name: str) -> dict[str, bytes]:
    """Return the files of a new vehicle's raw folder by path; the same for the same name.

    >>> list(new_vehicle_files("boat"))[:3]
    ['vehicle.yaml', 'README.md', 'pool/README.md']
    """
    forms = Path(__file__).parent / "forms"
    texts = {
        file: (forms / form).read_text(encoding="utf-8").replace("@NAME@", name).encode()
        for file, form in _TEXTS.items()
    }
    return texts | {f"{kind}/{kind}.xlsx": _form(kind) for kind in COLUMNS}


def _form(kind: str) -> bytes:
    columns = COLUMNS[kind]
    heading = f"{FORM_MARK}: one row a point, see README.md"
    rows = ((heading,), [name for name, _ in columns], [unit for _, unit in columns])
    return workbook_bytes([SheetContents(kind, rows, widths=[_WIDTH] * len(columns))])
