"""How pages name channels, regimes, effects and probabilities, and their units."""

import re
from collections.abc import Iterable

import numpy as np

from pipeline.effects.library import effects
from pipeline.language import as_it_is, translate
from pipeline.records.diagnosis import (
    BenchDiagnosisRecord,
    DiagnosisRecord,
    ParameterEstimate,
    Verdict,
)
from pipeline.report.numbers import fixed, general, percent, unit_text, with_interval

REGRESSORS = {
    "speed_mps": "speed",
    "surge_mps": "surge velocity",
    "turn_rate_radps": "turn rate",
    "depth_m": "depth",
    "command_level": "command level",
    "command_sign": "command sign",
    "voltage_v": "voltage",
    "wall_distance_m": "distance to wall",
    "time_s": "time",
    "code": "code",
    "|code|": "size of the code",
}
#: An effect in words where its identifier alone may be read as something else.
_WORDS = {"current": "water current", "none": "nothing wrong", "unknown": "a cause not known"}
#: Where a verdict's sentence has identifiers: not every word that is spelt like one is one.
_ANSWERS = re.compile(r"\b[a-z_]+(?= \(| alone has )")
_LISTED = re.compile(r"(?<= cannot tell it from ).*|(?<= readings speak for ).*?(?=, but )")
_NAMES = re.compile(r"[a-z_]+")
_NO_EFFECT = {
    "none": "the vehicle moves as its file says",
    "unknown": "something that no known cause explains",
}


def said(text: str) -> str:
    """Say a part of a text in the reader's language, whatever stands around it.

    >>> said("thrust fraction")
    'thrust fraction'
    """
    return as_it_is(translate(text))


def of_bench(record: DiagnosisRecord) -> bool:
    """Tell whether a mooring table was diagnosed: its curves are over the control code."""
    return isinstance(record, BenchDiagnosisRecord)


def what_it_is(answer: str) -> str:
    """Say in words what an answer is; pairs are ``a+b``.

    >>> what_it_is("dvl_scale+dead_zone")
    'the DVL reads too fast or too slow; small codes give no thrust'
    """
    library = effects()
    parts = [
        _NO_EFFECT.get(name) or (library[name].title if name in library else "")
        for name in answer.split("+")
    ]
    return "; ".join(said(part) for part in parts if part)


def in_words(effect: str) -> str:
    """Name an effect in words.

    >>> in_words("residual_buoyancy"), in_words("current")
    ('residual buoyancy', 'water current')
    """
    return _WORDS.get(effect, effect.replace("_", " "))


def identifiers(names: Iterable[str]) -> str:
    """List effects by their identifiers, or runs by their names: the same in every language.

    >>> identifiers(["current", "tether"])
    'current and tether'
    """
    return listed([as_it_is(name) for name in names])


def verdict_sentence(verdict: Verdict) -> str:
    """Return the sentence of a verdict, with the identifiers in it the same in every language."""

    def marked(found: re.Match[str]) -> str:
        name = found[0]
        return as_it_is(name) if name in effects() or name in _NO_EFFECT else name

    said = _ANSWERS.sub(marked, verdict.sentence)
    return _LISTED.sub(lambda found: _NAMES.sub(marked, found[0]), said)


def regime_name(regressor: str, unit: str, ends: tuple[float, float]) -> str:
    """Name a range of a regressor.

    >>> regime_name("depth_m", "m", (1.2, 3.0)), regime_name("command_level", "1", (0.709, 0.748))
    ('depth 1.2 to 3.0 m', 'command level 0.709 to 0.748')
    """
    name = REGRESSORS.get(regressor, regressor.replace("_", " "))
    shown, factor = shown_unit(unit)
    low, high = (factor * end for end in ends)
    # as many decimals as the width of the range needs
    width = high - low
    decimals = int(np.clip(1 - np.floor(np.log10(width)), 0, 6)) if width > 0 else 3
    text = f"{name} {fixed(low, decimals)} to {fixed(high, decimals)}"
    return text + ("" if unit in {"1", "code"} else f" {shown}")


def probability_text(probability: float) -> str:
    r"""Write a probability; never as certain, and none as impossible.

    >>> probability_text(0.974), probability_text(0.9999), probability_text(1e-5)
    ('97 %', '>\xa099.9 %', '<\xa00.1 %')
    """
    if probability > 0.999:
        return ">\N{NO-BREAK SPACE}99.9 %"
    if probability < 0.001:
        return "<\N{NO-BREAK SPACE}0.1 %"
    return f"{100 * probability:.1f} %" if probability > 0.99 else percent(probability)


