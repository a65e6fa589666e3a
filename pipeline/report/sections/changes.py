"""What `rig2sea apply` changed in the vehicle file, with dates, reasons and digests."""

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
                (
                    one.path,
                    "–" if one.old is None else _value(one.old),
                    f"{_value(one.value)}{interval}",
                    entry.reason,
                    f"{entry.date_utc} UTC, {state}",
                    digests,
                )
            )
    head = ("Key", "Before", "After", "From", "When", "Vehicle file, SHA-256 before → after")
    table = Table(
        "Changes",
        head,
        tuple(rows),
        verbatim_columns=frozenset({0, 3}),
    )
    return Section("changes", "Changes of the vehicle file", (table,))


def _value(value: float | bool | str) -> str:
    return general(value, 4) if isinstance(value, float) else str(value)
