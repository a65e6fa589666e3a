"""What one page says of another: a vehicle and its trial days, as the index names them."""

from pipeline.records.base import Glance, Record


class DayLine(Record):
    """A trial day as another page names it; addresses are relative to that, quoted.

    `runs` are label and address of each.
    """

    name: str
    title: str
    line: str
    href: str
    runs: tuple[tuple[str, str], ...] = ()
    glance: Glance | None = None
    lights: tuple[str, ...] = ()
    """Of each run: red, amber, green, or nothing."""


class PageFile(Record):
    """A vehicle's page, and what the index says of it; addresses are from the index, quoted."""

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
    """Address of the trends over the trial days; none where there are none."""
