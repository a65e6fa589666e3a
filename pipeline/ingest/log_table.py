"""Tables in time: a run as ``*.csv`` (``.tsv``, ``.txt``) or ``*.parquet``, a row a reading.

The first line names the columns, with their units in brackets or at the end of the name. One has
the time: seconds (or another unit) since the start or since 1970, or dates of ISO 8601.
"""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import InputError, Place, reason
from pipeline.ingest.cells import is_number
from pipeline.ingest.data_files import data_of
from pipeline.ingest.log_source import TABLE, LogFacts, TableLog, TopicTable
from pipeline.ingest.message_fields import LETTERS
from pipeline.ingest.pool_run_plan import BY_HEADS
from pipeline.ingest.quantities import KNOWN_UNITS, NO_UNIT, known_unit, same_quantities
from pipeline.ingest.table_times import time_column, times_of
from pipeline.ingest.text_table import delimiter_of, encoding_of
from pipeline.ingest.thruster_names import in_number_order
from pipeline.records.pool_schema import UNITS, PoolChannel

_HEAD = re.compile(r"\s*(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])]|,(?P<after>[^,]*))\s*")
#: Words for a column -> its name.
_SAID = {
    words: name for name, every in data_of("topics")["columns_in_words"].items() for words in every
}
_BYTES_OF_HEAD, _LINES_OF_HEAD, _LOOKED_AT = 65_536, 60, 20
#: Rows of which more go back in time are sorted; fewer are a clock that was set.
_MOST_BACK = 0.1


def read_table(path: Path, shown_as: str) -> TableLog:
    """Read a table in time; raises `InputError` if it cannot be read, or no column has the time."""
    place = Place(shown_as)
    heads, numbers, index = _columns(path, place)
    time_ns, rows, said = times_of(numbers, heads, index, place)
    if (np.diff(time_ns) < 0).mean() > _MOST_BACK:
        order = np.argsort(time_ns, kind="stable")
        time_ns, rows = time_ns[order], rows[order]
        said.append(place.warning("the rows are not in the order of time: they were sorted."))
    columns: dict[str, npt.NDArray[Any]] = {}
    units: dict[str, str] = {}
    for number, (name, unit) in enumerate(heads):
        values = numbers[number].to_numpy()
        if number != index and values.dtype.kind in "iufb":
            field = _field(name)
            columns.setdefault(field, values[rows].astype(float))
            units.setdefault(field, unit)
    size = path.stat().st_size
    facts = LogFacts(place, size, size, writer="a table", recorder=BY_HEADS)
    facts.problems += said
    facts.usual = tuple(_Names(units, columns, facts).channels())
    return TableLog({TABLE: TopicTable(time_ns, columns)}, facts)


def first_time_ns(path: Path) -> int:
    """Return the time of the first row [ns since 1970]; raises where there is none."""
    place = Place(path.name)
    heads, numbers, index = _columns(path, place, rows=3)
    return int(times_of(numbers, heads, index, place)[0][0])


def _columns(
    path: Path, place: Place, rows: int | None = None
) -> tuple[list[tuple[str, str]], list[Any], int]:
    """Return the names and units of columns, the columns themselves, and which has the time."""
    frame = _frame(path, place, rows)
    heads = [_split(str(name)) for name in frame.columns]
    under = _units_under(frame)
    if under:
        frame = frame.iloc[1:]
        heads = [(name, unit or own) for (name, unit), own in zip(heads, under, strict=True)]
    index = time_column(heads)
    if index is None:
        named = ", ".join(name for name, _ in heads[:12])
        raise InputError.at(
            place,
            f"no column of the table has the time, among {named}.",
            expected='a column "time" or "t", its unit in brackets: time [s].',
            remedy="Name it, or move the file out of pool/ if it is no run.",
        )
    return heads, [_numbers(frame.iloc[:, number]) for number in range(len(heads))], index


