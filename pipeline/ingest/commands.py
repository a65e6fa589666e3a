"""Commands of a bench test in codes: codes, per cent, shares of full throttle, pulse widths."""

import re
from collections.abc import Collection, Iterator, Sequence

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_table import Reading, Table
from pipeline.ingest.blocks import heading_text
from pipeline.ingest.cells import shorten
from pipeline.ingest.rows import listed
from pipeline.ingest.unit_text import parts_of_whole
from pipeline.ingest.vocabulary import plain, words_of
from pipeline.vehicle.schema import Vehicle

#: Of the range: pulses that go further were made for another one, and so, maybe, those that end
#: well within it.
_BEYOND, _WITHIN, _REACHES = 1.02, 0.85, 0.97
#: Full command in other counts, and the share of the largest code below which any end is doubtful.
_OTHER_ENDS, _LITTLE = frozenset({100, 127, 128, 255, 256, 500, 511, 512, 1000, 1023, 1024}), 0.5
_RANGE = re.compile(
    r"(?<![\d.,])(\d{3,4})\s*(?:-|\u2013|\u2014|\.{2,3}|\u2026|to|до)\s*(\d{3,4})(?![\d.,])"
)
#: Codes that end so are pulse widths less the neutral one.
_HALF_RANGES_US = frozenset({450, 500, 600, 700})
#: Beyond these it is no pulse width at all, which has its own message.
_SHORTEST_US, _LONGEST_US = 500.0, 2600.0
#: Thrust at the neutral pulse, over the largest, above which it is not neutral.
_NEUTRAL_SHARE = 0.1
#: Of the value at the pulse next to neutral: where that at the shortest is less, it grows through
#: neutral.
_FALLS_TO = 0.8

#: Of half the range: pulses evenly about another middle than the neutral one; the least of them.
_OFF, _LEAST_PULSES, _TINY = 0.01, 7, 1e-12

_THROTTLE = words_of("groups", "throttle")


def command_in_codes(table: Table) -> Iterator[Problem]:
    """Give each reading a code, whatever the command was counted in."""
    pwm, code_max = table.vehicle.columns.mooring.pwm_range, table.vehicle.drive.code_max
    scale = 1.0
    if "code" in table.block.columns:
        codes = [(one.row, one.values["code"]) for one in table.live() if "code" in one.values]
        scale, said = _command_scale(table, codes)
        yield from said

    def with_code(one: Reading) -> Reading:
        if "code" in one.values:
            return one.with_values(code=round(one.values["code"] * scale, 9))
        if "pwm" not in one.values:
            return one
        code = (one.values["pwm"] - pwm.neutral_us) * code_max / pwm.half_range_us
        return one.with_values(code=round(code, 9))

    table.change(with_code)


def _command_scale(
    table: Table, codes: Sequence[tuple[int, float]]
) -> tuple[float, tuple[Problem, ...]]:
    """Return what a number of the code column is worth in codes, and what was assumed of it.

    1 where the column counts codes, else what its per cent or its share of full throttle is, of
    the code at full command. `codes` are (row, code).
    """
    column, code_max = table.block.columns["code"], table.vehicle.drive.code_max
    place, header = table.at(table.head, "code"), shorten(column.header)
    largest = max((abs(code) for _, code in codes), default=0.0)
    odd = [(row, code) for row, code in codes if not code.is_integer()]
    throttle = any(plain(word) in plain(column.header).split() for word in _THROTTLE)
    if whole := parts_of_whole(column.unit):
        if not 0.0 < largest <= 1.0:
            return code_max / whole, (percent_note(place, code_max, whole),)
        problem = place.warning(
            f"code is in per cent, but no value is above {largest:g}: these look like shares, "
            f"as a cell that shows 100 % holds 1. So 1 is taken for code {code_max}.",
            "numbers up to 100, or a code column without % in its name.",
            "Write 25 in place of 25 %, and format the cells as plain numbers.",
        )
        return float(code_max), (problem,)
    if 0.0 < largest <= 1.0 < code_max and (odd or throttle):
        what = f'"{header}" has no number above {largest:g}: shares of full throttle, 1 is code '
        return float(code_max), (place.note(f"{what}{code_max}."),)
    if throttle and largest == 100.0 != code_max:
        what = f'"{header}" ends at 100: per cent of full throttle, code {code_max}.'
        return code_max / 100.0, (place.warning(what),)
    if not odd:
        return 1.0, ()
    # often a current or a share
    values = ", ".join(f"{code:g}" for code in sorted({code for _, code in odd})[:6])
    problem = table.at(odd[0][0], "code").warning(
        f"code {values}: a control code is a whole number. The {len(odd)} points are "
        "fitted at the codes as they stand.",
        "whole numbers, as the drive is sent them, or a share with % in the column's name.",
        "Correct the codes, write % into the name, or state the right column in vehicle.yaml "
        f"under columns: {table.kind}: code.",
    )
    return 1.0, (problem,)


