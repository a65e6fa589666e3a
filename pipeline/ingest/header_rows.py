"""Rows of a sheet that hold column names: which cell may name which quantity."""

import functools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from pipeline.ingest.cells import Cell, Sheet, column_letter, is_number, is_text
from pipeline.ingest.unit_text import normalise_unit, parts_of_whole
from pipeline.ingest.vocabulary import (
    FIRST_RANK,
    MANY_MEANINGS,
    HeaderText,
    Vocabulary,
    is_other,
    name_score,
    pattern_of,
    plain,
    read_unit_cell,
    split_header,
    unit_fits,
    vocabulary_of,
    words_of,
)
from pipeline.vehicle.bench_schema import Column

#: The speed of a motor's field: the shaft's times the pole pairs. Never read as it stands.
ELECTRICAL = "electrical_shaft_speed"
#: Other things that a bench records in the units of a thrust, a torque, a speed or a pulse.
_OTHER_MEANINGS = words_of("groups", "other_meanings")
#: What a column with a unit and an unknown name scores: less than any name.
_BY_UNIT = 8
#: And one that is called measured, actual or mean and nothing else.
_MEASURED, _FIRST_RANK = 95, frozenset(map(plain, FIRST_RANK))
#: What a name scores whose unit is of something else: less than any column that may be read.
_MISFIT = 1
#: What a column scores that vehicle.yaml states.
_STATED = 1000
_LONGEST_NAME = 4
_LETTER = re.compile(r"[^\W\d_]")
_BY_LETTER = re.compile(r"column ([A-Z]{1,3})", re.IGNORECASE)


@dataclass(frozen=True)
class Wanted:
    """What to look for.

    `required`: of each group at least one quantity must be there. `shared`: quantities whose
    column to the left of several tables side by side belongs to all of them. `mapping`: columns as
    vehicle.yaml states them, `sheets` those that it names. `kind` is its section of it.
    `split_words` tell columns of tables side by side apart ("n loading", "n unloading").
    """

    kind: str
    required: tuple[tuple[str, ...], ...]
    mapping: Mapping[str, Column] = field(default_factory=dict)
    only: Mapping[str, str] = field(default_factory=dict)
    shared: frozenset[str] = frozenset()
    split_words: tuple[str, ...] = ()
    sheets: tuple[str, ...] | None = None

    @property
    def vocabulary(self) -> Vocabulary:
        """What the columns of the kind are called."""
        return vocabulary_of(self.kind)

    def is_complete(self, quantities: "set[str] | frozenset[str]") -> bool:
        """Tell whether every required group is there."""
        return all(any(name in quantities for name in group) for group in self.required)


@dataclass(frozen=True)
class Match:
    """One column that may hold one quantity."""

    quantity: str
    index: int
    score: int
    header: HeaderText
    text: str


def header_rows(sheet: Sheet, wanted: Wanted) -> list[tuple[int, list[Match]]]:
    """Return (row, matches) of every row of names, best of each group of neighbours."""
    chosen: list[tuple[int, list[Match]]] = []
    best, looked_at = 0, 0
    for row, cells in sheet.numbered():
        texts = sum(isinstance(cell, str) and not is_number(cell) for cell in cells)
        numbers = sum(cell is not None for cell in cells) - texts
        is_data = texts == 0 or numbers >= max(2, texts)
        own = [] if is_data else _matches_in_row(sheet, wanted, row)
        if not own:
            continue
        matches = own + _stacked_matches(sheet, wanted, row, own)
        named = {match.quantity for match in matches}
        # an electrical speed is named for that of the shaft
        if not wanted.is_complete(named | {"shaft_speed"} if ELECTRICAL in named else named):
            continue
        weight = 100 * len({match.quantity for match in own}) + len(own)
        near = chosen and not _numbers_between(sheet, wanted, chosen[-1][1], (looked_at, row))
        looked_at = row
        if not near or weight > best:
            chosen = [*(chosen[:-1] if near else chosen), (row, matches)]
            best = weight
    return chosen


def _matches_in_row(sheet: Sheet, wanted: Wanted, row: int) -> list[Match]:
    matches: list[Match] = []
    texts = [cell for cell in sheet.cells(row) if isinstance(cell, str)]
    if len(set(texts)) == 1 and len(texts) > 1 and len(wanted.required) > 1:
        return []  # a title merged over the table
    for index, cell in enumerate(sheet.cells(row)):
        if isinstance(cell, str) and _LETTER.search(cell) and is_text(cell):
            matches += _match_over_unit(wanted, cell, sheet.cell(row + 1, index), index)
    return matches


def _match_over_unit(wanted: Wanted, text: str, below: Cell, index: int) -> list[Match]:
    """Match a name with what the unit under it says: "Speed" over "rad/s" is no speed in m/s."""
    plain_match = _match(wanted, text, index)
    unit = read_unit_cell(below) if isinstance(below, str) else None
    named = plain_match[0] if plain_match else None
    if unit is None or (named and (named.score >= _STATED or named.header.unit is not None)):
        return plain_match
    with_unit = _match(wanted, f"{text} [{unit}]", index)
    words = wanted.vocabulary.get(plain_match[0].quantity) if plain_match else None
    is_sound = words is not None and (words.unit_kind is None or unit_fits(unit, words))
    if named and named.quantity == "code" and with_unit and with_unit[0].quantity == "pwm":
        is_sound = False  # a command in microseconds
    if not with_unit or (is_sound and with_unit[0].score <= _BY_UNIT):
        return plain_match
    return [replace(one, header=HeaderText(text), text=text) for one in with_unit]


