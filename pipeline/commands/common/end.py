"""How a command ends that did its work without some of the raw files."""

from collections.abc import Iterable

import click

from pipeline.errors import Problem
from pipeline.language import translate


def end_with(refused: Iterable[Problem]) -> None:
    """Tell what was refused and end with exit code 1; do nothing when nothing was."""
    errors = tuple(refused)
    for problem in errors:
        click.echo(translate(f"error: {problem}"), err=True)
    if errors:
        raise click.exceptions.Exit(1)
