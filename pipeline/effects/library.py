"""The library of effects: what there is, what fits a vehicle, and switching effects on.

Every module of this package that defines ``EFFECT`` is in the library under the module's name: to
add an effect is to add a file (and its tests); no list is kept. The verdict ids ``none`` and
``unknown`` (see `specification.VERDICTS`) are answers of a diagnosis and have no file.
"""

import math
import pkgutil
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from importlib import import_module
from typing import Any

import pipeline.effects
from pipeline.effects import specification
from pipeline.effects.effect import Effect, EffectContext, Parameter
from pipeline.effects.specification import VERDICTS, EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import SLOTS
from pipeline.types import FloatArray

__all__ = [
    "VERDICTS",
    "EffectSpec",
    "apply_effects",
    "candidates",
    "effects",
    "parse_effect",
    "unstated",
    "why_not",
]


def module_names() -> tuple[str, ...]:
    """Return the dotted names of the package's modules, sorted.

    >>> "pipeline.effects.current" in module_names()
    True
    """
    package = pipeline.effects
    return tuple(
        sorted(f"{package.__name__}.{m.name}" for m in pkgutil.iter_modules(package.__path__))
    )


def effects() -> dict[str, Effect]:
    """Return every effect that can be an answer by its id, in alphabetical order.

    Raises
    ------
    ValueError
        When an effect's file is inconsistent: a fault of that file.

    Examples
    --------
    >>> effects()["current"].parameters[0].name
    'north_mps'
    """
    return {id_: effect for id_, effect in _collected().items() if not effect.unstated}


def unstated(context: EffectContext) -> dict[str, Effect]:
    """Return what may differ on any vehicle because no vehicle file states it, by id."""
    return {
        id_: effect.on(context)
        for id_, effect in _collected().items()
        if effect.unstated and _missing(effect, context) is None
    }


@cache
def _collected() -> dict[str, Effect]:
    found: dict[str, Effect] = {}
    for name in module_names():
        effect = getattr(import_module(name), "EFFECT", None)
        if effect is None:
            continue
        _check_effect(effect, name.rpartition(".")[2])
        found[effect.id] = effect
    return dict(sorted(found.items()))


def _check_effect(effect: Effect, module: str) -> None:
    if effect.id != module or effect.id in VERDICTS:
        raise ValueError(f'effects/{module}.py: the id "{effect.id}" must be the file\'s name')
    known = {slot.name for slot in SLOTS}
    unknown = set(effect.vector_slots) - known
    if unknown:
        raise ValueError(f"effects/{module}.py: no such slot: {', '.join(sorted(unknown))}")
    names = [parameter.name for parameter in effect.parameters]
    if not names or len(set(names)) != len(names):
        raise ValueError(f"effects/{module}.py: parameters must be there once each")


def candidates(context: EffectContext) -> dict[str, Effect]:
    """Return the effects that a vehicle can have, by id; the rest is in `why_not`.

    Neutral values and ordinary widths are those that the vehicle's file states.
    """
    return {
        id_: effect.on(context)
        for id_, effect in effects().items()
        if _missing(effect, context) is None
    }


def why_not(context: EffectContext) -> dict[str, str]:
    """Return for each effect that is no candidate the reason, by id."""
    reasons = {id_: _missing(effect, context) for id_, effect in effects().items()}
    return {id_: reason for id_, reason in reasons.items() if reason is not None}


def _missing(effect: Effect, context: EffectContext) -> str | None:
    of_thrusters = effect.of_thrusters or effect.scope == "thruster"
    if of_thrusters and not context.thruster_names:
        return "the vehicle has no thrusters"
    return effect.missing(context)


def apply_effects(
    vector: FloatArray, specs: Iterable[EffectSpec], context: EffectContext
) -> FloatArray:
    """Return a copy of a parameter vector with effects switched on.

    The effects are applied in alphabetical order whatever the order of `specs`, so the result is
    the same bit for bit. Where effects meet in one slot they add up (or multiply, for factors); the
    order matters in one case: the centre of mass is shifted before a payload is put on.

    Parameters
    ----------
    vector : ndarray, shape (LENGTH,)
        The parameter vector of the nominal model; not changed.
    specs : iterable of EffectSpec
        Effects with their values; parameters that are not named stay neutral.
    context : EffectContext
        Of the same vehicle.

    Returns
    -------
    ndarray, shape (LENGTH,)
        Bit for bit the nominal vector where every value is neutral.

    Raises
    ------
    InputError
        For an unknown id, parameter or thruster, or a value that is not possible.
    CannotComputeError
        When an effect is no candidate for this vehicle, or its values leave no valid vehicle.

    Examples
    --------
    >>> from pipeline.physics.parameters import neutral_vector, read
    >>> context = EffectContext(("port", "stbd"), True, True, False, False, 9.81)
    >>> weak = EffectSpec("thruster_degraded", {"thrust_fraction": 0.6}, "stbd")
    >>> read(apply_effects(neutral_vector(), [weak], context), "thrust_gain")[:3]
    array([1. , 0.6, 1. ])
    """
    changed = vector.copy()
    library = _collected()
    for spec in sorted(specs, key=_order):
        specification.check(spec, library, context.thruster_names)
        reason, neutral = _on_vehicle(spec.id, context)
        if reason is not None:
            raise CannotComputeError(f"{spec.id} cannot be switched on here: {reason}.")
        target = None if spec.target is None else context.thruster_names.index(spec.target)
        library[spec.id].apply(changed, {**neutral, **spec.values}, target, context)
    return changed


@lru_cache(maxsize=512)
def _on_vehicle(effect_id: str, context: EffectContext) -> tuple[str | None, Mapping[str, float]]:
    """Return why a vehicle cannot have an effect (None), and its neutral values there."""
    effect = _collected()[effect_id]
    return _missing(effect, context), effect.on(context).neutral_values()


def _order(spec: EffectSpec) -> tuple[str, str, tuple[tuple[str, float], ...]]:
    return spec.id, spec.target or "", tuple(sorted(spec.values.items()))


def parse_effect(text: str, thruster_names: Sequence[str] | None = None) -> EffectSpec:
    """Read an effect as written on the command line, ``ID:key=value[,key=value][@thruster]``.

    Parameters
    ----------
    text : str
        What the user wrote.
    thruster_names : sequence of str, optional
        The vehicle's thrusters, if they are known here; `apply_effects` checks them in any case.

    Returns
    -------
    EffectSpec

    Raises
    ------
    InputError
        Naming what is wrong, what is expected with its unit, and the nearest valid name.

    Examples
    --------
    >>> parse_effect("thruster_misalignment:azimuth_deg=5@upper").target
    'upper'
    """
    return specification.parse(text, effects(), thruster_names)


def records(context: EffectContext | None = None) -> list[dict[str, Any]]:
    """Return the library as plain values for JSON; a limit that is not there is None.

    With the context of a vehicle neutral and plausible values are those on this vehicle.
    """
    return [
        {
            "id": effect.id,
            "title": effect.title,
            "source": effect.source,
            "scope": effect.scope,
            "channels": list(effect.channels),
            "parameters": [_record(parameter) for parameter in effect.parameters],
        }
        for effect in (one if context is None else one.on(context) for one in effects().values())
    ]


def _record(parameter: Parameter) -> dict[str, Any]:
    return {
        "name": parameter.name,
        "unit": parameter.unit,
        "neutral": parameter.neutral,
        "plausible": list(parameter.plausible),
        "possible": [limit if math.isfinite(limit) else None for limit in parameter.possible],
        "meaning": parameter.meaning,
    }
