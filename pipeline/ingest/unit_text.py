"""Unit texts of raw files, English and Russian, and what they are worth.

A bench's kg, g, lb and oz in a force or a torque mean kilogram-force and so on. Texts are compared
without case; blanks, dots and hyphens part the factors and may be missing: ``N.mm``, ``N mm`` and
``Nmm`` are one unit. Only where leaving them out makes two units look alike ("кгсм": "кгс·м" or
"кг·см"?) the text is refused.
"""

import difflib
import functools
import re
import unicodedata
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

#: quantity -> (unit of the records as pint writes it, {unit as pint writes it: texts of it}).
_UNITS: Mapping[str, tuple[str, Mapping[str, str]]] = MappingProxyType({
    "shaft_speed": ("revolution / minute", {
        # pint counts "1/min" in radians; on a bench it is a revolution, so it is never left to pint
        "revolution / minute": "rpm | r/min | rev/min | revs/min | rev.min-1"
        " | revolutions per minute | revolutions/minute | U/min | tr/min | upm | cpm"
        " | 1/min | min-1 | min^-1 | /min"
        " | об/мин | об/м | об.мин-1 | обмин | оборотов в минуту | обороты в минуту | об в мин"
        " | 1/мин | мин-1 | мин^-1",
        "revolution / second": "rps | r/s | rev/s | revs/s | rev/sec | revolutions per second | 1/s"
        " | s-1 | s^-1 | hz | об/с | об/сек | об.с-1 | оборотов в секунду | обороты в секунду"
        " | 1/с | с-1 | с^-1 | гц",
        "kilorevolution / minute": "krpm | тыс.об/мин | тыс.об.мин-1",
        "radian / second": "rad/s | rad/sec | rad.s | rad.s-1 | rad.s^-1 | radians per second"
        " | рад/с | рад/сек | рад.с | рад.с-1",
        "degree / second": "deg/s | °/s | град/с | °/с",
    }),
    "torque": ("newton * meter", {
        "newton * meter": "N m | newton meter | newton metre | newton meters | newton metres"
        " | H m | Н м | Н на м | ньютон метр | ньютон-метры",
        "newton * centimeter": "N cm | H cm | Н см",
        "decinewton * meter": "dN m | дН м",
        "newton * decimeter": "N dm | Н дм",
        "centinewton * meter": "cN m | сН м",
        "decanewton * meter": "daN m | даН м",
        "dyne * centimeter": "dyn cm | дин см",
        "newton * millimeter": "N mm | mN m | H mm | Н мм | мН м",
        "micronewton * meter": "uN m | µN m | мкН м",
        "kilonewton * meter": "kN m | кН м",
        "kilogram_force * meter": "kg m | kgf m | kgm f | кг м | кгс м | кГ м | кгс на м",
        "kilogram_force * centimeter": "kg cm | kgf cm | kp cm | кг см | кгс см | кГ см",
        "kilogram_force * millimeter": "kg mm | kgf mm | кг мм | кгс мм",
        "gram_force * meter": "gf m | g m | гс м | г м",
        "gram_force * centimeter": "g cm | gf cm | gr cm | г см | гс см | Г см",
        "gram_force * millimeter": "g mm | gf mm | г мм | гс мм",
        "force_ounce * inch": "oz in | ozf in | oz inch | ounce inch | ounce inches | in oz"
        " | in ozf | oz f in | унция дюйм | унц дюйм",
        "force_ounce * foot": "oz ft | ozf ft | ft oz | oz f ft | унция фут",
        "force_pound * inch": "lb in | lbf in | lbs in | pound inch | pound inches | in lb | in lbf"
        " | in lbs | inch pound | inch pounds | фунт дюйм",
        "force_pound * foot": "lb ft | lbf ft | lbs ft | pound foot | pound feet | ft lb | ft lbf"
        " | ft lbs | foot pound | foot pounds | фунт фут",
    }),
    "force": ("newton", {
        "newton": "N | newton | newtons | H | Н | ньютон | ньютоны | kg m/s2 | kg m/s^2 | кг м/с2",
        "kilonewton": "kN | кН",
        "decanewton": "daN | даН",
        "decinewton": "dN | дН",
        "centinewton": "cN | сН",
        "millinewton": "mN | мН",
        "kilogram_force": "kgf | kg | kg f | kg force | kilogram force | kilograms | kp | кгс | кг"
        " | кГ | кг сила | кг(с) | kg(f)",
        "gram_force": "gf | g | g f | gr | gram | gram force | grams | гс | г | Г | грамм",
        "metric_ton * standard_gravity": "tf | тс",
        "force_pound": "lbf | lb | lbs | lb f | pound | pounds | pound force | фунт",
        "force_ounce": "ozf | oz | oz f | ounce | ounces | унция",
    }),
    "current": ("ampere", {
        "ampere": "A | amp | amps | ampere | amperes | А | ампер",
        "milliampere": "mA | мА",
        "microampere": "uA | µA | мкА",
    }),
    "voltage": ("volt", {
        "volt": "V | volt | volts | VDC | V DC | В | вольт",
        "millivolt": "mV | мВ",
        "kilovolt": "kV | кВ",
    }),
    "power": ("watt", {
        "watt": "W | watt | watts | Вт | ватт",
        "milliwatt": "mW | мВт",
        "kilowatt": "kW | кВт",
        "force_pound * foot / second": "ft lbf/s | ft lb/s",
        "horsepower": "hp",
        "metric_horsepower": "PS | л.с.",
    }),
    "time": ("second", {
        # a clock time is read as seconds by itself, whatever is said of its digits
        "second": "s | sec | secs | second | seconds | с | сек | секунда | секунды"
        " | hh:mm:ss | h:mm:ss | hh:mm | чч:мм:сс | ч:мм:сс | чч:мм",
        "millisecond": "ms | msec | мс",
        "microsecond": "us | µs | usec | мкс",
        "minute": "min | minute | minutes | мин",
        "hour": "h | hour | hours | ч | час",
    }),
    "pulse_width": ("microsecond", {
        "microsecond": "us | µs | usec | microsecond | microseconds | мкс",
        "millisecond": "ms | msec | мс",
        "second": "s | sec | с | сек",
    }),
    "speed": ("meter / second", {
        "meter / second": "m/s | m/sec | mps | m.s-1 | m.s^-1 | м/с | м/сек",
        "centimeter / second": "cm/s | см/с",
        "millimeter / second": "mm/s | мм/с",
        "kilometer / hour": "km/h | kph | км/ч",
        "knot": "kn | kt | kts | knot | knots | уз | узел | узлы",
        "foot / second": "ft/s | fps",
        "inch / second": "in/s",
    }),
    "ratio": ("1", {
        "1": "1 | - | — | dimensionless | none | б/р | безразм | безразмерная | ед",
        "percent": "% | percent | pct | проц | процент",
    }),
    "temperature": ("kelvin", {
        "kelvin": "K | °C | deg C | degC | C | град C | град С | °С",
    }),
    "efficiency": ("gram_force / watt", {
        "gram_force / watt": "g/W | gf/W | г/Вт | гс/Вт",
        "newton / watt": "N/W | Н/Вт",
        "force_pound / watt": "lb/W | lbf/W",
    }),
})  # fmt: skip

