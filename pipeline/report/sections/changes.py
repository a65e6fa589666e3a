"""What `rig2sea apply` changed in the vehicle file, with dates, reasons and digests."""

from pipeline.language import as_it_is
from pipeline.report.blocks import Section, Table
from pipeline.report.numbers import general
from pipeline.report.results import VehicleResults

_DIGITS = 12


def changes_section(results: VehicleResults) -> Section:
    """List the changes, the latest first; one that was taken back says so."""
    rows = []
    for entry in reversed(results.changes):
        state = f"undone {entry.undone_utc} UTC" if entry.undone_utc else "holds"
        digests = f"{entry.before_sha256[:_DIGITS]} → {entry.after_sha256[:_DIGITS]}"
        for one in entry.changes:
            interval = f" [{_value(one.ci95[0])}, {_value(one.ci95[1])}]" if one.ci95 else ""
            rows.append(
                {
                    "Key": as_it_is(one.path),
                    "Before": "–" if one.old is None else _value(one.old),
                    "After": f"{_value(one.value)}{interval}",
                    "From": as_it_is(entry.reason),
                    "When": f"{entry.date_utc} UTC, {state}",
                    "Vehicle file, SHA-256 before → after": digests,
                }
            )
    title = "Changes of the vehicle file"
    return Section("changes", title, (Table.of("Changes", rows),))


def _value(value: float | bool | str) -> str:
    return general(value, 4) if isinstance(value, float) else str(value)
