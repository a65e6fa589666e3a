"""``rig2sea new``."""

import shlex
from pathlib import Path

import click

from pipeline.language import translate


@click.command()
@click.argument("vehicle")
@click.option(
    "--raw",
    type=click.Path(path_type=Path),
    default=Path("raw"),
    metavar="DIR",
    help="Folder that gets the vehicle's folder.  [default: raw]",
)
@click.option(
    "--example", is_flag=True, help="Write the example vehicle of that name, with its raw files."
)
def new(vehicle: str, raw: Path, example: bool) -> None:
    r"""Write a raw folder to fill in: a commented vehicle.yaml and a form for each kind of test.

    What is there already is never overwritten.

    \b
    Examples:
      rig2sea new myauv
      rig2sea new myauv --raw ~/bench/raw
      rig2sea new mmt300 --example
    """
    from pipeline.workflow.new import write_new_vehicle

    for path in write_new_vehicle(vehicle, raw, example=example):
        click.echo(path)
    if example:
        elsewhere = [] if raw == Path("raw") else ["--raw", str(raw)]
        command = shlex.join(["rig2sea", "run", vehicle, *elsewhere])
        text = f"{raw / vehicle / 'README.md'} says what they are. Next: {command}"
        click.echo(translate(text))
    else:
        click.echo(translate(f"Now fill them in; {raw / vehicle / 'README.md'} says how."))
