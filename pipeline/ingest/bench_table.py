"""A table of a bench file on its way from rows to points: steps that a kind of test lists."""

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.blocks import Block, heading_text
from pipeline.ingest.load_test_words import Branch, CodeText
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

Sweep = Literal["up", "down"]
#: A small "в" that stands by itself is a preposition ("опыт 3 в бассейне"), and so is a large one
#: before a word in capitals.
_VOLTS = re.compile(
    r"(?<![^\W_])(?<![.,])(\d{1,3}(?:[.,]\d+)?)"
    r"(?:\s*(?:[Vv]|В(?!\s+[А-ЯЁ]{2})|(?i:volts?|вольт))|в)(?![^\W_])"
)


@dataclass(frozen=True)
class Reading:
    """One row: numbers by quantity, in the units of the records, signs of the mapping applied."""

    row: int
    values: Mapping[str, float]
    marks: tuple[str, ...] = ()
    branch: Branch | None = None

    @property
    def is_zero(self) -> bool:
        """Whether it is of a command of 0 and counts: a reading of the tare."""
        return not self.marks and self.values.get("code") == 0.0

    def marked(self, *marks: str) -> "Reading":
        """Return the reading with more marks, each once."""
        both = tuple(dict.fromkeys((*self.marks, *marks)))
        return Reading(self.row, self.values, both, self.branch)

    def with_values(self, **values: float) -> "Reading":
        """Return the reading with other numbers; adding 0.0 turns -0.0 into 0.0."""
        given = {name: value + 0.0 for name, value in values.items()}
        return Reading(self.row, {**self.values, **given}, self.marks, self.branch)


@dataclass
class RowWords:
    """By row: the code of the nearest heading, the branch; rows of warm-up; rows of headings."""

    codes: dict[int, CodeText] = field(default_factory=dict)
    branches: dict[int, Branch | None] = field(default_factory=dict)
    warm_up: set[int] = field(default_factory=set)
    headings: set[int] = field(default_factory=set)
    problems: list[Problem] = field(default_factory=list)


@dataclass
class Table:
    """A table with its readings.

    `kind` is its section of vehicle.yaml; `problems` are those of the whole file; `words` is what
    words say of the rows of a load test.
    """

    block: Block
    kind: str
    vehicle: Vehicle
    readings: list[Reading]
    problems: list[Problem]
    words: RowWords = field(default_factory=RowWords)
    told_apart_by: frozenset[str] = frozenset()
    """Words of a direction in the file's name where another file has the opposite one."""
    is_left_out: bool = False
    must_go: bool = False
    """It is left out as soon as the signs of its codes are known and told."""
    code: float | None = None
    """Of a load test, where neither a column nor a heading between the rows states one."""
    code_from: str = ""
    """Where the codes of a load test were found."""
    nominal_voltage_v: float | None = None
    sense: Sweep | None = None
    """Of a mooring test's sweep."""

    def __post_init__(self) -> None:
        """Remember where it is and what was read before any step."""
        self.place, self.rows_read = self.block.place(), len(self.readings)

    def at(self, row: int | None = None, quantity: str | None = None) -> Place:
        """Return the place of a row, and of a quantity's column."""
        return self.block.place(row, quantity)

    @property
    def measured(self) -> str:
        """What is measured against the command: 0 at rest."""
        return "thrust" if self.kind == "mooring" else "shaft_speed"

    @property
    def texts(self) -> tuple[str, str, str]:
        """What is said of the whole table: by the name of what is measured, the sheet, headings."""
        column = self.block.columns["torque" if self.kind == "load_test" else "thrust"]
        own = f"{column.header} {column.group}"
        return own, self.block.sheet.name or "", heading_text(self.block.above)

    @property
    def head(self) -> int:
        """The row of the names."""
        return self.block.header_row

    def take(self, steps: Iterable["Step"]) -> None:
        """Go through steps until one leaves the table out."""
        for step in steps:
            self.problems += step(self)
            if self.is_left_out:
                return

    def leave_out(self, problem: Problem) -> Problem:
        """Leave the table out, for a reason that is returned."""
        self.is_left_out, self.readings = True, []
        return problem

    def live(self) -> list[Reading]:
        """Return the readings that count."""
        return [one for one in self.readings if not one.marks]

    def mark(self, rows: Collection[int], mark: str) -> None:
        """Mark the readings of these rows."""
        self.change(lambda one: one.marked(mark) if one.row in rows else one)

    def change(self, change: Callable[[Reading], Reading]) -> None:
        """Put what a function makes of each reading in its place."""
        self.readings = list(map(change, self.readings))


#: Changes the readings of a table, and says what is wrong.
Step = Callable[[Table], Iterable[Problem]]


def numbers(readings: Iterable[Reading], quantity: str) -> FloatArray:
    """Return a quantity of readings (n,), NaN where one has none."""
    return np.array([one.values.get(quantity, np.nan) for one in readings], dtype=float)


def stated_voltage(texts: Sequence[str]) -> float | None:
    """Return the one voltage that the first text with any states.

    >>> stated_voltage(["Thrust, N", "16 V"]), stated_voltage(["10 V to 20 V"])
    (16.0, None)
    >>> stated_voltage(["Опыт 3 в бассейне", "12,6 В, реверс"])
    12.6
    """
    for text in texts:
        found = {float(one.replace(",", ".")) for one in _VOLTS.findall(text)}
        if found:
            return found.pop() if len(found) == 1 else None
    return None
