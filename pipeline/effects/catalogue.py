"""The library of effects as plain values: what ``rig2sea effects --json`` prints."""

import math
from typing import Any

from pipeline.effects.effect import EffectContext, Parameter
from pipeline.effects.library import effects


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
