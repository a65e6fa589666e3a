"""Commands of a mooring test in codes: codes, per cent, shares of full throttle, pulse widths."""

from collections.abc import Sequence
from dataclasses import replace

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import Reading
from pipeline.ingest.blocks import Block
from pipeline.ingest.code_units import command_scale, fractional_codes
from pipeline.ingest.unit_text import is_percent
from pipeline.vehicle.bench_schema import Pwm
from pipeline.vehicle.schema import Vehicle

#: Of the assumed range: pulses that go further than this were made for another one.
_BEYOND = 1.02
#: Thrust at the neutral pulse, over the largest, above which it is not neutral.
_NEUTRAL_SHARE = 0.1


def code_from_pwm(pulse_width_us: float, pwm: Pwm, code_max: int) -> float:
    """Return the code that a pulse width stands for.

    >>> code_from_pwm(1700.0, Pwm(neutral_us=1500.0, half_range_us=400.0), 127)
    63.5
    """
    return (pulse_width_us - pwm.neutral_us) * code_max / pwm.half_range_us


def command_in_codes(
    block: Block, readings: tuple[Reading, ...], vehicle: Vehicle, problems: list[Problem]
) -> tuple[Reading, ...]:
    """Return the readings with a code each, whatever the command was counted in.

    Parameters
    ----------
    block : Block
        The table.
    readings : tuple of Reading
        As the cells stand.
    vehicle : Vehicle
        Range of the codes and of the pulse widths.
    problems : list of Problem
        What was assumed is added here.
    """
    pwm, code_max = vehicle.columns.mooring.pwm_range, vehicle.drive.code_max
    if "code" in block.columns:
        numbers = [
            (one.row, one.values["code"])
            for one in readings
            if "code" in one.values and not one.marks
        ]
        codes = [number for _, number in numbers]
        scale = command_scale(block, codes, code_max, problems)
        if scale == 1.0 and not is_percent(block.columns["code"].unit):
            problems += fractional_codes(numbers, lambda row: block.place(row, "code"), "mooring")
    done: list[Reading] = []
    for one in readings:
        values = one.values
        code = values["code"] * scale if "code" in values else None
        if code is None and "pwm" in values:
            code = code_from_pwm(values["pwm"], pwm, code_max)
        # Adding 0.0 turns -0.0 into 0.0.
        done.append(
            one if code is None else replace(one, values={**values, "code": round(code, 9) + 0.0})
        )
    return tuple(done)


def pwm_problem(block: Block, readings: Sequence[Reading], vehicle: Vehicle) -> Problem | None:
    """Refuse pulse widths that are not of the assumed range: one-way controllers, other ends.

    Returns
    -------
    Problem or None
        None where vehicle.yaml states the range, or nothing contradicts the assumed one.
    """
    pwm = vehicle.columns.mooring.pwm_range
    pairs = [
        (one.values["pwm"], one.values["thrust"])
        for one in readings
        if "pwm" in one.values and "thrust" in one.values and not one.marks
    ]
    if "code" in block.columns or not pairs:
        return None
    stated = {"neutral_us", "half_range_us"} <= pwm.model_fields_set
    low, high = min(one for one, _ in pairs), max(one for one, _ in pairs)
    largest = max(abs(thrust) for _, thrust in pairs)
    at_neutral = [abs(t) for w, t in pairs if abs(w - pwm.neutral_us) < 1.0]
    at_low = [abs(t) for w, t in pairs if w == low]
    limit = _BEYOND * pwm.half_range_us
    beyond = max(high - pwm.neutral_us, pwm.neutral_us - low) > limit
    if not stated and beyond and max(high, -low) < _LONGEST_US and low > _SHORTEST_US:
        why = f"pulse widths from {low:g} to {high:g} us go beyond the assumed range of "
        why += (
            f"{pwm.neutral_us - pwm.half_range_us:g} to {pwm.neutral_us + pwm.half_range_us:g} us"
        )
    elif (
        at_neutral
        and largest > 0.0
        and min(at_neutral) > _NEUTRAL_SHARE * largest
        and min(at_low) < 0.5 * min(at_neutral)
        and low < pwm.neutral_us - 1.0
    ):
        why = f"at {pwm.neutral_us:g} us, which is taken for neutral, thrust is "
        why += f"{min(at_neutral):.3g} N, and at {low:g} us {min(at_low):.3g} N"
    else:
        return None
    one_way = min(at_low, default=largest) < _NEUTRAL_SHARE * largest
    neutral = low if one_way else (low + high) / 2.0
    return Problem(
        "error",
        block.place(block.header_row, "pwm"),
        f"{why}. So the table was left out.",
        "the pulse width of rest, and how far from it full throttle is.",
        "State it in vehicle.yaml:\n  columns:\n    mooring:\n      pwm_range: "
        f"{{neutral_us: {neutral:g}, half_range_us: {high - neutral:g}}}"
        + (" # one way: it rests at the shortest pulse" if one_way else ""),
    )


#: Beyond these it is no pulse width at all, which has its own message.
_SHORTEST_US, _LONGEST_US = 500.0, 2600.0


def pwm_note(file: str, vehicle: Vehicle) -> Problem:
    """Say how pulse widths become codes."""
    pwm = vehicle.columns.mooring.pwm_range
    stated = {"neutral_us", "half_range_us"} <= pwm.model_fields_set
    what = (
        f"pulse width becomes a code by (pwm - {pwm.neutral_us:g} us) / {pwm.half_range_us:g} us "
        f"* {vehicle.drive.code_max}{'' if stated else ', which is assumed'}."
    )
    remedy = "" if stated else "State columns: mooring: pwm_range in vehicle.yaml."
    return Problem("note", Place(file), what, "", remedy)
