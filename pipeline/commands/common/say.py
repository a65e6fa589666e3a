"""What a command says: in the reader's language, as JSON, and how it ends without some files."""

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import click

from pipeline.errors import Problem
from pipeline.language import translate

if TYPE_CHECKING:
    from pipeline.records.base import Record


def say(text: str, *, err: bool = False) -> None:
    """Print a text in the reader's language."""
    click.echo(translate(text), err=err)


def print_json(body: "Mapping[str, Any] | Record") -> None:
    """Print one JSON object, in no language."""
    plain = body if isinstance(body, Mapping) else body.model_dump(mode="json")
    click.echo(json.dumps(plain, indent=1))


def warn(warnings: Iterable[str]) -> None:
    """Tell warnings on standard error."""
    for text in warnings:
        say(f"warning: {text}", err=True)


def end_with(refused: Iterable[Problem]) -> None:
    """Tell what was refused and end with exit code 1; do nothing when nothing was."""
    errors = tuple(refused)
    for problem in errors:
        say(f"error: {problem}", err=True)
    if errors:
        raise click.exceptions.Exit(1)