def _stacked_matches(sheet: Sheet, wanted: Wanted, row: int, own: Sequence[Match]) -> list[Match]:
    """Match columns whose name goes over two or three rows, or stands a row lower."""
    matched = {match.index for match in own}
    found: list[Match] = []
    width = max(
        (len(sheet.cells(at)) for at in range(row, min(row + 3, sheet.last_row + 1))), default=0
    )
    for index in range(width):
        if index in matched:
            continue
        texts = [sheet.cell(at, index) for at in range(row - 1, row + 3)]
        above, here, below, lowest = (
            text if isinstance(text, str) and is_text(text) else "" for text in texts
        )
        # A unit under a column without a name must not become one: "N" is newton there, not code.
        below, lowest = ("" if read_unit_cell(text) else text for text in (below, lowest))
        if here and sheet.cell(row - 1, index) == sheet.cell(row, index):
            above = ""  # one merged cell
        if len(above.split()) > _LONGEST_NAME:
            above = ""  # a title over the table, which speaks of more than this column
        tries = [f"{here} {below}", f"{above} {here}", f"{here} {below} {lowest}"]
        for text in tries if here else [below]:
            matches = _match(wanted, text.strip(), index) if text.strip() else []
            if matches:
                found += matches
                break
    return found


def _match(wanted: Wanted, text: str, index: int) -> list[Match]:
    """Return the best quantity for a header text, or the one that vehicle.yaml states."""
    for quantity, column in wanted.mapping.items():
        if is_mapped(column, text) or letter_of(column) == column_letter(index):
            if is_electrical(text) and column.pole_pairs is None:
                continue
            header = next((h for h in split_header(text) if h.unit), split_header(text)[0])
            return [Match(quantity, index, _STATED, header, text)]
    if "shaft_speed" in wanted.vocabulary and is_electrical(text):
        return [Match(ELECTRICAL, index, 100, split_header(text)[0], text)]
    best: Match | None = None
    needed = tuple(name for group in wanted.required for name in group)
    for score, quantity, header in _scores(text, wanted.kind, wanted.split_words, needed):
        if quantity in wanted.mapping:
            continue
        if best is None or score > best.score:
            best = Match(quantity, index, score, header, text)
    return [] if best is None else [best]


@functools.lru_cache(maxsize=8192)
def _scores(
    text: str, kind: str, split_words: tuple[str, ...], needed: tuple[str, ...]
) -> tuple[tuple[int, str, HeaderText], ...]:
    vocabulary = vocabulary_of(kind)
    scores: list[tuple[int, str, HeaderText]] = []
    misfits: list[tuple[int, str, HeaderText]] = []
    for header in split_header(text):
        bare = replace(header, name=_strip_words(header.name, split_words))
        for quantity, words in vocabulary.items():
            score = max(name_score(header, words), name_score(bare, words) - 1)
            share = quantity == "pwm" and parts_of_whole(header.unit or "") > 0
            if share and score > 0 and "code" in vocabulary:
                # a pulse width in per cent is a share of full throttle
                scores.append((score, "code", header))
            if score > 0 and (header.unit is None or unit_fits(header.unit, words)):
                scores.append((score + (5 if header.unit else 0), quantity, header))
            elif score > 0 and words.unit_kind is not None and quantity in needed:
                misfits.append((_MISFIT, quantity, header))  # to be refused with its unit
    return tuple(scores) or _scores_by_unit(text, vocabulary) or tuple(misfits)


def _scores_by_unit(text: str, vocabulary: Vocabulary) -> tuple[tuple[int, str, HeaderText], ...]:
    """Score a text whose name is in no list, but whose unit says what it may be."""
    header = split_header(text)[0]
    if header.unit is None or normalise_unit(header.unit) in MANY_MEANINGS:
        return ()
    if is_other(header, _OTHER_MEANINGS):
        return ()
    # "Measured (N)" names no quantity, and is not beaten by one that is not said to be measured
    score = _MEASURED if plain(header.name) in _FIRST_RANK else _BY_UNIT
    return tuple(
        (score, quantity, header)
        for quantity, words in vocabulary.items()
        if words.by_unit and unit_fits(header.unit, words) and not is_other(header, words.never)
    )


def _strip_words(name: str, words: tuple[str, ...]) -> str:
    """Take "loading" and the like out of a name, so that "n loading" is the symbol n."""
    for word in words:
        name = re.sub(rf"(?<!\w){re.escape(word)}(?!\w)", "", name, flags=re.IGNORECASE)
    return name.strip(" ,;:-–()")


def _numbers_between(
    sheet: Sheet, wanted: Wanted, matches: Sequence[Match], rows: tuple[int, int]
) -> bool:
    """Tell whether data stands in the columns of a header, between the two rows."""
    required = {name for group in wanted.required for name in group}
    columns = [match.index for match in matches if match.quantity in required]
    return any(
        sum(is_number(sheet.cell(at, column)) for column in columns) > len(columns) // 2
        for at in range(rows[0] + 1, rows[1])
    )


def is_electrical(text: str) -> bool:
    """Tell whether a name is of the speed of a motor's field.

    >>> [is_electrical(one) for one in ("Speed (ERPM)", "RPM (el.)", "RPM", "Electric motor speed")]
    [True, True, False, False]
    """
    return pattern_of("electrical").search(text) is not None


def is_mapped(column: Column, text: str) -> bool:
    """Tell whether a header is the one that vehicle.yaml states, with or without its unit."""
    wanted = plain(column.header)
    return plain(text) == wanted or any(plain(h.name) == wanted for h in split_header(text))


def letter_of(column: Column) -> str | None:
    """Return the letter where vehicle.yaml states a column by its letter ("column B")."""
    found = _BY_LETTER.fullmatch(column.header.strip())
    return found[1].upper() if found else None
