"""A number of the vehicle file that a finding changes."""

from pipeline.records.base import Record

Plain = float | bool | str


class FileChange(Record):
    """What stands at a dotted path (list entries by their place from 0), before and after.

    In the file's own axes and units. `old` is None where the file states nothing and nothing is
    taken in its place.
    """

    path: str
    old: Plain | None
    value: Plain
    ci95: tuple[float, float] | None = None