#: quantity -> a unit as a header may state it, for messages.
EXAMPLES: Mapping[str, str] = MappingProxyType({
    "shaft_speed": "rpm",
    "torque": "N m",
    "force": "N",
    "current": "A",
    "voltage": "V",
    "power": "W",
    "time": "s",
    "pulse_width": "us",
    "speed": "m/s",
    "ratio": "%",
    "temperature": "deg C",
    "efficiency": "g/W",
})  # fmt: skip

#: Latin letters that look like Cyrillic ones, after case folding: "H·м" is typed with a Latin H.
_SAME_SHAPE = str.maketrans("aeopcxyhkmtb", "аеорсхункмтв")
_CYRILLIC = re.compile("[а-яё]")
_PARTING = re.compile(r"[\s.,·•∙⋅‧・*×⋆^_\u00ad\u2010-\u2015\u2212\-]+")
_BRACKETS = re.compile(r"^[\[({<]\s*(.*?)\s*[\])}>]$", re.DOTALL)


class UnitTextError(ValueError):
    """A unit text is not known, or is not a unit of the wanted quantity; the text says which."""


def normalise_unit(text: str) -> str:
    """Return the form in which unit texts are compared: factors parted by ``*``.

    >>> normalise_unit("[N·mm]"), normalise_unit("n. mm"), normalise_unit("H·м") == "н*м"
    ('n*mm', 'n*mm', True)
    """
    text = text.strip()
    inner = _BRACKETS.match(text)
    if inner is not None:
        text = inner[1]
    text = unicodedata.normalize("NFKC", text.replace("⁻", "-").replace("°", "deg")).casefold()
    plain = _PARTING.sub("*", text).strip("*").replace("*/", "/").replace("/*", "/")
    if not plain and text.strip():
        return "-"
    return fold_lookalikes(plain)


def fold_lookalikes(text: str) -> str:
    """Return a lower-case text with Latin letters turned Cyrillic where it has Cyrillic ones.

    >>> fold_lookalikes("mомент") == "момент", fold_lookalikes("torque")
    (True, 'torque')
    """
    return text.translate(_SAME_SHAPE) if _CYRILLIC.search(text) else text


@functools.cache
def _texts() -> Mapping[str, Mapping[str, str | None]]:
    """Return quantity -> text -> unit as pint writes it; None where the text could be two units."""
    table: dict[str, dict[str, str | None]] = {}
    for quantity, (_, units) in _UNITS.items():
        parted: dict[str, str | None] = {}
        joined: dict[str, str | None] = {}
        for unit, texts in units.items():
            for text in texts.split(" | "):
                key = normalise_unit(text)
                if parted.setdefault(key, unit) != unit:
                    raise AssertionError(f"{text!r} is both {parted[key]} and {unit}")
                compact = key.replace("*", "")
                if joined.setdefault(compact, unit) != unit:
                    joined[compact] = None
        table[quantity] = joined | parted
    return table


