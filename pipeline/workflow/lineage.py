"""Where a result came from: the chain of files back to the raw ones, and whether each still fits.

Built from the envelopes alone (`pipeline.provenance`): what each file says it was made from is
compared with what is there now.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from pipeline.plan import RECORD_STAGES, TITLES, VehicleFolder, processed_file
from pipeline.provenance import code_digest, file_digest, read_raw_envelope, read_tables
from pipeline.stage_table import module_of
from pipeline.workflow.known_files import Head, misfits


@dataclass(frozen=True)
class Points:
    """Points that a raw file gave: all of them, and those that the reader left out."""

    sheet: str | None
    points: int
    left_out: int


@dataclass(frozen=True)
class Raw:
    """A raw file: digest when it was read, digest now, and what was read in it."""

    path: str
    sha256: str
    sha256_now: str
    read: tuple[Points, ...] = ()

    @property
    def fits(self) -> bool:
        """Whether it is the file that was read."""
        return self.sha256 == self.sha256_now


@dataclass(frozen=True)
class Link:
    """A processed file: what made it, when, and why it does not fit any more (`stale`)."""

    path: str
    stage: str
    title: str
    sha256: str
    version: str
    code: str
    code_now: str
    made_utc: str
    why_not: str | None
    stale: tuple[str, ...]
    inputs: tuple["Link", ...]
    raw: tuple[Raw, ...]

    @property
    def fits(self) -> bool:
        """Whether this file and all before it are up to date."""
        return not self.stale and all(link.fits for link in self.inputs)


def lineage(vehicle: VehicleFolder, out: Path, table: str, stage: str) -> Link:
    """Follow a table of ``tables.json`` back to the raw files: that file with all it is made from.

    `stage` computed the table: the other inputs of ``tables.json`` are left out, and of the inverse
    characteristic those that this table is not made of. The vehicle's folder is relative to `out`,
    that of ``processed/``, or absolute.

    Raises
    ------
    InputError
        When a file of the chain is absent, half-written or edited.
    """
    path = out / processed_file(vehicle.name, "tables")
    body = read_tables(path)["provenance"]
    # Table 3 is fitted to the mooring test alone, Table 4 to the static characteristic alone
    spare = {"table3": ("static",), "table4": ("mooring",)}.get(table, ())
    return _link(vehicle, out, "tables", body, only=(stage,), spare=spare)


def _link(
    vehicle: VehicleFolder,
    out: Path,
    stage: str,
    body: Mapping[str, Any],
    *,
    only: Sequence[str] | None = None,
    spare: Sequence[str] = (),
) -> Link:
    relative = processed_file(vehicle.name, stage)
    inputs: Mapping[str, str] = body["inputs"]
    code_now, path = code_digest(module_of(stage)), out / relative
    there = vehicle.digest_names(stage, out)
    digest = cache(file_digest)
    head = Head(body["code"], dict(inputs), {}, None, ())
    stale = misfits(head, code_now, vehicle, out, digest, there | inputs.keys())
    links: list[Link] = []
    raw: list[Raw] = []
    read = _points(body.get("record"))
    for name, known in sorted(inputs.items()):
        before = Path(name).stem
        is_result = name == processed_file(vehicle.name, before) and before in RECORD_STAGES
        if not is_result:
            points = read.get(name.removeprefix("raw/"), ())
            raw.append(Raw(name, known, digest(vehicle.place_of(out, name)), points))
        elif before not in spare and (only is None or before in only) and _is_before(before, stage):
            links.append(
                _link(vehicle, out, before, read_raw_envelope(out / name, before), spare=spare)
            )
    return Link(
        path=relative,
        stage=stage,
        title=TITLES[stage],
        sha256=file_digest(path),
        version=body["version"],
        code=body["code"],
        code_now=code_now,
        made_utc=datetime.fromtimestamp(path.stat().st_mtime, UTC).strftime("%Y-%m-%d %H:%M:%S"),
        why_not=body.get("why_not"),
        stale=tuple(stale),
        inputs=tuple(links),
        raw=tuple(raw),
    )


def _is_before(stage: str, after: str) -> bool:
    """Tell whether data flow that way: a chain has an end, whatever a file says."""
    order = (*RECORD_STAGES, "tables")
    return order.index(stage) < order.index(after)


def _points(record: Mapping[str, Any] | None) -> dict[str, tuple[Points, ...]]:
    """Count the points of a record of measurements by file and sheet."""
    points = (record or {}).get("points")
    if not isinstance(points, list):
        return {}
    every: Counter[tuple[str, str | None]] = Counter()
    out: Counter[tuple[str, str | None]] = Counter()
    for point in points:
        key = (point["source"]["file"], point["source"]["sheet"])
        every[key] += 1
        out[key] += bool(point["marks"])
    found: dict[str, tuple[Points, ...]] = {}
    for (file, sheet), count in every.items():
        found[file] = (*found.get(file, ()), Points(sheet, count, out[file, sheet]))
    return found
