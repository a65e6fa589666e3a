"""Readings and the sign of their command: sizes without a sign, sensors turned round, slips."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Reading, Table, numbers
from pipeline.ingest.readings import COMMENTED, STATISTICS
from pipeline.ingest.rows import counted, listed
from pipeline.types import BoolArray, FloatArray

#: Below this share of the largest one a sign says nothing: noise, tare.
_THRUST_SHARE, _LOAD_SHARE = 0.05, 0.03
#: Of the largest thrust: a larger tare is looked at twice.
_MOST_TARE, _ALL_TARE = 0.2, 0.9
#: Fewer rows against their code are slips of the pen.
_LEAST_OF_A_SIGN = 3


@dataclass(frozen=True)
class Signs:
    """Which readings (n,) have a sign that counts, which of these contradict it."""

    counts: BoolArray
    wrong: BoolArray
    is_size: bool
    """Whether they are positive at all codes, some of which are negative."""

    @property
    def are_turned(self) -> bool:
        """Whether all of them contradict it."""
        return bool((self.wrong == self.counts).all())


def signs_of(values: FloatArray, codes: FloatArray, least: float = 0.0) -> Signs:
    """Compare the signs of readings (n,), NaN where there is none, with those of their codes."""
    counts = (np.abs(values) > least) & (codes != 0.0)
    wrong = counts & (codes * values < 0.0)
    positive = counts & (values > 0.0)
    return Signs(counts, wrong, bool(wrong.any() and (positive == counts).all()))


def signed_thrust(
    table: Table, codes: FloatArray, thrust_n: FloatArray, used: BoolArray, tare_n: float
) -> tuple[FloatArray, BoolArray] | None:
    """Check that thrust (n,), without its tare [N], goes with the code; None leaves the table out.

    Returns what each thrust and its tare are to be multiplied by, and which stay against their
    code. Where thrust is never negative although codes are, it was written as a size and is given
    the sign of its code. Where it goes against most codes, the table is left out: a sensor the
    other way round is the engineer's to state. Single rows are named.
    """
    say, largest = table.problems.append, float(np.max(np.abs(thrust_n[used]), initial=0.0))
    found = signs_of(np.where(used, thrust_n, 0.0), codes, _THRUST_SHARE * largest)
    one_sided = not ((codes < 0.0) & used).any() or not ((codes > 0.0) & used).any()
    number, total = int(found.wrong.sum()), int(found.counts.sum())
    as_it_is = np.ones(len(codes)), found.wrong
    # a tare that is a good part of the thrust may be the full thrust of the other direction
    before = thrust_n[found.counts] + (0.0 if number else tare_n)
    is_mixed = min(number, total - number) >= _LEAST_OF_A_SIGN
    if not number:
        # one that the thrust of every other row is less than may be full reverse
        most = max(float(np.abs(before).max(initial=0.0)), largest)
        both = {-1.0, 1.0} <= set(np.sign(before)) or abs(tare_n) > _ALL_TARE * most
        is_mixed = both and abs(tare_n) > _MOST_TARE * largest
    elif found.is_size:
        say(
            table.place.warning(
                f"thrust is positive at all {number} negative codes: read as a size without sign, "
                "and given the sign of its code.",
                "negative thrust at negative codes.",
                "Write the minus signs if the thruster really pulled backwards.",
            )
        )
        return np.where(codes < 0.0, -1.0, 1.0), np.zeros(len(codes), np.bool_)
    if one_sided and is_mixed:
        against = int((before * (-1.0 if codes.min() < 0.0 else 1.0) < 0.0).sum())
        say(
            table.place.error(
                f"thrust has both signs ({against} of {before.size} rows against the code), and "
                "the codes have one: rest is not at code 0, or something else parts the rows. So "
                "the table was left out.",
                "codes with signs, 0 at rest.",
                "Write the codes with signs, or state the column of the direction in vehicle.yaml: "
                "columns: {mooring: {direction: {header: ..., reverse: [...]}}}.",
            )
        )
        return None
    expected = "positive thrust at positive codes."
    if 2 * number > total:
        say(
            table.place.error(
                f"thrust has the sign opposite to its code in {number} of {total} rows; left out.",
                expected,
                "If the force sensor was mounted the other way round, say so in vehicle.yaml: "
                "columns: {mooring: {thrust: {header: <name of the column>, sign: -1}}}, or take "
                "that sign out if it is there.",
            )
        )
        return None
    if number:
        named = [one.row for one, at in zip(table.readings, found.wrong, strict=True) if at]
        what = f"thrust has the sign opposite to its code in {listed(named)}; left out."
        say(table.at(named[0]).warning(what, expected, "Correct the sign or the code."))
    return as_it_is


def with_signs_of_codes(table: Table) -> Iterator[Problem]:
    """Give speed and torque of a load test the sign of a negative code where they have none.

    A drive that motors has both signs of its code: with none of either, nothing else is meant. One
    of them alone without a sign is a size only where positive codes stand beside it.
    """
    live = table.live()
    codes = _codes(live)
    unsigned = [name for name in _MOTORING if signs_of(numbers(live, name), codes).is_size]
    if not unsigned or (len(unsigned) == 1 and not (codes > 0.0).any()):
        return

    def signed(one: Reading) -> Reading:
        sizes = {name: -abs(one.values[name]) for name in unsigned}
        return one.with_values(**sizes) if one.values.get("code", 0.0) < 0.0 else one

    names = " and ".join("speed" if name == "shaft_speed" else name for name in unsigned)
    yield table.at(live[int(np.argmax(codes < 0.0))].row).note(
        f"{names} stand without sign at the negative codes: given the sign of the code."
    )
    table.change(signed)


def check_signs(table: Table) -> Iterator[Problem]:
    """Mark readings outside of the motoring quadrant of their code; signs are never changed.

    The warning names the likely cause.
    """
    live = [one for one in table.readings if not {COMMENTED, STATISTICS} & set(one.marks)]
    if not live:
        return
    speed, codes = numbers(live, "shaft_speed"), _codes(live)
    # Without a code, or at code 0, the direction of turning is all there is.
    sense = np.where(codes == 0.0, np.sign(speed), codes)
    for quantity, mark in (
        ("torque", "negative torque"),
        ("shaft_speed", "speed against the code"),
    ):
        values = numbers(live, quantity)
        found = signs_of(values, sense, _LOAD_SHARE * float(np.abs(values).max()))
        if found.wrong.any():
            # of a table turned round the few points near zero say nothing either
            rows = [
                one.row for one, at in zip(live, found.wrong, strict=True) if at or found.are_turned
            ]
            table.mark(set(rows), mark)
            yield _against_quadrant(table, quantity, rows, whole=found.are_turned)


_MOTORING = ("shaft_speed", "torque")


def _codes(readings: Sequence[Reading]) -> FloatArray:
    return np.array([one.values.get("code", 0.0) for one in readings])


def _against_quadrant(table: Table, quantity: str, rows: list[int], *, whole: bool) -> Problem:
    name = quantity.replace("_", " ")
    column = table.block.columns[quantity]
    sense = "code" if "code" in table.block.columns else "code or the turning"
    if whole:
        return table.at(rows[0], quantity).warning(
            f"the {name} has the opposite sign of the {sense} in the whole table: it looks "
            f"like the sign of the sensor. Nothing was turned round; the {len(rows)} points are "
            "kept but not fitted.",
            "speed and torque with the sign of the code where the drive motors.",
            "If the sensor counts the other way, state it in vehicle.yaml:\n"
            f"  columns:\n    load_test:\n      {quantity}: "
            f'{{header: "{column.header}", sign: {-column.sign}}}',
        )
    what = "the drive is driven by the load (regenerating), or the sign is wrong"
    if quantity == "shaft_speed":
        what = "it was turned backwards, or the sign is wrong"
    return table.at(rows[0], quantity).warning(
        f"the {name} is negative (against the {sense}) in {counted(len(rows), 'row')} "
        f"({listed(rows)}): {what}. The points are kept but not fitted.",
        "the motoring quadrant: torque and speed with the sign of the code.",
        'Mark the rows with "#" in column A if they are not steady motoring points.',
    )