def _find(text: str, quantity: str) -> str | None:
    """Return the unit as pint writes it, None where the text is none of this quantity.

    Raises `UnitTextError` where it could be two.
    """
    known = _texts()[quantity]
    key = normalise_unit(text)
    for form in (key, key.replace("*", "")):
        if form in known:
            unit = known[form]
            if unit is None:
                raise UnitTextError(
                    f'"{text.strip()}" could be two units of {quantity}: write it with a blank or '
                    "a dot between the factors"
                )
            return unit
    return None


def is_same_unit(text: str, other: str) -> bool:
    """Tell whether two texts mean one unit: spelled alike, or two names of it.

    >>> is_same_unit("N.mm", "Nmm"), is_same_unit("В", "V"), is_same_unit("N m", "N mm")
    (True, True, False)
    """
    first, second = normalise_unit(text), normalise_unit(other)
    if first == second or first.replace("*", "") == second.replace("*", ""):
        return True
    for quantity in quantities_of(text) & quantities_of(other):
        try:
            if _find(text, quantity) == _find(other, quantity):
                return True
        except UnitTextError:
            continue
    return False


@functools.cache
def _registry() -> Any:  # noqa: ANN401  pint's registry is built at run time and has no useful type
    import pint  # 0.4 s: only when a file with units is read

    return pint.UnitRegistry()


@functools.cache
def _worth(unit: str, target: str) -> float:
    return float(_registry().Quantity(1.0, unit).to(target).magnitude)


def quantities_of(text: str) -> frozenset[str]:
    """Return the quantities that a text may be a unit of.

    >>> sorted(quantities_of("oz-in")), sorted(quantities_of("мс")), sorted(quantities_of("code"))
    (['torque'], ['pulse_width', 'time'], [])
    """
    key = normalise_unit(text)
    forms = {key, key.replace("*", "")}
    return frozenset(name for name, known in _texts().items() if not forms.isdisjoint(known))


def known_units(quantity: str) -> tuple[str, ...]:
    """Return one text for each unit of a quantity, as offered in messages."""
    return tuple(texts.split(" | ")[0] for texts in _UNITS[quantity][1].values())


def record_unit(quantity: str) -> str:
    """Return the unit of the records, as a text.

    >>> record_unit("torque"), record_unit("shaft_speed")
    ('N m', 'rpm')
    """
    target, units = _UNITS[quantity]
    return units[target].split(" | ")[0]


def unit_worth(quantity: str, worth: float, tolerance: float = 0.02) -> str | None:
    """Return the unit that is worth about so much in the unit of the records, None if none is.

    >>> unit_worth("torque", 0.098), unit_worth("shaft_speed", 9.55), unit_worth("torque", 0.5)
    ('kg cm', 'rad/s', None)
    """
    target, units = _UNITS[quantity]
    for unit, texts in units.items():
        if abs(worth / _worth(unit, target) - 1.0) <= tolerance:
            return texts.split(" | ")[0]
    return None


def factor(unit_text: str, quantity: str) -> float:
    """Return what one unit is in the unit of the records (rpm, N m, N, A, V, W, s, us, m/s, 1).

    Parameters
    ----------
    unit_text : str
        Unit as written in the file, with or without brackets.
    quantity : str
        One of shaft_speed, torque, force, current, voltage, power, time, pulse_width, speed, ratio.

    Returns
    -------
    float
        Multiply by it.

    Raises
    ------
    UnitTextError
        The text is not a unit of that quantity.

    Examples
    --------
    >>> round(factor("oz-in", "torque"), 8), round(factor("кгс·см", "torque"), 7)
    (0.00706155, 0.0980665)
    >>> factor("1/min", "shaft_speed"), factor("мА", "current")
    (1.0, 0.001)
    """
    unit = _find(unit_text, quantity)
    if unit is not None:
        return _worth(unit, _UNITS[quantity][0])
    name = quantity.replace("_", " ")
    known = ", ".join(known_units(quantity))
    others = sorted(quantities_of(unit_text))
    if others:
        other = " or ".join(other.replace("_", " ") for other in others)
        raise UnitTextError(
            f'"{unit_text.strip()}" is a unit of {other}, not of {name}; known for {name}: {known}'
        )
    texts = [text for text, meaning in _texts()[quantity].items() if meaning is not None]
    close = difflib.get_close_matches(normalise_unit(unit_text), texts, n=1, cutoff=0.75)
    hint = ""
    nearest = _texts()[quantity][close[0]] if close else None
    if nearest is not None:
        hint = f' (did you mean "{_UNITS[quantity][1][nearest].split(" | ")[0]}"?)'
    raise UnitTextError(
        f'"{unit_text.strip()}" is not a known unit of {name}{hint}; known: {known}'
    )


def is_percent(unit: str) -> bool:
    """Tell whether a unit text is per cent, however it is written.

    >>> is_percent("%"), is_percent("проц"), is_percent("-"), is_percent("N m")
    (True, True, False, False)
    """
    try:
        return _find(unit, "ratio") == "percent"
    except UnitTextError:
        return False
