"""Numbers as text: as many digits as the uncertainty carries, a true minus sign.

What is None is not known: a dash.
"""

import math
import string
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pipeline.language import as_it_is

MINUS, NOT_KNOWN = "\N{MINUS SIGN}", "–"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def fixed(value: float | None, decimals: int) -> str:
    """Write with a fixed number of decimals; negative zero is zero.

    >>> fixed(-1.25, 1), fixed(-0.001, 1), fixed(None, 1)
    ('−1.2', '0.0', '–')
    """
    if value is None:
        return NOT_KNOWN
    text = f"{value:.{decimals}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return text.replace("-", MINUS)


def signed(value: float | None, decimals: int) -> str:
    """Write a difference: with its sign, but zero without.

    >>> signed(0.31, 1), signed(-0.31, 1), signed(0.01, 1)
    ('+0.3', '−0.3', '0.0')
    """
    text = fixed(value, decimals)
    return f"+{text}" if value is not None and float(text.replace(MINUS, "-")) > 0 else text


def general(value: float | None, figures: int = 3) -> str:
    """Write to significant figures, with a power of ten where the decimals would be long.

    >>> general(0.139), general(8.82e-4), general(1692.4, 4), general(12345678.0), general(0.0)
    ('0.139', '8.82·10⁻⁴', '1692', '1.23·10⁷', '0')
    """
    if value is None:
        return NOT_KNOWN
    if value == 0.0 or not math.isfinite(value):
        return "0" if value == 0.0 else str(value)
    exponent = math.floor(math.log10(abs(value)) + 1e-12)
    if -3 <= exponent < 6:
        return fixed(value, max(figures - 1 - exponent, 0))
    return _scaled(value, exponent, figures - 1)


def as_printed(value: float) -> str:
    """Write a number somebody printed with the digits that it has, no more.

    >>> as_printed(0.254), as_printed(8.82e-4), as_printed(-4.0), as_printed(12.1e-4)
    ('0.254', '8.82·10⁻⁴', '−4', '1.21·10⁻³')
    """
    text = f"{value:.9g}"
    if "e" not in text and (value == 0.0 or abs(value) >= 0.01):
        return text.replace("-", MINUS)
    mantissa, _, exponent = f"{value:.8e}".partition("e")
    mantissa = mantissa.rstrip("0").rstrip(".")
    return f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPT)}".replace("-", MINUS)


def with_interval(value: float, interval: tuple[float, float]) -> tuple[str, str]:
    """Write an estimate and its interval to two figures of the half-width.

    >>> with_interval(0.138912, (0.13704, 0.14078))
    ('0.1389', '0.1370 to 0.1408')
    >>> with_interval(8.8213e-4, (8.61e-4, 9.03e-4))
    ('8.82·10⁻⁴', '8.61·10⁻⁴ to 9.03·10⁻⁴')
    """
    low, high = interval
    half_width = (high - low) / 2
    largest = max(abs(value), abs(low), abs(high))
    if half_width <= 0 or largest == 0 or not math.isfinite(half_width):
        return general(value, 4), f"{general(low, 4)} to {general(high, 4)}"
    last = math.floor(math.log10(half_width) + 1e-12) - 1
    scale = abs(value) if abs(value) > half_width else largest
    exponent = math.floor(math.log10(scale) + 1e-12)
    if exponent < -2 or last > 3:
        decimals = max(exponent - last, 0)
        texts = [_scaled(number, exponent, decimals) for number in (value, low, high)]
    else:
        texts = [fixed(number, max(-last, 0)) for number in (value, low, high)]
    return texts[0], f"{texts[1]} to {texts[2]}"


def speed(speed_mps: float) -> str:
    """Write a speed as the tables name it.

    >>> speed(0.0), speed(0.5), speed(1.25)
    ('0', '0.5', '1.25')
    """
    return fixed(speed_mps, 3).rstrip("0").rstrip(".")


def code(value: float) -> str:
    """Write a control code; whole numbers without decimals.

    >>> code(-127.0), code(63.5)
    ('−127', '63.5')
    """
    return fixed(value, 0 if float(value).is_integer() else 1)


def percent(fraction: float) -> str:
    """Write a fraction in percent to two significant figures.

    >>> percent(0.0123), percent(0.412), percent(0.0)
    ('1.2 %', '41 %', '0 %')
    """
    return f"{general(100 * fraction, 2)} %"


def use_of_limit(use: float | None) -> str:
    """Write a load over what is there to carry it; far beyond it the figure itself says nothing.

    >>> use_of_limit(0.412), use_of_limit(1000.0), use_of_limit(None)
    ('41 %', '> 1000 %', '–')
    """
    if use is None:
        return NOT_KNOWN
    # a thruster that gives nothing has a use without bound, for which a large number stands
    return percent(use) if use <= 10.0 else f"> {percent(10.0)}"


def unit_text(unit: str) -> str:
    """Set the powers of a unit as a person does.

    >>> unit_text("kg m^2"), unit_text("m^3")
    ('kg m²', 'm³')
    """
    return unit.replace("^2", "²").replace("^3", "³")


def plural(count: int, singular: str, plural_form: str = "") -> str:
    """Count things.

    >>> plural(1, "point"), plural(3, "point"), plural(2, "branch", "branches")
    ('1 point', '3 points', '2 branches')
    """
    return f"{count} {singular if count == 1 else plural_form or singular + 's'}"


def _scaled(value: float, exponent: int, decimals: int) -> str:
    power = str(exponent).translate(_SUPERSCRIPT)
    return f"{fixed(value / 10.0**exponent, decimals)}·10{power}"


class Pattern(string.Formatter):
    """Texts with values of a thing in them: ``{length_m:1000*.1f} mm``; a dash where one is None.

    Written as a number with decimals (``.1f``, ``+.1f`` with a sign) or figures (``.3g``), or in a
    way of its own (`WAYS`).

    >>> Pattern().format("{0} at {1:1000*+.1f} mm, {1:percent}", ("a", 0.012))
    'a at +12.0 mm, 1.2 %'
    """

    WAYS: Mapping[str, Callable[[Any], str]] = {
        "code": code, "speed": speed, "percent": percent, "use": use_of_limit, "name": as_it_is,
        "words": lambda name: str(name).replace("_", " "), "unit": unit_text,
        "yes": lambda one: "yes" if one else "no",
    }  # fmt: skip

    def get_value(self, key: int | str, args: Sequence[Any], kwargs: Mapping[str, Any]) -> Any:  # noqa: ANN401, ARG002, D102
        thing = args[0]
        by_key = isinstance(key, int) or isinstance(thing, Mapping)
        return thing[key] if by_key else getattr(thing, str(key))

    def format_field(self, value: Any, format_spec: str) -> str:  # noqa: ANN401, D102
        if value is None or format_spec in {"", *self.WAYS}:
            return NOT_KNOWN if value is None else self.WAYS.get(format_spec, str)(value)
        factor, _, form = format_spec.rpartition("*")
        write = general if form.endswith("g") else signed if form.startswith("+") else fixed
        return write(float(factor or 1) * value, int(form.strip("+.fg")))
