"""``rig2sea new``."""

import shlex
from pathlib import Path

import click

from pipeline.commands.common.options import AS_JSON, folder
from pipeline.commands.common.say import print_json, say


@click.command()
@click.argument("vehicle", required=False)
@click.option(
    "--like",
    metavar="VEHICLE",
    help="Begin with model, sensors and channels of a bundled vehicle; --list names them.",
)
@click.option("--list", "show_list", is_flag=True, help="List the bundled vehicles and end.")
@folder("--raw", "raw", "Folder that gets the vehicle's folder.  [default: raw]")
@click.option(
    "--example", is_flag=True, help="Write the example vehicle of that name, with its raw files."
)
@AS_JSON
def new(
    *,
    vehicle: str | None,
    like: str | None,
    show_list: bool,
    raw: Path,
    example: bool,
    as_json: bool,
) -> None:
    r"""Write a raw folder to fill in: a commented vehicle.yaml and a form for each kind of test.

    With --like the vehicle file is that of a bundled vehicle, ready to simulate and to be made your
    own: bluerov2 (six thrusters), bluerov2_heavy (eight), remus100 (torpedo AUV), mmt300, rov8,
    cargo_carrier. What is there already is never overwritten.

    \b
    Examples:
      rig2sea new myauv
      rig2sea new myauv --raw ~/bench/raw
      rig2sea new myrov --like bluerov2
      rig2sea new mmt300 --example
    """
    from pipeline.workflow.new import vehicles_to_begin_with, write_new_vehicle

    if show_list:
        names = vehicles_to_begin_with()
        if as_json:
            print_json({"schema": "rig2sea/new/1", "vehicles": names})
        else:
            click.echo("\n".join(names))
        return
    if vehicle is None:
        raise click.UsageError("Missing argument 'VEHICLE'.")
    if example and like is not None:
        raise click.UsageError("Give either --example or --like VEHICLE.")
    written = write_new_vehicle(vehicle, raw, example=example, like=like)
    if as_json:
        found = {"schema": "rig2sea/new/1", "vehicle": vehicle, "files": [str(p) for p in written]}
        print_json(found)
        return
    for path in written:
        click.echo(path)
    if example:
        elsewhere = [] if raw == Path("raw") else ["--raw", str(raw)]
        command = shlex.join(["rig2sea", "run", vehicle, *elsewhere])
        say(f"{raw / vehicle / 'README.md'} says what they are. Next: {command}")
    else:
        say(f"Now fill them in; {raw / vehicle / 'README.md'} says how.")
