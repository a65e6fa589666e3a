"""Which of several columns holds a quantity: names, units and what the numbers say together."""

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.cells import Sheet, column_letter, shorten
from pipeline.ingest.column_data import ColumnData, ratio_of, read_column, wholes_of
from pipeline.ingest.header_rows import ELECTRICAL, Match, Wanted
from pipeline.ingest.unit_text import UnitTextError, factor, quantities_of
from pipeline.ingest.vocabulary import (
    FIRST_RANK,
    is_other,
    pattern_of,
    plain,
    read_unit_cell,
    unit_fits,
)
from pipeline.types import FloatArray

#: One of these is set and the other follows from it: their columns are weighed together.
_ROLES = {"code": "command", "pwm": "command"}
#: Of these a table has one column; a second one must be explained by the first.
_SINGLE = ("code", "pwm", "thrust", "torque", "shaft_speed", "thrust_coefficient")
#: These are not the same throughout a test; of a load test the shaft speed at one code may be.
_VARIED = ("code", "pwm", "thrust")
#: No test is without these where they were measured.
_CHANNELS = ("current", "voltage", "input_power", "output_power")
#: Above this lead of its name a column needs no other reason.
_LEAD = 15
#: What a name loses that is one letter, or has no unit where one is due.
_UNCLEAR = 20
#: Correlation of a code with the pulse width that it is sent as, and the least rows to tell it.
_TOGETHER, _LEAST_COMMANDS = 0.98, 5
#: Two units of one reading differ by rounding, and by the gravity somebody converted with.
_SAME = 0.03
_PULSE_WIDTHS_US = (400.0, 3000.0)
#: Below it they may be milliseconds.
_LEAST_CODE = 20.0
_UNITS_ROWS = 3
_COUNTED, _SIDE, _THRUSTER = map(pattern_of, ("numbered", "side", "thruster"))
_LEAST_THRUSTERS = 3
#: Columns of one name from which a table is a grid, which has its own message.
_GRID = 4


