"""Schema of a comparison: whether two things can be compared, what differs, curves, codes."""

from typing import Literal

from pipeline.records.base import Record

Interval = tuple[float, float]
Kind = Literal["runs", "bench", "vehicle"]


class Side(Record):
    """One of the two: as it was asked for, and what it holds."""

    name: str
    kind: Kind
    vehicle: str
    holds: tuple[str, ...]


class Difference(Record):
    """Something that differs: `a`, `b` in `unit`, `ratio` b / a where both are above nothing.

    `ci95` is the interval of the ratio where there is one, of b - a otherwise; without it the two
    are stated and not measured. `p_value` is the chance of so clear a sign where nothing differs,
    all questions counted. `where` names the runs, empty: all.
    """

    kind: Literal["thruster", "all_thrusters", "parameter", "common_factor", "factor", "stated"]
    what: str
    where: tuple[str, ...] = ()
    unit: str
    a: float | None
    b: float | None
    ratio: float | None = None
    ci95: Interval | None = None
    p_value: float | None = None
    text: str


class Curve(Record):
    """A curve of both sides over each other; `points`: measured one by one."""

    title: str
    x_label: str
    y_label: str
    points: bool
    a_x: tuple[float, ...]
    a_y: tuple[float, ...]
    b_x: tuple[float, ...]
    b_y: tuple[float, ...]


class CodeChange(Record):
    """Codes of both for one thrust at rest."""

    thrust_n: float
    a: int
    b: int


class Comparison(Record):
    """B against A. `differences` stand; `asked` are all answers, also those that do not."""

    a: Side
    b: Side
    comparable: bool
    why_not: tuple[str, ...] = ()
    cautions: tuple[str, ...] = ()
    verdict: str = ""
    differences: tuple[Difference, ...] = ()
    asked: tuple[Difference, ...] = ()
    curves: tuple[Curve, ...] = ()
    codes: tuple[CodeChange, ...] = ()
    """Thrusts at which the rounded codes differ."""
    codes_compared: int = 0
