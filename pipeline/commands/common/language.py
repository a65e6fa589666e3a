"""The command line in the reader's language: its option, its help, its messages on wrong usage."""

import io
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import IO, Any

import click

from pipeline.language import (
    ENGLISH,
    LANGUAGES,
    VARIABLE,
    as_it_is,
    current,
    translate,
    use,
    wanted,
)

__all__ = ["TranslatedGroup", "in_our_words", "language_option", "translate"]

_OPTION = "--language"


def language_option() -> click.Option:
    """Return the option; it is looked for before anything else is read (`TranslatedGroup`)."""
    return click.Option(
        [_OPTION],
        type=click.Choice(LANGUAGES),
        expose_value=False,
        help="Language of messages and pages; files for machines are always in English.  "
        f"[default: {VARIABLE}, or the locale]",
    )


class _Formatter(click.HelpFormatter):
    """Translates each piece of a help text before it is broken into lines."""

    def write_usage(self, prog: str, args: str = "", prefix: str | None = None) -> None:
        super().write_usage(prog, args, prefix or f"{translate('Usage:')} ")

    def write_heading(self, heading: str) -> None:
        super().write_heading(translate(heading))

    def write_text(self, text: str) -> None:
        paragraphs = [
            one if "\b" in one else translate(" ".join(one.split())) for one in text.split("\n\n")
        ]
        super().write_text("\n\n".join(_example(one) for one in paragraphs))

    def write_dl(self, rows: Iterable[tuple[str, str]], *args: Any, **kwargs: Any) -> None:  # noqa: ANN401 - as click has it
        super().write_dl([(name, _with_extra(text)) for name, text in rows], *args, **kwargs)


def _example(paragraph: str) -> str:
    """Translate the line above the examples."""
    lines = paragraph.split("\n")
    return "\n".join(translate(one) if one.endswith(":") else one for one in lines)


def _with_extra(text: str) -> str:
    """Translate the help of an option, and apart from it what click adds: ``[required]``."""
    said = translate(text)
    found = re.fullmatch(r"(.*?)(\s*)\[([^\[\]]+)\]", text) if said == text else None
    if found is None:
        return said
    return f"{translate(found[1])}{found[2]}[{translate(found[3])}]"


def _summary(command: click.Command, room: int) -> str:
    first = (command.help or "").split("\n\n")[0]
    said = translate(" ".join(first.split()))
    return said if len(said) <= room else f"{said[: room - 3].rsplit(' ', 1)[0]}..."


class _Context(click.Context):
    formatter_class = _Formatter


class _WrongUsageError(click.UsageError):
    """A message of click, translated as a whole."""

    def __init__(self, error: click.UsageError) -> None:
        # click lists choices on lines of their own, where each would be translated like a word
        said, *choices = error.format_message().split("\n\t")
        names = [as_it_is(choice.removesuffix(",")) for choice in choices]
        super().__init__(f"{said} {', '.join(names)}" if names else said, error.ctx)

    def show(self, file: IO[Any] | None = None) -> None:
        english = io.StringIO()
        super().show(english)
        click.echo(translate(english.getvalue()), file=file, nl=False, err=True)


class TranslatedGroup(click.Group):
    """Chooses the language before anything is read, for as long as the command runs."""

    context_class = _Context

    def add_command(self, cmd: click.Command, name: str | None = None) -> None:
        """Add a command that takes the option too."""
        for one in (cmd, *getattr(cmd, "commands", {}).values()):
            one.params.append(language_option())
            one.context_class = _Context
        super().add_command(cmd, name)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands; click would shorten the first sentence before it is translated."""
        if current() == ENGLISH:
            super().format_commands(ctx, formatter)
            return
        shown = [(name, self.commands[name]) for name in self.list_commands(ctx)]
        shown = [(name, command) for name, command in shown if not command.hidden]
        room = formatter.width - 6 - max((len(name) for name, _ in shown), default=0)
        with formatter.section("Commands"):
            formatter.write_dl([(name, _summary(command, room)) for name, command in shown])

    def main(self, args: Sequence[str] | None = None, *more: Any, **kwargs: Any) -> Any:  # noqa: ANN401 - as click has it
        """Run the command line."""
        before = current()
        try:
            return super().main(args, *more, **kwargs)
        finally:
            use(before)

    def make_context(
        self,
        info_name: str | None,
        args: list[str],
        *more: Any,  # noqa: ANN401 - as click has it
        **kwargs: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        """Read the arguments of the group."""
        use(_named(args) or wanted(os.environ))
        with _said_in_our_words():
            return super().make_context(info_name, args, *more, **kwargs)

    def invoke(self, ctx: click.Context) -> Any:  # noqa: ANN401 - as click has it
        """Run the command that was asked for."""
        with _said_in_our_words():
            return super().invoke(ctx)


@contextmanager
def _said_in_our_words() -> Iterator[None]:
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:
        raise
    except click.UsageError as error:
        raise in_our_words(error) from None


def in_our_words(error: click.UsageError) -> click.UsageError:
    """Return the same error, that shows itself in the reader's language."""
    if isinstance(error, _WrongUsageError):
        return error
    error.ctx = _of_the_command(error.ctx)
    return _WrongUsageError(error)


def _of_the_command(ctx: click.Context | None) -> click.Context | None:
    """Return the context of the command that was called, for an error that arose within it."""
    group, name = (None, None) if ctx is None else (ctx.command, ctx.invoked_subcommand)
    if ctx is None or name is None or not isinstance(group, click.Group):
        return ctx
    command = group.get_command(ctx, name)
    return ctx if command is None else _Context(command, parent=ctx, info_name=name)


def _named(args: Sequence[str]) -> str:
    """Return the language that the arguments name, wherever among them; empty for none of ours."""
    for at, one in enumerate(args):
        name, equals, value = one.partition("=")
        if one == "--":
            break
        if name == _OPTION:
            found = value if equals else "".join(args[at + 1 : at + 2])
            return found if found in LANGUAGES else ""
    return ""