def _frame(path: Path, place: Place, rows: int | None = None) -> Any:  # noqa: ANN401  of pandas
    import pandas as pd

    try:
        if path.suffix.lower() == ".parquet":
            frame = pd.read_parquet(path)
            if isinstance(frame.index, pd.RangeIndex):
                return frame
            frame.index.name = frame.index.name or "time"
            return frame.reset_index()
        with path.open("rb") as file:
            sample = file.read(_BYTES_OF_HEAD)
        encoding = encoding_of(sample)
        lines = sample.decode(encoding, errors="replace").splitlines()[:_LINES_OF_HEAD]
        apart = delimiter_of([line for line in lines if line.strip()][-_LOOKED_AT:])
        head, below = _head_row(lines, apart)
        comma = apart != "," and any(re.search(r"\d,\d", line) for line in below)
        return pd.read_csv(
            path,
            sep=apart or r"\s+",
            decimal="," if comma else ".",
            encoding=encoding,
            skipinitialspace=True,
            low_memory=False,
            skiprows=head,
            nrows=rows,
        )
    except ImportError:
        why = "pyarrow is not installed"
        remedy = 'pip install "rig2sea[parquet]"'
    except Exception as error:  # noqa: BLE001 - pandas has many
        why, remedy = reason(error), "Export it again as UTF-8."
    raise InputError.at(
        place, f"the table cannot be read ({why}).", expected="a table in time.", remedy=remedy
    )


def _head_row(lines: Sequence[str], apart: str | None) -> tuple[int, Sequence[str]]:
    """Return where the names stand, after titles and remarks, and the lines of readings below.

    They are the first of the lines above the readings that have as many cells.

    >>> _head_row(["# pool log", "", "time,u", "s,m/s", "0.0,1.0", "0.1,1.1"], ",")
    (2, ['0.0,1.0', '0.1,1.1'])
    """
    cells = [line.split() if apart is None else next(csv.reader([line], delimiter=apart), [])
             for line in lines]  # fmt: skip
    width = max(map(len, cells), default=0)
    readings = (
        at
        for at, row in enumerate(cells)
        if len(row) == width and sum(one[:1].isdigit() or is_number(one) for one in row) * 2 > width
    )
    data = next(readings, 0)
    head = data
    while head and len(cells[head - 1]) in (width, width + (apart is None)):
        head -= 1
    return head, lines[data:]


def _numbers(column: Any) -> Any:  # noqa: ANN401  a column of pandas
    """Return a column of texts as numbers where most of them are, with point or comma."""
    import pandas as pd

    if column.dtype.kind in "iufb":
        return column
    plain = column.astype("string").str.strip().str.replace(",", ".", regex=False)
    plain = plain.replace({letter: str(worth) for letter, worth in LETTERS.items()})
    found = pd.to_numeric(plain, errors="coerce").astype(float)
    return found if found.notna().mean() > 0.5 else column


def _split(head: str) -> tuple[str, str]:
    """Split the head of a column into its name and its unit.

    >>> _split("Roll [deg]"), _split("time_ms"), _split("Глубина, м")
    (('roll', 'deg'), ('time_ms', ''), ('depth', 'm'))
    """
    head = head.lstrip("#%/ ")
    match = _HEAD.fullmatch(head)
    name, unit = (
        (match["name"], (match["unit"] or match["after"] or "").strip())
        if match
        else (head.strip(), "")
    )
    name = name.strip().lower()
    return _SAID.get(" ".join(re.sub(r"[\W_]+", " ", name).split()), name), known_unit(unit)


def _units_under(frame: Any) -> list[str]:  # noqa: ANN401  of pandas
    """Return the units of a row of units under the names, nothing where the first row is none."""
    cells = [] if frame.empty else [str(one).strip(" []()") for one in frame.iloc[0]]
    units = ["" if one in NO_UNIT else known_unit(one) for one in cells]
    known = {*KNOWN_UNITS} - {"1"}  # a reading
    return units if {*units} - {""} and {*units} <= {"", *known} else []


def _field(name: str) -> str:
    """Return a name that the ``field`` of a channel may have; dots part messages."""
    plain = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")
    return plain if plain[:1].isalpha() else f"c_{plain}"


