"""``rig2sea effects``."""

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline.commands.common.options import AS_JSON, RAW
from pipeline.commands.common.say import print_json, say
from pipeline.language import as_it_is, translate

if TYPE_CHECKING:
    from pipeline.effects.effect import EffectContext


@click.command()
@click.argument("vehicle", required=False)
@AS_JSON
@RAW
def effects(vehicle: str | None, as_json: bool, raw: Path) -> None:
    r"""List the effects: what each is, its parameters with units, the channels it shows in.

    With VEHICLE also which of them it can have, and why the others are no candidates.

    \b
    Examples:
      rig2sea effects
      rig2sea effects rov8
      rig2sea effects --json
    """
    from pipeline.effects.library import VERDICTS, records, why_not

    context = None if vehicle is None else _context(vehicle, raw)
    reasons = None if context is None else why_not(context)
    listed = records(context)
    if as_json:
        if reasons is not None:
            for one in listed:
                one["candidate"] = one["id"] not in reasons
                one["why_not"] = reasons.get(one["id"])
        body = {"schema": "rig2sea/effects/1", "effects": listed, "verdicts": dict(VERDICTS)}
        print_json(body | {"vehicle": vehicle})
        return
    click.echo("\n\n".join(_lines(one, (reasons or {}).get(one["id"])) for one in listed))
    say("\nWrite ID:key=value[,key=value][@thruster]; docs/effects.md has the physics.")
    if reasons is not None:
        possible = [one["id"] for one in listed if one["id"] not in reasons]
        say(f"{vehicle} can have {len(possible)} of {len(listed)}.")


def _context(vehicle: str, raw: Path) -> "EffectContext":
    """Return what the effects need to know of a vehicle."""
    from pipeline.inputs.vehicle_place import find_vehicle
    from pipeline.simulate.context import effect_context
    from pipeline.vehicle.load import load_vehicle

    _, file = find_vehicle(vehicle, raw, Path())
    return effect_context(load_vehicle(file))


def _lines(effect: dict[str, Any], reason: str | None) -> str:
    target = "  (one thruster)" if effect["scope"] == "thruster" else ""
    lines = [f"{effect['id']}{translate(target)}: {translate(effect['title'])}"]
    if reason is not None:
        lines += textwrap.wrap(translate(f"no candidate: {reason}"), 96, initial_indent="  ")
    for one in effect["parameters"]:
        unit = "" if one["unit"] == "1" else f" [{one['unit']}]"
        low, high = one["plausible"]
        text = (
            f"  {as_it_is(one['name'])}{unit}: {one['meaning']}; neutral {one['neutral']:g}, "
            f"plausible {low:g} to {high:g}"
        )
        lines.append(translate(text))
    lines.append(translate(f"  shows in {' '.join(effect['channels'])}"))
    return "\n".join(lines)