def percent_note(place: Place, code_max: int, whole: int = 100) -> Problem:
    """Say what a code in per cent, or per mille, is taken for."""
    if whole == 1000:
        return place.note(f"code is in per mille: 1000 ‰ is taken for code {code_max}.")
    return place.note(f"code is in per cent: 100 % is taken for code {code_max}.")


def codes_in_range(table: Table) -> Iterator[Problem]:
    """Mark the readings beyond the drive's range; none are left where most are."""
    drive = table.vehicle.drive
    codes = {one.row: one.values["code"] for one in table.readings if "code" in one.values}
    rows = {row for row, code in codes.items() if not drive.code_min <= code <= drive.code_max}
    if not rows:
        return
    known = (
        f"codes from {drive.code_min} to {drive.code_max}, as vehicle.yaml states for the drive."
    )
    remedy = "Correct the code in the file, or code_min and code_max in vehicle.yaml."
    low, high = min(codes.values()), max(codes.values())
    if 2 * len(rows) > len(codes):
        if "pwm" in table.block.columns and "code" not in table.block.columns:
            remedy = "Correct columns: mooring: pwm_range (neutral_us, half_range_us) there."
        elif low >= _SHORTEST_US and high <= _LONGEST_US:
            remedy = (
                "If these are pulse widths, say so in vehicle.yaml: columns: {mooring: {pwm: "
                "{header: <name of the column>, unit: us}}}."
            )
        what = (
            f"codes from {low:g} to {high:g}, most of them outside of the drive's range; left out."
        )
        yield table.at(None, "code").error(what, known, remedy)
        table.readings = []
        return
    what = f"code outside of the drive's range in {listed(sorted(rows))}; kept but not fitted."
    yield table.at(min(rows), "code").warning(what, known, remedy)
    table.mark(rows, "code out of range")


def few_codes(codes: Collection[float], folder: Place, vehicle: Vehicle) -> Iterator[Problem]:
    """Say where a folder has one code only, or where codes may count to another end than the drive.

    A code ahead and the same astern are one.
    """
    drive = vehicle.drive
    if len({abs(code) for code in codes}) == 1:
        yield folder.error(
            f"there is one code only ({', '.join(f'{code:g}' for code in sorted(set(codes)))}): "
            "nothing that depends on the code can be fitted.",
            f"several codes from {drive.code_min} to {drive.code_max}.",
            "Add the records of other codes.",
        )
    full = {code: drive.code_max if code > 0.0 else -drive.code_min for code in codes if code}
    far = max(full, key=lambda code: abs(code) / full[code], default=0.0)
    share = abs(far) / full[far] if far else 1.0
    if share <= _LITTLE or (share < 1.0 and abs(far) in _OTHER_ENDS):
        yield folder.warning(
            f"the codes end at {abs(far):g}, and the drive takes {full[far]:g}: full command was "
            "not tested, or they count to another end, as per cent do.",
            "a test up to full command, in codes.",
            "If it was full command, write % into the name of the column, or correct the range "
            "in vehicle.yaml: code_min and code_max of the drive, pwm_range of pulse widths.",
        )


