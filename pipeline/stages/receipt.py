"""Receipts of files that are not JSON records: their digests, by path from the output folder."""

from pipeline.records.base import Glance, Record


class FirmwareFiles(Record):
    """The firmware sources of a vehicle."""

    files: dict[str, str]
    notes: tuple[str, ...] = ()
    """What the files had to do without."""


class DayLine(Record):
    """A trial day as the index names it; addresses are from the index, quoted.

    `runs` are label and address of each.
    """

    name: str
    title: str
    line: str
    href: str
    runs: tuple[tuple[str, str], ...] = ()
    glance: Glance | None = None
    lights: tuple[str, ...] = ()
    """Of each run."""


class PageFile(Record):
    """A vehicle's page, and what the index says of it."""

    files: dict[str, str]
    title: str
    name: str
    href: str
    data_note: str
    errors: int
    warnings: int
    failed_checks: int
    not_computed: int
    glance: Glance | None = None
    bench: str = ""
    """What the bench gave, in one line."""
    days: tuple[DayLine, ...] = ()
    """Trial days, the latest first."""
    trend_href: str = ""
    """Address of the trends over the trial days, from the index."""
