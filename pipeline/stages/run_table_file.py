"""Tables of a run as a file of arrays (``.npz``): what later stages read instead of the log.

Numbers are kept as 32-bit floats, which is finer than any sensor, unless they are large: the
coordinates of a country would be off by a quarter of a metre. Times are not kept at all, they
follow from rate and start. The same table gives the same bytes.
"""

import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import InputError, Place
from pipeline.provenance import write_atomically
from pipeline.records.run_table import RunTable
from pipeline.records.trial import StoredRun
from pipeline.types import FloatArray

_SCHEMA = "rig2sea/run_table/1"
#: Nobody vouches for a file on a disk: one that unpacks to more than this in all is refused.
_MOST_BYTES = 4_000_000_000
#: Step between two numbers that a table may have, in whatever unit.
_COARSEST = 1e-3
#: What reading of a file raises that is not whole, or no such file at all.
_BROKEN = (
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    RuntimeError,  # encrypted, or packed in a way that is not known
    zipfile.BadZipFile,
    zlib.error,
)


def write_tables(path: Path, tables: Mapping[str, RunTable]) -> None:
    """Write evenly spaced tables under names into ``*.npz``, whole or not at all."""
    arrays: dict[str, np.ndarray[tuple[int, ...], np.dtype[np.generic]]] = {}
    heads: dict[str, object] = {}
    for name, table in tables.items():
        step = float(np.median(np.diff(table.time_s))) if table.time_s.size > 1 else 0.0
        heads[name] = {
            "name": table.name,
            "rows": int(table.time_s.size),
            "first_s": float(table.time_s[0]) if table.time_s.size else 0.0,
            "period_s": round(step, 12),
            "start_time_ns": table.start_time_ns,
            "thrusters": list(table.thrusters),
            "notes": list(table.notes),
            "left_out": {key: dict(counts) for key, counts in table.left_out.items()},
            "quantities": sorted(table.values),
            "reading": sorted(table.reading),
        }
        for quantity in table.values:
            arrays[f"{name}/{quantity}"] = _stored(table.values[quantity])
            arrays[f"{name}/{quantity}/valid"] = np.packbits(table.valid[quantity])
        for quantity, marks in table.reading.items():
            arrays[f"{name}/{quantity}/reading"] = np.packbits(marks)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        text = json.dumps({"schema": _SCHEMA, "tables": heads}, sort_keys=True).encode()
        archive.writestr(zipfile.ZipInfo("about.json"), text)
        for member in sorted(arrays):
            inside = io.BytesIO()
            np.save(inside, arrays[member], allow_pickle=False)
            # the default time of a ZipInfo is fixed: bytes change with the content only
            info = zipfile.ZipInfo(f"{member}.npy")
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, inside.getvalue(), compresslevel=1)
    write_atomically(path, buffer.getvalue())


def _stored(values: FloatArray) -> FloatArray | npt.NDArray[np.float32]:
    """Return the values in 32 bits, or in 64 where 32 would not tell a thousandth apart."""
    largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
    if np.spacing(np.float32(largest)) > _COARSEST:
        return values
    return values.astype(np.float32)


def read_tables(path: Path) -> dict[str, RunTable]:
    """Read what `write_tables` wrote."""
    try:
        with zipfile.ZipFile(path) as archive:
            about = _about(archive)
            return {name: _table(archive, name, head) for name, head in about["tables"].items()}
    except OSError as error:
        what, expected = f"cannot be read: {error.strerror or error}.", ""
    except _BROKEN:
        what, expected = "is not a whole file of tables.", f"arrays with the schema {_SCHEMA}."
    remedy = "Delete it and run again: rig2sea run"
    raise InputError.at(Place(str(path)), what, expected=expected, remedy=remedy)


def stored_table(stored: StoredRun) -> RunTable:
    """Return what was measured in a run that was read; raises as `read_tables`."""
    return replace(read_tables(Path(next(iter(stored.files))))["measured"], name=stored.run)


def _about(archive: zipfile.ZipFile) -> dict[str, Any]:
    if sum(info.file_size for info in archive.infolist()) > _MOST_BYTES:
        raise ValueError("too large")
    about: dict[str, Any] = json.loads(archive.read("about.json"))
    if about["schema"] != _SCHEMA:
        raise ValueError("of another schema")
    return about


def _table(archive: zipfile.ZipFile, name: str, head: dict[str, Any]) -> RunTable:
    rows = int(head["rows"])
    if not 0 <= rows <= _MOST_BYTES // 8:
        raise ValueError("rows")

    def array(member: str) -> np.ndarray[tuple[int, ...], np.dtype[np.generic]]:
        with archive.open(f"{name}/{member}.npy") as file:
            return np.asarray(np.load(io.BytesIO(file.read()), allow_pickle=False))

    def flags(member: str) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        return np.unpackbits(array(member).astype(np.uint8), count=rows).astype(bool)

    quantities = tuple(map(str, head["quantities"]))
    return RunTable(
        name=str(head["name"]),
        time_s=np.asarray(
            float(head["first_s"]) + float(head["period_s"]) * np.arange(rows), float
        ),
        values={one: array(one).astype(float).reshape(rows, -1) for one in quantities},
        valid={one: flags(f"{one}/valid") for one in quantities},
        notes=tuple(map(str, head["notes"])),
        reading={one: flags(f"{one}/reading") for one in map(str, head["reading"])},
        thrusters=tuple(map(str, head["thrusters"])),
        start_time_ns=int(head["start_time_ns"]),
        left_out=head["left_out"] if isinstance(head["left_out"], dict) else {},
    )
