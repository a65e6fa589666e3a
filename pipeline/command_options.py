"""Options that several commands have alike."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

_F = TypeVar("_F", bound=Callable[..., Any])


def folder(option: str, default: str, meaning: str) -> Callable[[_F], _F]:
    """Make an option that takes a folder."""
    return click.option(
        option,
        type=click.Path(path_type=Path),
        default=Path(default),
        metavar="DIR",
        help=meaning,
    )


RAW = folder("--raw", "raw", "Where a VEHICLE that is a name is looked for.  [default: raw]")
OUT = folder("--out", "", "Folder that holds processed/.  [default: here]")
AS_JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
