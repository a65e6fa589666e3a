"""The catalogue of effects: `docs/effects.md` and what ``rig2sea effects`` shows.

Write the page anew after a change of an effect::

    python -m pipeline.effects.catalogue > docs/effects.md
"""

import math
from typing import Any

from pipeline.effects.effect import Effect, EffectContext, Parameter
from pipeline.effects.library import VERDICTS, description, effects

_HEAD = """\
# Effects: the causes that rig2sea knows

<!-- Written by `python -m pipeline.effects.catalogue > docs/effects.md`; change the files in
     pipeline/effects/ instead. -->

An effect is one physical cause of a difference between the nominal model (what the vehicle file
states) and the vehicle. It has a few parameters; at their neutral values it is absent and the
simulation is the nominal one, bit for bit. Effects are constant over a run.

On the command line an effect is written `ID:key=value[,key=value][@thruster]`, for example

    rig2sea simulate mmt300 --manoeuvre zig_zag --effect current:north_mps=0.2 \\
        --effect thruster_degraded:thrust_fraction=0.6@upper --to run.mcap

A parameter that is not named stays neutral. *Plausible* is where the value lies when the effect is
at work on a real vehicle; values outside *possible* are refused. *Shows in* names the channels in
which the effect acts first: velocities u v w, rates p q r, attitude phi theta psi, depth z,
position x y (body axes x forward, y starboard, z down; earth north, east, down). What follows from
these by turning and drifting, in the end every channel, is not listed. To add one:
[add_an_effect.md](add_an_effect.md).

A diagnosis can also answer
"""


def markdown() -> str:
    """Return the catalogue page, complete."""
    library = effects()
    lines = [_HEAD]
    lines += [f"- `{id_}`: {meaning}." for id_, meaning in VERDICTS.items()]
    lines += ["", "| effect | what it is | parameters | shows in |", "|---|---|---|---|"]
    for effect in library.values():
        parameters = ", ".join(f"`{p.name}`{_bracketed(p.unit)}" for p in effect.parameters)
        anchor = f"[`{effect.id}`](#{effect.id})"
        channels = " ".join(effect.channels)
        lines.append(f"| {anchor} | {_subject(effect)} | {parameters} | {channels} |")
    for effect in library.values():
        lines += ["", *_section(effect)]
    return "\n".join(lines) + "\n"


def _subject(effect: Effect) -> str:
    return effect.title + (" (one thruster)" if effect.scope == "thruster" else "")


def _section(effect: Effect) -> list[str]:
    rows = [
        f"| `{p.name}` | {p.unit} | {p.neutral:g} | {_range(p.plausible)} | {_range(p.possible)} "
        f"| {p.meaning} |"
        for p in effect.parameters
    ]
    target = "one thruster, named after `@`" if effect.scope == "thruster" else "the vehicle"
    channels, slots = " ".join(effect.channels), ", ".join(effect.vector_slots)
    return [
        f"## {effect.id}",
        "",
        description(effect.id),
        "",
        "| parameter | unit | neutral | plausible | possible | meaning |",
        "|---|---|---|---|---|---|",
        *rows,
        "",
        f"Acts on {target}. Shows in {channels}. Moves {slots}.",
        "",
        f"Source: {effect.source}.",
    ]


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


def _bracketed(unit: str) -> str:
    return "" if unit == "1" else f" [{unit}]"


def _range(limits: tuple[float, float]) -> str:
    low, high = limits
    if math.isinf(low) and math.isinf(high):
        return "any"
    if math.isinf(high):
        return f"from {low:g}"
    return f"{low:g} to {high:g}"


if __name__ == "__main__":
    print(markdown(), end="")
