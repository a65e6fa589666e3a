"""Receipts of files that are not JSON records: their digests, by path from the output folder."""

from pipeline.records.base import Record


class FirmwareFiles(Record):
    """The firmware sources of a vehicle."""

    files: dict[str, str]
    notes: tuple[str, ...] = ()
    """What the files had to do without."""
