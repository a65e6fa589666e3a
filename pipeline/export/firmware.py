"""Write the firmware source and the table files of one vehicle."""

import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from pipeline.errors import CannotComputeError, writing_remedy
from pipeline.export.allocator_layout import AllocatorLayout
from pipeline.export.allocator_source import render_allocator_header, render_allocator_source
from pipeline.export.c_source import Identity, VoltageTables, render_header, render_source
from pipeline.export.c_text import c_identifier
from pipeline.export.grid_check import check_characteristic
from pipeline.export.self_test import render_self_test
from pipeline.export.table_files import render_csv, render_json, render_tables_csv
from pipeline.records.fits import FirmwareCharacteristic


def write_firmware(
    name: str,
    characteristic: FirmwareCharacteristic,
    *,
    tables_digest: str,
    tool_version: str,
    folder: Path,
    tables: dict[str, object] | None,
    layout: AllocatorLayout | None = None,
    accepted: Mapping[str, str] = MappingProxyType({}),
    voltages: VoltageTables = (),
) -> tuple[Path, ...]:
    """Write C99 header, source and self-test, JSON and CSV; the same bytes for the same input.

    Files are called after the `name` of the vehicle, in identifiers ``-`` becomes ``_``. `tables`
    1-4 are carried along in the JSON file and in a CSV of their own; the header tells the checks
    that they failed, and of those that vehicle.yaml has `accepted` why. `voltages` are the tables
    at each supply voltage, for the calls that take one. Without a `layout` there is no allocator.
    Returns header, source, self-test, JSON, CSV, tables; header and source of the allocator.

    Raises
    ------
    CannotComputeError
        When the name or the characteristic cannot be exported (see `check_characteristic`), or a
        file cannot be written. Nothing is written unless everything could be generated, and a
        file is replaced only by a complete one.
    """
    identity = Identity(vehicle=name, tables_digest=tables_digest, tool_version=tool_version)
    c_identifier(name)  # files are called after the name: it is refused before anything else
    for one in (characteristic, *(one for _, one in voltages)):
        check_characteristic(one)
    stem = identity.stem
    contents = {
        f"{stem}.h": render_header(
            identity, characteristic, _failed_checks(tables, accepted), voltages
        ),
        f"{stem}.c": render_source(identity, characteristic, voltages),
        f"{stem}_self_test.c": render_self_test(identity, characteristic),
        f"{stem}.json": render_json(identity, characteristic, tables, layout, voltages),
        f"{stem}.csv": render_csv(identity, characteristic),
        f"{name}_tables.csv": render_tables_csv(identity, tables, layout),
    }
    if layout is not None:
        at = _taking_voltage(characteristic.supply_voltage_v if voltages else None, layout)
        contents[f"{name}_allocator.h"] = render_allocator_header(identity, layout, at=at)
        contents[f"{name}_allocator.c"] = render_allocator_source(identity, layout, at=at)
    try:
        return _write_all(contents, folder)
    except OSError as error:
        raise CannotComputeError(
            f"{folder}: the firmware of {name} cannot be written: {error.strerror or error}.\n"
            + writing_remedy(error, "Make the folder writable, or name another folder.")
        ) from error


def _taking_voltage(own_v: float | None, layout: AllocatorLayout) -> tuple[bool, ...]:
    """Tell of each type of thruster whether the allocator asks its tables at a supply voltage.

    None does where the types' tables are for different voltages: they have no supply in common.
    """
    volts = (own_v, *layout.volts)
    common = len({one for one in volts if one is not None}) == 1
    return tuple(common and one is not None for one in volts)


def _failed_checks(tables: Mapping[str, object] | None, accepted: Mapping[str, str]) -> list[str]:
    """Return what the checks found that the tables did not pass."""
    quality = (tables or {}).get("quality")
    parts = [quality, *quality.values()] if isinstance(quality, dict) else []
    checks = [one for part in parts if isinstance(part, dict) for one in part.get("checks", ())]
    failed = [one for one in checks if not one["passed"]]
    reasons = [accepted.get(one.get("gate", ""), "") for one in failed]
    return [
        f"{one['name']}: {one['text']}" + (f". Accepted: {reason}" if reason else "")
        for one, reason in zip(failed, reasons, strict=True)
    ]


def _write_all(contents: dict[str, str], folder: Path) -> tuple[Path, ...]:
    """Write every file under a temporary name beside its own, then rename all of them."""
    folder.mkdir(parents=True, exist_ok=True)
    pending = [(folder / f".{name}.{os.getpid()}.tmp", folder / name) for name in contents]
    try:
        for (temporary, _), text in zip(pending, contents.values(), strict=True):
            with temporary.open("w", encoding="utf-8", newline="\n") as stream:
                stream.write(text)
                stream.flush()
                os.fsync(stream.fileno())
        for temporary, final in pending:
            temporary.replace(final)
    finally:
        for temporary, _ in pending:
            temporary.unlink(missing_ok=True)
    return tuple(final for _, final in pending)
