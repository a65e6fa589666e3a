"""Workbooks and vehicles for the tests of the readers; a module of the tests, not a test."""

import io
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from openpyxl import Workbook

from pipeline.vehicle.schema import Vehicle

Rows = Sequence[Sequence[object]]


def vehicle(**load_test: object) -> Vehicle:
    """A vehicle whose load-test columns are stated as given."""
    return Vehicle.model_validate(
        {
            "name": "trial",
            "title": "A vehicle for tests",
            "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.81},
            "propellers": {"screw": {"diameter_m": 0.14}},
            "drives": {"drive": {"code_min": -127, "code_max": 127}},
            "tables": {"propeller": "screw", "drive": "drive"},
            "columns": {"load_test": load_test},
        }
    )


def write_workbook(
    path: Path,
    sheets: Mapping[str, Rows],
    finish: Callable[[Workbook], None] | None = None,
) -> Path:
    """Write sheets of plain rows; `finish` may merge cells and so on."""
    workbook = Workbook()
    workbook.remove(workbook.worksheets[0])
    for name, rows in sheets.items():
        sheet = workbook.create_sheet(name)
        for row in rows:
            sheet.append(list(row))
    if finish is not None:
        finish(workbook)
    path.parent.mkdir(parents=True, exist_ok=True)
    workbook.save(path)
    return path


def change_member(path: Path, name: str, change: Callable[[bytes], bytes]) -> Path:
    """Rewrite one member of a zip file, or add it."""
    target = io.BytesIO()
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        for entry in old.infolist():
            content = old.read(entry)
            new.writestr(entry.filename, change(content) if entry.filename == name else content)
        if name not in old.namelist():
            new.writestr(name, change(b""))
    path.write_bytes(target.getvalue())
    return path


def sweep(code: float, count: int = 12) -> list[tuple[float, float]]:
    """(speed in rpm, torque in N m) of a drive that slows down under load, up and down again."""
    up = [index / (count - 1) for index in range(count)]
    load = [*up, *reversed(up[:-1])]
    return [
        (round(16.0 * code * (1.0 - 0.6 * x) + 0.01 * i, 2), round(0.0068 * code * x + 0.001, 5))
        for i, x in enumerate(load)
    ]
