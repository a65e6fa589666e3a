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


class AppliedChange(Record):
    """One entry of the list of changes of a vehicle file: `rig2sea apply` writes it beside it.

    `reason` is what every changed number says it is from; `source` the file of the result, as seen
    from the output folder, with its digest; `runs` are those that it rests on. `former` is the file
    beside it with the bytes of before; `undone_utc` is empty while the change holds.
    """

    number: int
    date_utc: str
    reason: str
    source: str
    source_sha256: str
    runs: tuple[str, ...]
    before_sha256: str
    after_sha256: str
    former: str
    changes: tuple[FileChange, ...]
    undone_utc: str = ""