class ColumnChoice:
    """The columns under one row of names, weighed against each other.

    `matches` are those left to read, at most one of a quantity for each table, where the others are
    explained: `not_used` says why not; `problems` are told where none leads clearly.
    """

    def __init__(
        self, sheet: Sheet, wanted: Wanted, row: int, following: int, matches: Sequence[Match]
    ) -> None:
        """Leave out what cannot be, and choose among what is left."""
        self.matches = list(matches)
        self.not_used: dict[int, str] = {}
        self.problems: list[Problem] = []
        self._sheet = sheet
        self._wanted = wanted
        self._row = row
        self._rows = (row + 1, min(following, sheet.last_row + 1) - 1)
        self._data: dict[int, ColumnData] = {}
        self._with_codes_called_pulses()
        self._without_impossible()
        self._with_electrical_speed()
        stems = [(one.quantity, _stem(one)) for one in self.matches]
        counts = [Counter(stem for name, stem in stems if name in g) for g in wanted.required]
        # whole tables stand side by side where everything that a table needs is twice
        if not all(one and max(one.values()) > 1 for one in counts):
            for quantity in _SINGLE:
                needed = any(quantity in group for group in self._wanted.required)
                if needed or quantity in _ROLES:
                    self._choose(quantity)
            self._commands_agree()

    def _numbers(self, match: Match) -> ColumnData:
        if match.index not in self._data:
            self._data[match.index] = read_column(self._sheet, match.index, self._rows)
        return self._data[match.index]

    def _with_codes_called_pulses(self) -> None:
        """Take what is called a pulse width, without a unit and too small for one, for a code."""
        for at, match in enumerate(self.matches):
            is_bare = match.quantity == "pwm" and not (match.header.odd_unit or self._unit(match))
            largest = self._numbers(match).largest if is_bare else 0.0
            if 0.0 < largest <= 1.0 or _LEAST_CODE <= largest < _PULSE_WIDTHS_US[0]:
                self.matches[at] = replace(match, quantity="code")

    def _without_impossible(self) -> None:
        """Leave out the columns that contradict their name, where another one stands for them."""
        faults = {id(match): self._fault(match) for match in self.matches}
        kept: list[Match] = []
        for match in self.matches:
            fault = faults[id(match)]
            role = _ROLES.get(match.quantity, match.quantity)
            others = [
                other
                for other in self.matches
                if _ROLES.get(other.quantity, other.quantity) in {role, f"electrical_{role}"}
                and other is not match
                and not faults[id(other)]
                # a channel that is dead is not replaced by one of something else
                and (other.quantity != match.quantity or other.score > match.score - _LEAD)
            ]
            stated = match.quantity in self._wanted.mapping
            alone_no = fault in {_COUNTS, _CONSTANT} and self._is_symbol(match)
            if fault and not stated and (others or alone_no):
                self.not_used[match.index] = fault
            else:
                kept.append(match)
        best = {one.quantity: one for one in sorted(kept, key=lambda one: one.score)}
        dead = {name for name in _CHANNELS if name in best and faults[id(best[name])] == _ZERO}
        self.matches = [
            one for one in kept if one.quantity not in dead - self._wanted.mapping.keys()
        ]
        for match in kept:
            if match not in self.matches:
                self.not_used[match.index] = faults[id(match)] or "the channel of this is dead"

    def _is_symbol(self, match: Match) -> bool:
        return match.header.name.strip() in self._wanted.vocabulary[match.quantity].symbols

    def _fault(self, match: Match) -> str:
        """Return why a column cannot hold its quantity; empty where nothing speaks against it."""
        data, quantity = self._numbers(match), match.quantity
        words = self._wanted.vocabulary.get(quantity)
        if words is None:
            return ""
        varied = (*_VARIED, "shaft_speed") if self._wanted.kind == "mooring" else _VARIED
        by_numbers = (
            (data.is_blank, "it holds no number"),
            (data.is_zero, _ZERO),
            (quantity in varied and data.is_constant, _CONSTANT),
            (quantity in ("code", "thrust", "torque", "shaft_speed") and data.is_counter, _COUNTS),
        )
        fault = next((why for is_so, why in by_numbers if is_so), "")
        unit = self._unit(match)
        if fault or unit is None:
            return fault
        if words.unit_kind is None:
            return "" if "ratio" in quantities_of(unit) else f"{unit} is no unit of a {quantity}"
        if not unit_fits(unit, words):
            return f"{unit} is no unit of {quantity.replace('_', ' ')}"
        low, high = _PULSE_WIDTHS_US
        if quantity == "pwm" and not low <= data.largest * factor(unit, "pulse_width") <= high:
            return f"numbers up to {data.largest:g} {unit} are no pulse widths"
        return ""

    def _with_electrical_speed(self) -> None:
        """Take no electrical speed for the shaft's, unless the stand says that it converted it."""
        electrical = [match for match in self.matches if match.quantity == ELECTRICAL]
        self.matches = [match for match in self.matches if match.quantity != ELECTRICAL]
        names = {plain(str(cell)) for cell in self._sheet.cells(self._row) if cell is not None}
        by_stand = any(name.startswith("motor optical speed") for name in names)
        kind = self._wanted.kind
        for match in electrical:
            place = self._sheet.place(self._row, column_letter(match.index))
            header = shorten(match.text)
            if any(other.quantity == "shaft_speed" for other in self.matches):
                self.not_used[match.index] = "another column holds the speed of the shaft"
            elif by_stand:
                self.matches.append(replace(match, quantity="shaft_speed"))
                what = (
                    f'shaft speed is read from "{header}": the stand has divided it '
                    "by the pole pairs that were set there, and measured no other speed."
                )
                self.problems.append(place.note(what))
            else:
                self.not_used[match.index] = "the pole pairs of the motor are not stated"
                say = place.error if kind == "load_test" else place.warning
                self.problems.append(
                    say(
                        f'"{header}" is the speed of the motor\'s field, which is that of the '
                        "shaft times its pole pairs; it was not read.",
                        "the speed of the shaft, or the number of pole pairs.",
                        f"State it in vehicle.yaml:\n  columns:\n    {kind}:\n      shaft_speed: "
                        f'{{header: "{header}", unit: rpm, pole_pairs: ...}}',
                    )
                )

    def _choose(self, quantity: str) -> None:
        """Explain every second column of a quantity by the first, or refuse the table."""
        of_quantity = [match for match in self.matches if match.quantity == quantity]
        for candidates in self._by_branch(of_quantity):
            is_grid = len(candidates) >= _GRID and len({one.text for one in candidates}) == 1
            if len(candidates) < 2 or is_grid:
                continue
            left = self._unexplained(candidates)
            for match in candidates:
                if match.index in self.not_used:
                    self.matches.remove(match)
            if len(left) < 2 or _are_thrusters(left):
                continue
            self.problems.append(self._tie(quantity, left))
            for match in left:
                self.matches.remove(match)
                self.not_used[match.index] = "another column may be meant as well"

    def _by_branch(self, matches: Sequence[Match]) -> list[list[Match]]:
        """Part the columns by what their names say of branch or direction."""
        groups: dict[tuple[str, ...], list[Match]] = {}
        for match in matches:
            words = f" {plain(match.header.name)} "
            told = tuple(word for word in self._wanted.split_words if f" {plain(word)} " in words)
            if any(_is_of_sides(match, other) for other in matches if other is not match):
                told = ()  # "front" and "back" are places of two sensors, no directions
            groups.setdefault(told, []).append(match)
        return list(groups.values())

    def _unexplained(self, candidates: Sequence[Match]) -> list[Match]:
        """Return the columns that may be meant; of the others `not_used` says why they are not."""
        numbers = [self._in_record_unit(match) for match in candidates]
        wholes = wholes_of(numbers)
        if len(wholes) > 1:
            # of columns that all but equal each other each is the mean of the others
            wholes = [one for one in wholes if is_other(candidates[one[0]].header, FIRST_RANK)]
        if wholes:
            at, kind = max(wholes, key=lambda one: candidates[one[0]].score)
            kept = candidates[at]
            for match in candidates:
                if match is not kept:
                    self.not_used[match.index] = f'"{shorten(kept.text)}" is the {kind} of these'
            return [kept]
        order = sorted(range(len(candidates)), key=lambda at: -self._clarity(candidates[at]))
        left: list[int] = []
        for at in order:
            match = candidates[at]
            first = candidates[order[0]]
            ratio = ratio_of(numbers[order[0]], numbers[at])
            lead = self._clarity(first) - self._clarity(match)
            if ratio is not None and ratio.spread <= 2 * _SAME:
                lead = first.score - match.score  # numbers in proportion weigh alike
            same = (
                self._same_reading(candidates[one], match, (numbers[one], numbers[at]))
                for one in left
            )
            reason = next(filter(None, same), "")
            if not reason and lead >= _LEAD and not _is_of_sides(first, match):
                reason = f'"{shorten(first.text)}" names the quantity more clearly'
            if reason:
                self.not_used[match.index] = reason
            else:
                left.append(at)
        return [candidates[at] for at in sorted(left)]

    def _clarity(self, match: Match) -> int:
        """Return how clearly a name and a unit say the quantity: a letter alone says little."""
        return match.score - _UNCLEAR * (self._is_symbol(match) + self._lacks_unit(match))

    def _lacks_unit(self, match: Match) -> bool:
        unit_due = self._wanted.vocabulary[match.quantity].unit_kind is not None
        return unit_due and self._unit(match) is None

    def _commands_agree(self) -> None:
        """Refuse codes and pulse widths that do not go together; a letter alone is no command."""
        pulses = [match for match in self.matches if match.quantity == "pwm"]
        for match in [one for one in self.matches if one.quantity == "code"]:
            counts = self._is_symbol(match) and self._numbers(match).is_even
            against = next(
                (one for one in pulses if counts or not self._go_together(match, one)), None
            )
            if against is None or "code" in self._wanted.mapping:
                continue
            self.matches.remove(match)
            self.not_used[match.index] = f'it does not go with "{shorten(against.text)}"'
            if not self._is_symbol(match):
                self.matches.remove(against)
                self.not_used[against.index] = f'it does not go with "{shorten(match.text)}"'
                self.problems.append(self._tie("code", [match, against]))
                return

    def _go_together(self, first: Match, second: Match) -> bool:
        pairs = np.stack([self._numbers(first).values, self._numbers(second).values])
        pairs = pairs[:, np.isfinite(pairs).all(axis=0)]
        if pairs.shape[1] < _LEAST_COMMANDS or not np.ptp(pairs, axis=1).all():
            return True
        return float(np.corrcoef(*pairs)[0, 1]) > _TOGETHER

    def _same_reading(
        self, kept: Match, match: Match, numbers: tuple[FloatArray, FloatArray]
    ) -> str:
        found = ratio_of(*numbers)
        if found is None:
            return ""
        same_unit = self._unit(kept) == self._unit(match)
        if found.is_equal and not _is_of_sides(kept, match):
            return f'it repeats "{shorten(kept.text)}"'
        scaled = kept.quantity in _ROLES and found.spread <= _SAME
        if scaled or (
            not same_unit and abs(found.median - 1.0) <= _SAME and found.spread <= 2 * _SAME
        ):
            return f'it is the reading of "{shorten(kept.text)}" in another unit'
        return ""

    def _unit(self, match: Match) -> str | None:
        rows = range(self._row + 1, min(self._row + 1 + _UNITS_ROWS, self._rows[1] + 1))
        cells = (self._sheet.cell(row, match.index) for row in rows)
        below = (read_unit_cell(cell) for cell in cells if isinstance(cell, str))
        shown = self._sheet.units_shown(match.index, self._rows)
        return next(filter(None, (match.header.unit, *below, *shown)), None)

    def _in_record_unit(self, match: Match) -> FloatArray:
        unit, kind = self._unit(match), self._wanted.vocabulary[match.quantity].unit_kind
        worth = 1.0
        with suppress(UnitTextError):
            worth = factor(unit, kind) if unit and kind else 1.0
        return np.asarray(self._numbers(match).values * worth)

    def _tie(self, quantity: str, matches: Sequence[Match]) -> Problem:
        """Refuse a table whose quantity several columns may hold, and say what each would give."""
        name = quantity.replace("_", " ")
        shown = [
            f'{column_letter(match.index)} "{shorten(match.text)}" '
            f"({self._numbers(match).largest:g} at most)"
            for match in matches[:4]
        ]
        unit = ", unit: ..." if self._lacks_unit(matches[0]) else ""
        line = f'      {quantity}: {{header: "{shorten(matches[0].text)}"{unit}}}'
        also = ""
        if len({self._unit(match) for match in matches}) == 1 and len(matches) == 2:
            also = (
                "\nor, where both share the load, the sum of them:\n"
                f'      {quantity}: {{header: "{shorten(matches[0].text)}", plus: '
                f'["{shorten(matches[1].text)}"]}}'
            )
        return self._sheet.place(self._row, column_letter(matches[0].index)).error(
            f"{name} may be {' or '.join(shown)}; nothing tells which. So the table was left out.",
            "one column of it, a second one only as the same reading in another unit, or as a part "
            "of a sum that stands there, too.",
            f"State it in vehicle.yaml:\n  columns:\n    {self._wanted.kind}:\n{line}{also}",
        )


_ZERO = "it is 0 throughout: not connected?"
_COUNTS, _CONSTANT = "it counts the rows", "it never changes"


def _stem(match: Match) -> str:
    return " ".join(_COUNTED.sub("", plain(match.header.name)).split())


def _is_of_sides(first: Match, second: Match) -> bool:
    """Tell whether two names are of two places: each sensor there takes its share of a load."""
    one, two = (set(plain(match.header.name).split()) for match in (first, second))
    return any(map(_SIDE.fullmatch, one - two)) and any(map(_SIDE.fullmatch, two - one))


def _are_thrusters(matches: Sequence[Match]) -> bool:
    """Tell whether columns are of several thrusters: "T1" to "T4"."""
    stems = {_stem(match) for match in matches}
    numbered = all(_COUNTED.search(match.header.name) for match in matches)
    return (
        len(matches) >= _LEAST_THRUSTERS
        and numbered
        and len(stems) == 1
        and _THRUSTER.fullmatch(stems.pop()) is not None
    )


def told_apart(matches: Sequence[Match]) -> Mapping[int, str]:
    """Return the names of columns that are of several thrusters, by column index."""
    return {match.index: match.header.name for match in matches} if _are_thrusters(matches) else {}
