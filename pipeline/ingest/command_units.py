"""Commands that state no unit, or no rest: what their values say of both.

A command of -1 to 1 rests at 0; one of 0 to 1 may rest at 0 (one way) or at 0.5, where 0 is full
reverse. The same goes for counts whose rest is the middle of what they can be, and for pulse widths
of a controller that rests at the shortest. Where a log begins, where it dwells and what it never
reaches weigh together; what they do not tell is not guessed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.records.pool_schema import PulseWidth
from pipeline.types import FloatArray

_RATIO, _PERCENT = 1.0, 100.0
#: Half of what a count may reach: per cent, degrees of a servo, 8, 10, 11, 12 and 16 bits.
_MIDDLES = frozenset({50, 90, 127, 128, 511, 512, 1023, 1024, 2047, 2048, 32767, 32768})
#: A command is at a value within this share of it.
_AT = 0.02
#: What codes and per cent often go to; commands of so many levels that reach it so often are held
#: there by a limit. Per cent of whole codes are rounded by less than this of a code.
_FULL_SCALES = (100, 127, 128, 255, 256, 400, 500, 512, 1000, 1023, 1024)
_MANY, _OFTEN, _ROUNDED = 15, 5, 0.07
#: A vehicle dwells where it does so in this share of its readings; full reverse of all, in this.
_DWELLS, _PASSES = 0.2, 0.05
#: Evidence in nats: taken for the rest above, asked for above, none below.
_SURE, _POSSIBLE = 5.0, 0.5


@dataclass(frozen=True)
class GuessedUnit:
    """Unit of commands that state none, and what in their values tells it.

    `neutral` is what they are at rest; `doubt` what is assumed with it, and `unclear` why nobody
    can tell what they mean.
    """

    unit: str
    why: str
    neutral: float = 0.0
    doubt: str = ""
    unclear: str = ""


def guess_units(
    commands: Mapping[tuple[str, str], FloatArray],
    pwm: PulseWidth,
    stated: Mapping[tuple[str, str], str | None],
    *,
    one_way: bool,
) -> dict[tuple[str, str], GuessedUnit]:
    """Guess the units of commands that come in several topics: by their ranges, and each other.

    Where the unit is `stated` their rest alone is asked; a code is 0 at rest.

    A thruster that is only ever switched has the ratios -1, 0 and 1, whole numbers as codes are;
    beside topics of ratios they are told. `commands` are readings (k, m) by topic and channel, as
    they stand in the messages; `one_way` drives have no reverse.
    """
    guessed = {
        key: GuessedUnit(unit, "") if (unit := stated.get(key)) else _guess_unit(raw)
        for key, raw in commands.items()
    }
    if any(one.unit == "ratio" for one in guessed.values()):
        switched = GuessedUnit("ratio", "all lie between -1 and 1, as do those of other thrusters")
        guessed = {
            key: switched if one.unit == "code" and one.why and _within_one(commands[key]) else one
            for key, one in guessed.items()
        }
    for unit in {one.unit for one in guessed.values()}:
        own = {key: one for key, one in guessed.items() if one.unit == unit}
        if unit == "code":
            own = {key: one for key, one in own.items() if one.why}
        columns = [column for key in own for column in commands[key].T]
        guessed |= {key: rest_of(one, columns, pwm, one_way=one_way) for key, one in own.items()}
    return guessed


def _guess_unit(raw: FloatArray) -> GuessedUnit:
    values = raw[np.isfinite(raw) & (raw != 0.0)]
    if values.size and values.min() >= 800.0 and values.max() <= 2200.0:
        return GuessedUnit("us", "all lie between 800 and 2200")
    if _within_one(raw) and (values % 1.0 != 0.0).any():
        return GuessedUnit("ratio", "all lie between -1 and 1")
    return GuessedUnit("code", "they are neither pulse widths nor ratios")


def _within_one(raw: FloatArray) -> bool:
    """Tell whether commands, some of them not zero, lie between -1 and 1."""
    largest = float(np.abs(raw[np.isfinite(raw)]).max(initial=0.0))
    return 0.0 < largest <= 1.0


def rest_of(
    guessed: GuessedUnit, columns: Sequence[FloatArray], pwm: PulseWidth, *, one_way: bool
) -> GuessedUnit:
    """Tell what commands, a column a thruster, are at rest; `unclear` where two readings remain."""
    finite = [kept for one in columns if (kept := one[np.isfinite(one)]).size]
    first = {round(float(one[0]), 6) for one in finite}
    if not finite or min(float(one.min()) for one in finite) < 0.0:
        return guessed
    if guessed.unit == "us":
        return _with_pulse(guessed, finite, first, pwm)
    full = {"ratio": _RATIO, "%": _PERCENT}.get(guessed.unit)
    begin = first.pop() if len(first) == 1 else np.nan
    middle = full / 2.0 if full is not None else begin if begin in _MIDDLES else 0.0
    score = 0.0 if middle == 0.0 else _score(finite, begin, middle, one_way=one_way)
    lowest = min(float(one.min()) for one in finite)
    if score < _POSSIBLE:
        if full is None or one_way or not full / 2.0 < lowest:
            return guessed
        return replace(
            guessed,
            doubt=f"it is {lowest:.3g} and more throughout, so that its rest is not seen, and 0 is "
            f"taken for it; if rest is {middle:g}, state neutral: {middle:g}",
        )
    line = f"{{quantity: thruster_command, unit: {guessed.unit}, neutral: {middle:g}}}"
    if score >= _SURE and full is not None:
        doubt = (
            f"it begins and dwells at {middle:g} and is never negative, so {middle:g} is taken for "
            f"rest and 0 for full reverse; if 0 is rest, state neutral: 0 in place of {line}"
        )
        return replace(guessed, neutral=middle, doubt=doubt)
    unclear = (
        f"it is never negative and lies on both sides of {middle:g}: either 0 is rest and "
        f"{middle:g} is half ahead, or {middle:g} is rest and 0 is full reverse"
    )
    return replace(guessed, unclear=f"{unclear}; {line}, or with neutral: 0")


def _score(columns: Sequence[FloatArray], begin: float, middle: float, *, one_way: bool) -> float:
    """Return the evidence [nats] that commands rest at the middle of 0 to twice it, not at 0."""
    every = np.concatenate(columns)
    near = [np.abs(one - middle) <= _AT * middle for one in columns]
    none = [one <= _AT * middle for one in columns]
    if every.max() > 2.0 * middle * (1.0 + _AT):
        return 0.0
    above, below = every > middle * (1.0 + _AT), every < middle * (1.0 - _AT)
    return (
        2.0 * (abs(begin - middle) <= _AT * middle)
        - 4.0 * (begin <= _AT * middle)
        + 2.0 * all(one.mean() > _DWELLS for one in near)
        - 4.0 * all(one.mean() > _PASSES for one in none)
        + (2.0 if above.any() and below.any() else -3.0)
        + 1.0 * (abs(float(every.mean()) - middle) < 0.1 * middle)
        - 8.0 * one_way
    )


def _with_pulse(
    guessed: GuessedUnit, columns: Sequence[FloatArray], first: set[float], pwm: PulseWidth
) -> GuessedUnit:
    """Doubt pulse widths that begin and dwell at others than the neutral one.

    At their shortest, or at one of all thrusters that some of them leave to both sides.
    """
    pulses = [one[one > 0.0] for one in columns]
    every = np.concatenate(pulses)
    near = np.abs(every - pwm.neutral_us) <= _AT * pwm.half_range_us
    shortest = float(every.min(initial=np.inf))
    begin = first.pop() if len(first) == 1 else np.nan
    is_least = begin == shortest and shortest < pwm.neutral_us
    leaves = begin - shortest > _AT * pwm.half_range_us < float(every.max(initial=0.0)) - begin
    most = _DWELLS if is_least else _PASSES
    dwells = all((np.abs(one - begin) <= 1.0).mean() > most for one in pulses if one.size)
    off = abs(begin - pwm.neutral_us) > _AT * pwm.half_range_us
    if near.mean() > _PASSES or not (dwells and off and (is_least or leaves)):
        return guessed
    unclear = (
        f"it begins and dwells at {begin:g} us, not at {pwm.neutral_us:g} us: either "
        f"rest is {pwm.neutral_us:g} us and all thrusters push there, or rest is {begin:g} us; "
        f"pool: pwm_range: {{neutral_us: {begin:g}, half_range_us: ...}}"
    )
    return replace(guessed, unclear=unclear)


def doubt_of_codes(raw: FloatArray, code_max: int) -> str:
    """Doubt codes that nobody stated: -1, 0 and 1 alone; fractions within 100 of many more."""
    values = raw[np.isfinite(raw)]
    largest = float(np.abs(values).max(initial=0.0))
    if largest == 1.0:
        return (
            "they are -1, 0 and 1 alone and were taken for codes: next to no thrust. They look "
            "like ratios, of thrusters that are only switched; state unit: ratio (or unit: code)"
        )
    whole, levels = bool((values % 1.0 == 0.0).all()), np.unique(values)
    full = next((one for one in _FULL_SCALES if one == largest < code_max), 0)
    at_full = np.abs(values) == largest
    if full and levels.size >= _MANY and at_full.sum() >= _OFTEN:
        return (
            f"they reach {full} again and again and never more, of codes to {code_max}: they may "
            f"be {'per cent' if full == _PERCENT else f'steps of {full}'}, and are taken for codes"
        )
    codes = levels * code_max / _PERCENT
    of_codes = levels.size >= _MANY and np.abs(codes - np.rint(codes)).max() < _ROUNDED
    if whole or largest > _PERCENT or not (of_codes or code_max >= 2.0 * _PERCENT):
        return ""
    return (
        f"they have fractions and stay within 100, of codes to {code_max}: they may be per cent, "
        "and are taken for codes"
    )
