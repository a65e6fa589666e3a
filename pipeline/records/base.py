"""What records share: their base, the source of a number, a change of the file, the first screen.

Records are frozen, refuse unknown keys and hold finite numbers unless stated.
"""

from typing import Literal

from pydantic import BaseModel, ConfigDict

Plain = float | bool | str

Light = Literal["red", "amber", "green"]
#: Worst first.
LIGHTS: tuple[Light, ...] = ("red", "amber", "green")


class Record(BaseModel):
    """A frozen model that refuses unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Source(Record):
    """The row of a raw file that a number came from.

    `file` is relative to the raw folder (``mmt300/mooring/run-1.xlsx``); `row` is counted as a
    spreadsheet program shows it, from 1.
    """

    file: str
    sheet: str | None = None
    row: int

    def __str__(self) -> str:
        """Return e.g. ``mmt300/mooring/run-1.xlsx, sheet "up", row 14``."""
        sheet = f', sheet "{self.sheet}"' if self.sheet is not None else ""
        return f"{self.file}{sheet}, row {self.row}"


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


class Advice(Record):
    """One thing to do: in words, and the command to type where there is one."""

    text: str
    command: str = ""


class Glance(Record):
    """The first screen."""

    light: Light
    matter: str
    """What is the matter, in a sentence."""
    short: str
    """The same for a list of many."""
    do: tuple[Advice, ...] = ()
    """At most three, the most urgent first."""
    fly_next: str = ""
    last_advice: str = ""
    """What became of what the day before advised."""


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
