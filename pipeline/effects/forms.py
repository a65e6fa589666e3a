"""What effects of a kind have in common: factors by axis, three coordinates, errors of the DVL."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from pipeline.effects.effect import AXES, EffectContext, Parameter, scale
from pipeline.types import FloatArray

Apply = Callable[[FloatArray, Mapping[str, float], int | None, EffectContext], None]


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
