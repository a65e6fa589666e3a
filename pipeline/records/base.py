"""What every record shares: frozen, unknown keys refused, finite numbers unless stated."""

from pydantic import BaseModel, ConfigDict


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