def pwm_problems(table: Table) -> Iterator[Problem]:
    """Say where pulse widths are not of the range that is taken: one-way controllers, other ends.

    The table is left out where neither vehicle.yaml nor a heading states how the pulse widths of
    the readings are to be read; a warning where they end far within the range.
    """
    pwm, quantity = table.vehicle.columns.mooring.pwm_range, table.measured
    pairs = [
        (one.values["pwm"], abs(one.values[quantity]))
        for one in table.live()
        if "pwm" in one.values and quantity in one.values
    ]
    if "code" in table.block.columns or not pairs:
        return
    stated = {"neutral_us", "half_range_us"} <= pwm.model_fields_set
    widths = [width for width, _ in pairs]
    low, high, largest = min(widths), max(widths), max(value for _, value in pairs)
    ends = pwm.neutral_us - pwm.half_range_us, pwm.neutral_us + pwm.half_range_us
    nearest = min(widths, key=lambda one: abs(one - pwm.neutral_us))
    at_nearest, at_low = (
        min((value for width, value in pairs if width == at), default=largest)
        for at in (nearest, low)
    )
    reach = max(high - pwm.neutral_us, pwm.neutral_us - low)
    said = _range_in_text(f"{table.block.columns['pwm'].header} {heading_text(table.block.above)}")
    taken = f"{ends[0]:g} to {ends[1]:g} us"
    place = table.at(table.head, "pwm")
    if said is not None and not stated and said != ends:
        why = (
            f"the heading says pulse widths from {said[0]:g} to {said[1]:g} us, and {taken} is "
            "assumed"
        )
        low, high = said
    elif (
        not stated
        and reach > _BEYOND * pwm.half_range_us
        and (high < _LONGEST_US and low > _SHORTEST_US)
    ):
        why = f"pulse widths from {low:g} to {high:g} us go beyond the assumed range of {taken}"
    elif (
        low > _SHORTEST_US
        and at_nearest > _NEUTRAL_SHARE * largest > 0.0
        and at_low < _FALLS_TO * at_nearest
        and low < pwm.neutral_us - 1.0
    ):
        name, unit = quantity.replace("_", " "), "N" if quantity == "thrust" else "rpm"
        why = (
            f"at {nearest:g} us, next to {pwm.neutral_us:g} us that is taken for neutral, {name} "
            f"is {at_nearest:.3g} {unit}, and at {low:g} us {at_low:.3g} {unit}"
        )
    elif not stated and said is None and (middle := _other_middle(pairs, pwm.neutral_us)):
        why = (
            f"pulse widths lie evenly about {middle:g} us, and so does the thrust; "
            f"{pwm.neutral_us:g} us is assumed for rest"
        )
    elif stated and said not in {None, ends}:
        yield place.warning(
            f"the heading says pulse widths of another range than vehicle.yaml, {taken}."
        )
        return
    elif reach < (_WITHIN if stated else _REACHES) * pwm.half_range_us:
        yield place.warning(
            f"pulse widths from {low:g} to {high:g} us end far within the range of {taken}: full "
            "command was not tested, or the range is another.",
            remedy="Correct columns: mooring: pwm_range in vehicle.yaml if it is.",
        )
        return
    elif not stated and pwm.half_range_us < table.vehicle.drive.code_max in _HALF_RANGES_US:
        yield place.warning(
            f"pulse widths end at {low:g} and {high:g} us and are taken for full command, code "
            f"{table.vehicle.drive.code_max}; codes of that end are often pulse widths from "
            "neutral, of which this would be a part.",
            remedy="State columns: mooring: pwm_range in vehicle.yaml.",
        )
        return
    else:
        return
    one_way = low < pwm.neutral_us - 1.0 and at_low < _NEUTRAL_SHARE * largest
    neutral = low if one_way else (low + high) / 2.0
    yield table.leave_out(
        place.error(
            f"{why}. So the table was left out.",
            "the pulse width of rest, and how far from it full throttle is.",
            "State it in vehicle.yaml:\n  columns:\n    mooring:\n      pwm_range: "
            f"{{neutral_us: {neutral:g}, half_range_us: {high - neutral:g}}}"
            + (" # one way: it rests at the shortest pulse" if one_way else ""),
        )
    )


def _other_middle(pairs: Sequence[tuple[float, float]], neutral_us: float) -> float | None:
    """Return the middle of pulse widths where it, and no neutral one, is where thrust rests.

    Two things must say so: the pulses (width, size of what was measured) are as many and as far on
    both sides of it, and sizes are alike there that are not alike about the neutral one.
    """
    widths = np.unique([width for width, _ in pairs])
    middle = float(widths[0] + widths[-1]) / 2.0
    half = float(widths[-1]) - middle
    if abs(middle - neutral_us) < _OFF * half or np.ptp(widths + widths[::-1]) > 2.0 * _OFF * half:
        return None
    sizes = np.array([np.mean([one for at, one in pairs if at == width]) for width in widths])

    def unlike(about: float) -> float:
        """Return how far the two sides are from being in one proportion."""
        reach = min(float(widths[-1]) - about, about - float(widths[0]))
        steps = np.linspace(0.2, 1.0, 9) * reach
        ahead, astern = (np.interp(about + sign * steps, widths, sizes) for sign in (1.0, -1.0))
        factor = float(ahead @ astern) / max(float(astern @ astern), _TINY)
        size = float(np.linalg.norm(ahead))
        return float(np.linalg.norm(ahead - factor * astern)) / max(size, _TINY)

    is_rest = widths.size >= _LEAST_PULSES and 2.0 * unlike(middle) < unlike(neutral_us)
    return middle if is_rest else None


def _range_in_text(text: str) -> tuple[float, float] | None:
    """Return the range of pulse widths that a heading states.

    >>> _range_in_text("PWM (1000-2000), us"), _range_in_text("ШИМ от 1100 до 1900")
    ((1000.0, 2000.0), (1100.0, 1900.0))
    """
    found = {(float(low), float(high)) for low, high in _RANGE.findall(text)}
    good = [one for one in found if _SHORTEST_US <= one[0] < one[1] <= _LONGEST_US]
    return good[0] if len(good) == 1 else None


def pwm_note(file: Place, vehicle: Vehicle) -> Problem:
    """Say how pulse widths become codes."""
    pwm = vehicle.columns.mooring.pwm_range
    stated = {"neutral_us", "half_range_us"} <= pwm.model_fields_set
    what = (
        f"pulse width becomes a code by (pwm - {pwm.neutral_us:g} us) / {pwm.half_range_us:g} us "
        f"* {vehicle.drive.code_max}{'' if stated else ', which is assumed'}."
    )
    remedy = "" if stated else "State columns: mooring: pwm_range in vehicle.yaml."
    return file.note(what, "", remedy)
