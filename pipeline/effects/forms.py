"""What effects of a kind have in common: what they add to or scale, factors by axis, the DVL."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from pipeline.effects.effect import AXES, Apply, EffectContext, Parameter, add, scale
from pipeline.types import FloatArray


def adding(**parameters: str | tuple[str, ...]) -> Apply:
    """Add to each slot the value of a parameter; several make the entries of an array."""

    def apply(
        vector: FloatArray, values: Mapping[str, float], _on: int | None, _all: EffectContext
    ) -> None:
        for slot, names in parameters.items():
            value = values[names] if isinstance(names, str) else [values[one] for one in names]
            add(vector, slot, np.array(value))

    return apply


def of_all_thrusters(change: Callable[..., None], slot: str, parameter: str) -> Apply:
    """Change, by `add` or `scale`, a slot of every thruster by the value of a parameter."""

    def apply(
        vector: FloatArray, values: Mapping[str, float], _on: int | None, context: EffectContext
    ) -> None:
        change(vector, slot, values[parameter], slice(len(context.thruster_names)))

    return apply


def factors_by_axis(
    meanings: Iterable[str], plausible: tuple[float, float], possible: tuple[float, float]
) -> tuple[Parameter, ...]:
    """Return a factor for each axis, surge to yaw, with its meaning; 1 leaves all as it is."""
    return tuple(
        Parameter(
            axis, unit="1", neutral=1.0, plausible=plausible, meaning=meaning, possible=possible
        )
        for axis, meaning in zip(AXES, meanings, strict=True)
    )


def scale_axes(slot: str) -> Apply:
    """Scale the entries of a slot (6,) by the factors of their axes."""

    def apply(
        vector: FloatArray, values: Mapping[str, float], _on: int | None, _all: EffectContext
    ) -> None:
        scale(vector, slot, np.array([values[axis] for axis in AXES]))

    return apply


def scale_rows_and_columns(slot: str) -> Apply:
    """Scale a matrix (6, 6) by sqrt(f_i f_j), so that it stays symmetric and definite."""

    def apply(
        vector: FloatArray, values: Mapping[str, float], _on: int | None, _all: EffectContext
    ) -> None:
        factor = np.array([values[axis] for axis in AXES])
        scale(vector, slot, np.sqrt(np.outer(factor, factor)))

    return apply


def without_dvl(context: EffectContext) -> str | None:
    """Return why an error of the DVL is no candidate, if so."""
    return None if "dvl" in context.measured else "no DVL is among the measured quantities"