@dataclass(frozen=True)
class _Names:
    """What names of columns tell: their `units`; what cannot be read leaves the `columns`."""

    units: dict[str, str]
    columns: dict[str, Any]
    facts: LogFacts

    def channels(self) -> Iterator[PoolChannel]:
        """Yield the channels that the names tell, and say whose unit is not known."""
        used: set[str] = set()
        for quantity, choices in data_of("topics")["columns"].items():
            for names in choices:
                fields = [self._with_unit(name, quantity) for name in names]
                if all(fields):
                    order = {"order": "wxyz"} if quantity == "attitude_quaternion" else {}
                    axes = {"earth_axes": "enu"} if names[-1] in {"up", "vu"} else {}
                    used |= {*fields}
                    yield from self._channel(quantity, fields, **order, **axes)
                    break
        for quantity, begins in data_of("topics")["columns_of_thrusters"].items():
            begin = "|".join(begins)  # the longer ones stand first
            of: dict[str, str] = {}
            for match in filter(
                None, (re.fullmatch(rf"({begin})_(.+)", one) for one in self.units)
            ):
                first = of.setdefault(match[2], match[0])
                if first != match[0]:
                    both = f'columns "{first}" and "{match[0]}"'
                    what = f"{both} may both be {quantity}: the first is taken."
                    self._warn(what, remedy="Rename the other.")
                self.units[first] = self.units[first] or begins[match[1]]
            used |= {*of.values()}
            fields = list(of.values())
            numbered = (one for one in in_number_order(list(of)) if len(one) == len(of))
            if in_order := [fields[at] for at in next(numbered, ())]:
                yield from self._channel(quantity, in_order)
                continue
            for thruster, field in of.items():
                yield from self._channel(quantity, [field], thrusters=(thruster,))
        if rest := [field for field in self.units if field not in used]:
            shown = f"{', '.join(rest[:12])}{', ...' if len(rest) > 12 else ''}"
            what = f"columns whose names tell no quantity: {shown}; they were not read."
            self.facts.problems.append(self.facts.place.note(what))

    def _warn(self, what: str, expected: str = "", remedy: str = "") -> None:
        self.facts.problems.append(self.facts.place.warning(what, expected, remedy))

    def _with_unit(self, name: str, quantity: str) -> str:
        """Return the column of a name, which may have a unit at its end; or nothing."""
        if name in self.units:
            return name
        for field, unit in self.units.items():
            end = field.removeprefix(f"{name}_")
            spelled = (end, re.sub(r"p(?=s|h)", "/", end), end[:-1] + end[-1:].upper())
            at_end = {known_unit(one) for one in spelled} & {*UNITS[quantity]}
            if end != field and at_end:
                self.units[field] = unit or at_end.pop()
                return field
        return ""

    def _channel(
        self,
        quantity: str,
        fields: Sequence[str],
        **more: Any,  # noqa: ANN401
    ) -> Iterator[PoolChannel]:
        """Yield a channel; none where its unit is not one of the quantity."""
        unit = self.units[fields[0]]
        # a depth in bar is a pressure
        alike = [one for one in same_quantities(quantity) if not unit or unit in UNITS[one]]
        if len({self.units[field] for field in fields}) > 1:
            what = f"columns {', '.join(fields)} have different units; {quantity} was not read."
            self._warn(what, remedy="Write them in one unit.")
        elif not alike:
            what = f'"{unit}" of column "{fields[0]}" is no unit of {quantity}; it was not read.'
            known = f"one of {', '.join(UNITS[quantity])}."
            self._warn(what, known, "Correct the head of the column.")
        else:
            stated: dict[str, Any] = {"topic": TABLE, "field": tuple(fields), **more}
            stated["quantity"] = quantity if quantity in alike else alike[0]
            yield PoolChannel.model_validate(stated | ({"unit": unit} if unit else {}))
            return
        for field in fields:
            self.columns.pop(field, None)
