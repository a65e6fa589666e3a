"""Options that several commands have alike."""

from pathlib import Path

import click

RAW = click.option(
    "--raw",
    type=click.Path(path_type=Path),
    default=Path("raw"),
    metavar="DIR",
    help="Where a VEHICLE that is a name is looked for.  [default: raw]",
)
OUT = click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path(),
    metavar="DIR",
    help="Folder that holds processed/.  [default: here]",
)
AS_JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
