"""What the place of a thing needs to have a meaning, and which way it then turns the vehicle.

Where nothing is on board it does not matter where it sits. A place counts with what leads it: the
mass and the volume of a payload.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.library import EffectSpec, apply_effects
from pipeline.errors import CannotComputeError, InputError
from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray


def far(parameter: Parameter) -> float:
    """Distance from neutral to the far end of the plausible range, in the parameter's unit."""
    return max(abs(limit - parameter.neutral) for limit in parameter.plausible)


def leads(
    packed: PackedVehicle, effect: Effect, target: str | None, parameter: Parameter
) -> tuple[Parameter, ...] | None:
    """Find the parameters of an effect of which one must be there for another to act.

    Returns
    -------
    tuple of Parameter or None
        Empty where it acts by itself; None where it never does, as a factor on a coefficient that
        the vehicle file has at zero.
    """
    small = {parameter.name: _sided(parameter)}
    if _acts(packed, effect, target, {}, small):
        return ()
    before = effect.parameters[: effect.parameters.index(parameter)]
    found = tuple(
        one for one in before if _acts(packed, effect, target, {one.name: _sided(one)}, small)
    )
    return found or None


def pulls(
    packed: PackedVehicle,
    effect: Effect,
    target: str | None,
    placed: Parameter,
    needed: Sequence[Parameter],
) -> tuple[float, ...]:
    """How hard each of its leads pulls at a place, over the first, by the far end of its range.

    The mass of a payload weighs, the water that it displaces lifts: about 1 and -1, as both may be
    as far as 20 kg.
    """
    moments = [
        _moment_of(packed, effect, target, one, placed) * far(one) / _sided(one) for one in needed
    ]
    first = moments[0]
    whole = float(first @ first)
    return tuple(float(one @ first) / whole if whole > 0.0 else 1.0 for one in moments)


def _moment_of(
    packed: PackedVehicle, effect: Effect, target: str | None, lead: Parameter, placed: Parameter
) -> FloatArray:
    """Moment (3,) of weight less buoyancy that a place adds to a little of what leads. [N m]."""
    there = {lead.name: _sided(lead)}
    without, moved = (
        _changed(packed, effect, target, values)
        for values in (there, there | {placed.name: _sided(placed)})
    )
    if without is None or moved is None:
        return np.zeros(3)
    return _moment(moved) - _moment(without)


def _moment(vector: FloatArray) -> FloatArray:
    """Weight at its centre less buoyancy at its own (3,). Fossen 2021, eq. (4.5). [N m]."""
    weight, buoyancy = float(read(vector, "weight")), float(read(vector, "buoyancy"))
    centre, floats = read(vector, "centre_of_mass"), read(vector, "centre_of_buoyancy")
    return np.asarray(weight * centre - buoyancy * floats)


def _acts(
    packed: PackedVehicle,
    effect: Effect,
    target: str | None,
    others: Mapping[str, float],
    small: Mapping[str, float],
) -> bool:
    """Whether a small departure changes anything beside others; refused counts as acting alone."""
    without = _changed(packed, effect, target, others)
    moved = _changed(packed, effect, target, {**others, **small})
    if without is None or moved is None:
        return not others
    return not np.array_equal(without, moved)


def _sided(parameter: Parameter) -> float:
    """Small departure towards the plausible side, in the parameter's unit."""
    low, high = parameter.plausible
    by = 1e-2 * far(parameter)
    return by if abs(high - parameter.neutral) >= abs(low - parameter.neutral) else -by


def _changed(
    packed: PackedVehicle, effect: Effect, target: str | None, departures: Mapping[str, float]
) -> FloatArray | None:
    """Vector with parameters moved off neutral; None where the effect refuses."""
    neutral = effect.neutral_values()
    values = {name: neutral[name] + by for name, by in departures.items()}
    try:
        return apply_effects(packed.vector, [EffectSpec(effect.id, values, target)], packed.context)
    except (CannotComputeError, InputError):
        return None
