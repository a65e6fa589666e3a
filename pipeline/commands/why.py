"""``rig2sea why``."""

from dataclasses import asdict
from pathlib import Path

import click

from pipeline.commands.common.options import AS_JSON, OUT, RAW
from pipeline.commands.common.say import print_json, say
from pipeline.language import translate


@click.command()
@click.argument("vehicle")
@click.argument("cell", nargs=-1, required=True, metavar="CELL...")
@AS_JSON
@RAW
@OUT
def why(vehicle: str, cell: tuple[str, ...], as_json: bool, raw: Path, out: Path) -> None:
    r"""Show where a number came from, back to the sheets of the raw files or to a finding.

    CELL is a path as in tables.json, or table, coefficient and speed in m/s (Tables 2 and 4) or
    number of the coefficient (Tables 1 and 3, from 0). Every file of the chain is shown with its
    digest, the version and code that made it, and whether it still fits what it was made from. A
    path of vehicle.yaml shows the interval of its number and the finding that apply wrote it from.

    \b
    Examples:
      rig2sea why mmt300 table4.KN1[2]
      rig2sea why mmt300 table2 1.5 KF1
      rig2sea why mmt300 table3 positive 1 --json
      rig2sea why mmt300 thrusters.upper.gain_ahead
    """
    from pipeline.workflow.why import as_text, stated_text, to_json, why_stated
    from pipeline.workflow.why import why as find

    stated = why_stated(vehicle, cell, raw, out)
    if stated is not None:
        shown = {**asdict(stated), "schema": "rig2sea/why/1", "file": str(stated.file)}
        if stated.change is not None:
            shown["change"] = stated.change.model_dump(mode="json")
        if as_json:
            print_json(shown)
        else:
            say(stated_text(stated))
        return
    answer = find(vehicle, cell, raw, out)
    click.echo(to_json(answer) if as_json else translate(as_text(answer)))
