"""The pieces a page is made of; the sections build them, the template turns them into HTML.

All texts are plain text and are escaped by the template; only `Figure.svg` and `Figure.zoom` are
markup, and they come from `pipeline.report.plotting` and `pipeline.report.zoomable` alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, ClassVar, Literal, TypeVar

from markupsafe import Markup

from pipeline.errors import CannotComputeError
from pipeline.report.numbers import Pattern

NO_MARKUP = Markup("")
#: Columns that a telephone shows beside each other.
_BESIDE = 3
#: A cell with a number, perhaps with its unit or interval, and what stands in the place of one.
_NUMBER = re.compile(r"[<>±+−-]?\s?\d(?!.*[^\W\d]{4}).*", re.DOTALL)
_NOTHING = frozenset({"", "–", "all", "none", "not stated", "not known"})
#: A column of a table: its heading, and what stands there.
_COLUMN = re.compile(r"(?:^| \| )([^{|]+): ([^{|:]*\{[^|]*?)(?=$| \| )")
T = TypeVar("T")


@dataclass(frozen=True)
class Text:
    """A paragraph; `tone` colours its margin."""

    text: str
    tone: Literal["plain", "note", "warning", "error"] = "plain"
    kind: ClassVar[str] = "paragraph"


@dataclass(frozen=True)
class Bullets:
    """A list of short texts."""

    items: tuple[str, ...]
    kind: ClassVar[str] = "bullets"


@dataclass(frozen=True)
class Heading:
    """A heading inside a section."""

    text: str
    anchor: str
    kind: ClassVar[str] = "heading"


@dataclass(frozen=True)
class Table:
    """A table; the first column heads its row, columns of words are set flush left.

    `links` leads a cell (row, column) to an anchor of the page, e.g. to the points behind it;
    `cell_classes` shades one.
    """

    caption: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    row_classes: tuple[str, ...] = ()
    note: str = ""
    links: Mapping[tuple[int, int], str] = field(default_factory=dict)
    cell_classes: Mapping[tuple[int, int], str] = field(default_factory=dict)
    kind: ClassVar[str] = "table"

    @classmethod
    def of(
        cls, caption: str, items: Iterable[T],
        row: str | Callable[[T], Mapping[str, str]] = dict,  # type: ignore[assignment]
        mark: Callable[[T], str | bool] = lambda _: "", **more: Any,  # noqa: ANN401 - as the fields
    ) -> Table:  # fmt: skip
        """Return the table of things of one kind, a row for each.

        `row` says what each column is called and what stands there, as text, ``Load: {load_n:.1f} |
        Use: {use:use}`` (`Pattern`), or as a mapping; things may be rows themselves. `mark` gives
        the class of a row; true is a warning.
        """
        own = list(items)
        if isinstance(row, str):
            columns = [column.groups() for column in _COLUMN.finditer(row)]
            header = tuple(name for name, _ in columns) if own else ()
            rows = tuple(tuple(Pattern().vformat(c, (o,), {}) for _, c in columns) for o in own)
        else:
            found = [row(one) for one in own]
            header = tuple(found[0]) if found else ()
            rows = tuple(tuple(one.values()) for one in found)
        marks = tuple("warning" if (of := mark(one)) is True else of or "" for one in own)
        return cls(caption, header, rows, marks, **more)

    @property
    def words(self) -> frozenset[int]:
        """Columns that hold words."""
        numbers = (
            {*map(_NUMBER.fullmatch, set(own) - _NOTHING)} for own in zip(*self.rows, strict=True)
        )
        return frozenset(place for place, own in enumerate(numbers) if None in own or not own)

    @property
    def stacks(self) -> bool:
        """Whether a narrow screen shows every row as a list of its cells."""
        return len(self.header) > _BESIDE and not self.cell_classes

    def __post_init__(self) -> None:
        """Refuse ragged rows (a shifted column is worse than a stop) and links to elsewhere."""
        if not all(address.startswith("#") for address in self.links.values()):
            raise ValueError(f"table {self.caption!r}: cells lead to places of the page alone")
        for row in self.rows:
            if len(row) != len(self.header):
                raise ValueError(f"table {self.caption!r}: row {row!r} against {self.header!r}")


@dataclass(frozen=True)
class Figure:
    """A picture with the one sentence above it that says what to see.

    `zoom` is the data of the interactive figure that may take its place (`zoomable`).
    """

    name: str
    lead: str
    svg: Markup
    caption: str
    zoom: Markup = NO_MARKUP
    kind: ClassVar[str] = "figure"


@dataclass(frozen=True)
class Gallery:
    """Figures that stand beside each other where the screen is wide enough.

    `level`: neighbours have their sentences, pictures and captions at one height each. Not for
    pictures of very different heights: the lower one would be far below its sentence.
    """

    figures: tuple[Figure, ...]
    level: bool = True
    kind: ClassVar[str] = "gallery"


@dataclass(frozen=True)
class Links:
    """Links to files beside the page: label and relative address."""

    items: tuple[tuple[str, str], ...]
    kind: ClassVar[str] = "links"


@dataclass(frozen=True)
class Details:
    """Blocks folded away behind a summary."""

    summary: str
    blocks: tuple[Block, ...]
    kind: ClassVar[str] = "details"


Block = Text | Bullets | Heading | Table | Figure | Gallery | Links | Details
#: What a chapter is made of; None is left out.
Blocks = Iterator[Block | None]


@dataclass(frozen=True)
class Section:
    """A chapter of the page."""

    anchor: str
    title: str
    blocks: tuple[Block, ...] = field(default_factory=tuple)
    available: bool = True
    folded: bool = False
    """What came in and what was assumed: behind a summary that is opened by who wants it."""

    @property
    def is_there(self) -> bool:
        """Whether it holds more than why it is not available."""
        return self.available or any(not isinstance(one, Text) for one in self.blocks)

    @property
    def reason(self) -> str:
        """Why there is nothing, of a section that is not available."""
        texts = [one.text for one in self.blocks if isinstance(one, Text)]
        return " ".join(texts).removeprefix("Not computed: ")


def fold(section: Section) -> Section:
    """Return the section behind a summary."""
    return replace(section, folded=True)


def chapter(
    anchor: str, title: str | Callable[[Any], str]
) -> Callable[[Callable[[T], Blocks]], Callable[[T], Section]]:
    """Make a section of the blocks that a function yields.

    A function that raises `CannotComputeError` gives the section that stands where a result is
    missing and says why; what it yielded before comes after that.
    """

    def decorated(build: Callable[[T], Blocks]) -> Callable[[T], Section]:
        @wraps(build)
        def section(results: T) -> Section:
            blocks: list[Block] = []
            why: list[Block] = []
            try:
                for one in build(results):
                    blocks += [] if one is None else [one]
            except CannotComputeError as error:
                why = [Text(f"Not computed: {error}", tone="warning")]
            named = title if isinstance(title, str) else title(results)
            return Section(anchor, named, (*why, *blocks), available=not why)

        return section

    return decorated
