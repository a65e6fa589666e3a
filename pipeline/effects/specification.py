"""An effect with its values, and the text that says it: ``ID:key=value[,key=value][@thruster]``."""

import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from pipeline.effects.effect import Effect, Parameter
from pipeline.errors import InputError, Place

#: Verdicts of a diagnosis that are not effects, and what each says.
VERDICTS: Mapping[str, str] = {
    "none": "the nominal model predicts as well as on a healthy vehicle: no gap to explain",
    "unknown": "there is a gap, and no effect of the library (nor a pair) explains it",
}


@dataclass(frozen=True)
class EffectSpec:
    """An effect switched on.

    Attributes
    ----------
    id : str
        The effect.
    values : mapping of str to float
        Parameter values in their units; a parameter that is not named keeps its neutral value.
    target : str or None
        Name of the thruster, for effects of one thruster.

    Examples
    --------
    >>> str(EffectSpec("thruster_degraded", {"thrust_fraction": 0.6}, "upper"))
    'thruster_degraded:thrust_fraction=0.6@upper'
    """

    id: str
    values: Mapping[str, float] = field(hash=False)
    target: str | None = None

    def __str__(self) -> str:
        """Return the text from which `parse` gives the same back."""
        values = ",".join(f"{name}={float(value)!r}" for name, value in self.values.items())
        return f"{self.id}:{values}" + (f"@{self.target}" if self.target is not None else "")


def parse(
    text: str, library: Mapping[str, Effect], thruster_names: Sequence[str] | None = None
) -> EffectSpec:
    """Read the form of the command line.

    Parameters
    ----------
    text : str
        E.g. ``"current:north_mps=0.2,east_mps=-0.1"`` or
        ``"thruster_degraded:thrust_fraction=0.6@upper"``.
    library : mapping of str to Effect
        The effects that there are.
    thruster_names : sequence of str, optional
        The vehicle's thrusters; without it the name after ``@`` is taken as it is.

    Returns
    -------
    EffectSpec

    Raises
    ------
    InputError
        Naming what is wrong, what is expected with its unit, and the nearest valid name.
    """
    head, colon, rest = text.partition(":")
    # "ID@thruster" without values still has its thruster taken off
    left, at, name = (rest if colon else head).partition("@")
    effect_id = (head if colon else left).strip()
    effect = _look_up(effect_id, library, text)
    spec = EffectSpec(
        effect_id,
        _values(left if colon else "", effect, text),
        name.strip() if at else None,
    )
    check(spec, library, thruster_names, text)
    return spec


def check(
    spec: EffectSpec,
    library: Mapping[str, Effect],
    thruster_names: Sequence[str] | None = None,
    text: str | None = None,
) -> None:
    """Raise `InputError` unless id, keys, values and thruster are valid; see `parse`.

    `text` is what the user wrote, to be repeated in the message.
    """
    said = spec if text is None else text
    effect = _look_up(spec.id, library, said)
    known = {parameter.name: parameter for parameter in effect.parameters}
    for name, value in spec.values.items():
        if name not in known:
            raise _unknown_key(name, effect, said)
        _check_value(value, known[name], said)
    _check_target(spec.target, effect, said, thruster_names)


def _place(said: EffectSpec | str) -> Place:
    """Name the place of a fault, which is made where there is one: a diagnosis asks often."""
    return Place(f'effect "{said}"')


def _look_up(effect_id: str, library: Mapping[str, Effect], said: EffectSpec | str) -> Effect:
    if effect_id in library:
        return library[effect_id]
    if effect_id in VERDICTS:
        raise InputError.at(
            _place(said),
            f'"{effect_id}" is a verdict of the diagnosis, not an effect that can be switched on.',
            expected="one of the ids that `rig2sea effects` lists.",
        )
    what = f'there is no effect "{effect_id}".' if effect_id else "the id of the effect is missing."
    raise InputError.at(
        _place(said),
        what,
        expected="an id that `rig2sea effects` lists, in the form ID:key=value.",
        remedy=_nearest(effect_id, library),
    )


def _values(text: str, effect: Effect, said: EffectSpec | str) -> dict[str, float]:
    if not text.strip():
        raise InputError.at(
            _place(said),
            "no value is given.",
            expected=f"{effect.id}:key=value with {_described(effect.parameters)}.",
        )
    values: dict[str, float] = {}
    for part in text.split(","):
        name, equals, number = (piece.strip() for piece in part.partition("="))
        if not equals:
            raise InputError.at(
                _place(said),
                f'"{part.strip()}" is not of the form key=value.',
                expected=f"{_described(effect.parameters)}.",
                remedy="Write a decimal fraction with a point; a comma begins the next key.",
            )
        parameter = next((p for p in effect.parameters if p.name == name), None)
        if parameter is None:
            raise _unknown_key(name, effect, said)
        if name in values:
            raise InputError.at(
                _place(said), f"{name} is given twice.", remedy="Leave one of them out."
            )
        try:
            values[name] = float(number)
        except ValueError:
            raise InputError.at(
                _place(said),
                f'{name}: "{number}" is not a number.',
                expected=f"a plain number{_in_unit(parameter)}, without the unit.",
            ) from None
    return values


def _unknown_key(name: str, effect: Effect, said: EffectSpec | str) -> InputError:
    return InputError.at(
        _place(said),
        f'{effect.id} has no parameter "{name}".',
        expected=f"{_described(effect.parameters)}.",
        remedy=_nearest(name, [parameter.name for parameter in effect.parameters]),
    )


def _check_value(value: float, parameter: Parameter, said: EffectSpec | str) -> None:
    low, high = parameter.possible
    if math.isfinite(value) and low <= value <= high:
        return
    limits = {
        (True, True): f"a number from {low:g} to {high:g}",
        (True, False): f"a number not below {low:g}",
        (False, True): f"a number not above {high:g}",
        (False, False): "a finite number",
    }[math.isfinite(low), math.isfinite(high)]
    raise InputError.at(
        _place(said),
        f"{parameter.name}={value:g} is not possible.",
        expected=f"{limits}{_in_unit(parameter)}; {parameter.neutral:g} is neutral.",
    )


def _check_target(
    target: str | None, effect: Effect, said: EffectSpec | str, thruster_names: Sequence[str] | None
) -> None:
    names = f"one of {', '.join(thruster_names)}" if thruster_names else "the name of a thruster"
    if effect.scope == "vehicle":
        if target is not None:
            raise InputError.at(
                _place(said),
                f"{effect.id} acts on the whole vehicle.",
                remedy=f'Leave "@{target}" out.',
            )
    elif not target:
        raise InputError.at(
            _place(said),
            f"{effect.id} needs to know which thruster.",
            expected=f'"@" and {names} at the end.',
        )
    elif thruster_names is not None and target not in thruster_names:
        raise InputError.at(
            _place(said),
            f'the vehicle has no thruster "{target}".',
            expected=f"{names}." if thruster_names else "a vehicle with thrusters.",
            remedy=_nearest(target, thruster_names),
        )


def _in_unit(parameter: Parameter) -> str:
    return "" if parameter.unit == "1" else f" in {parameter.unit}"


def _described(parameters: Iterable[Parameter]) -> str:
    return ", ".join(p.name if p.unit == "1" else f"{p.name} [{p.unit}]" for p in parameters)


def _nearest(name: str, known: Iterable[str]) -> str:
    names = list(known)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    if not near and name:
        # an abbreviation is far off by letters: "mass" for "mass_kg", "voltage" for "voltage_sag"
        near = [other for other in names if other.startswith(name) or name.startswith(other)]
    return f'Did you mean "{near[0]}"?' if near else ""