def closed_text(share: float) -> str:
    r"""Write the share of a gap that is closed; what falls below the healthy floor counts as all.

    >>> closed_text(0.43), closed_text(1.19)
    ('43 %', 'all')
    """
    return "all" if share >= 0.995 else percent(share)


def closed_interval(ci95: tuple[float, float] | None) -> str:
    """Write the interval of that share, where it says more than the share itself.

    >>> closed_interval((0.8, 1.1)), closed_interval((1.02, 1.3)), closed_interval(None)
    (' (95 % interval 80 % to all)', '', '')
    """
    if ci95 is None or closed_text(ci95[0]) == "all":
        return ""
    return f" (95 % interval {closed_text(ci95[0])} to {closed_text(ci95[1])})"


def beside(verdict: Verdict, answer: str) -> bool:
    """Whether an answer of the ranking is one that the data cannot tell from the verdict.

    Of two effects one may be that which the verdict names as well.
    """
    names, ambiguous = set(answer.split("+")), set(verdict.ambiguous_with)
    return bool(names & ambiguous) and names <= ambiguous | set(verdict.effects)


def listed(names: tuple[str, ...] | list[str]) -> str:
    """Join names as a person does.

    >>> listed(["a", "b", "c"])
    'a, b and c'
    """
    own = list(names)
    return " and ".join([", ".join(own[:-1]), own[-1]]) if len(own) > 1 else "".join(own)


def capital(text: str) -> str:
    """Begin with a capital, as a sentence does."""
    return text[:1].upper() + text[1:]


def ratio_text(ratio: float) -> str:
    """Write a ratio to two figures, whole numbers from 10.

    >>> ratio_text(1.04), ratio_text(31.7), ratio_text(1234.0)
    ('1.0', '32', '1200')
    """
    return f"{ratio:.1f}" if ratio < 9.95 else general(float(f"{ratio:.2g}"), 4).partition(".")[0]


def parameter_words(name: str, one: ParameterEstimate) -> tuple[str, str]:
    """Say a value with its name and unit, and its interval; of a pair names begin with the effect.

    >>> one = ParameterEstimate(value=4.12, unit="N", ci95=(3.81, 4.43))
    >>> parameter_words("residual_buoyancy.force_n", one)
    ('force 4.12 N', '3.81 to 4.43')
    """
    value, ends = with_interval(one.value, one.ci95)
    unit = "" if one.unit == "1" else f" {unit_text(one.unit)}"
    key = name.rpartition(".")[2]
    words = key.rsplit("_", 1)[0] if unit and "_" in key else key
    return f"{said(words.replace('_', ' '))} {value}{unit}", ends


#: Channel -> what it is.
CHANNELS = {
    "u": "surge velocity u",
    "v": "sway velocity v",
    "w": "heave velocity w",
    "p": "roll rate p",
    "q": "pitch rate q",
    "r": "yaw rate r",
    "phi": "roll φ",
    "theta": "pitch θ",
    "psi": "yaw ψ",
    "z": "depth z",
    "x": "north x",
    "y": "east y",
    "thrust": "thrust",
    "shaft_speed": "shaft speed",
    "current": "current",
    "voltage": "supply voltage",
    "fx": "acceleration forward",
    "fy": "acceleration sideways",
    "fz": "acceleration down",
}
#: Short, for the head of a column.
SYMBOLS = {"phi": "φ", "theta": "θ", "psi": "ψ", "shaft_speed": "rpm"}
#: Units that a person reads, and the factor to them.
SHOWN_UNITS = {"rad": ("deg", 180 / np.pi), "rad/s": ("deg/s", 180 / np.pi), "m/s^2": ("m/s²", 1.0)}


def channel_name(channel: str) -> str:
    """Return what a channel is called.

    >>> channel_name("w"), channel_name("other_thing")
    ('heave velocity w', 'other thing')
    """
    return CHANNELS.get(channel, channel.replace("_", " "))


def short_name(channel: str) -> str:
    """Name a channel beside a panel, where a long name would not stand.

    >>> short_name("phi"), short_name("u")
    ('roll φ', 'u')
    """
    named = {"phi", "theta", "psi", "z"}
    return CHANNELS[channel] if channel in named else channel.replace("_", " ")


def in_order(names: Iterable[str]) -> list[str]:
    """Sort channels as the equations of motion list them, others after them.

    >>> in_order(["psi", "zeta", "w", "u"])
    ['u', 'w', 'psi', 'zeta']
    """
    places = {name: place for place, name in enumerate(CHANNELS)}
    return sorted(names, key=lambda name: (places.get(name, len(places)), name))


def shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit that figures and tables use, and the factor to it.

    >>> shown_unit("m/s")
    ('m/s', 1.0)
    """
    return SHOWN_UNITS.get(unit, (unit, 1.0))
