"""Options that several commands have alike."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

_F = TypeVar("_F", bound=Callable[..., Any])


def folder(option: str, default: str, meaning: str) -> Callable[[_F], _F]:
    """Make an option that takes a folder."""
    return click.option(
        option, type=click.Path(path_type=Path), default=Path(default), metavar="DIR", help=meaning
    )


RAW = folder("--raw", "raw", "Where a VEHICLE that is a name is looked for.  [default: raw]")
OUT = folder("--out", "", "Folder that holds processed/.  [default: here]")
#: Of commands that work on all vehicles, and write results of any kind.
ALL_RAW = folder("--raw", "raw", "Folder that holds a folder for each vehicle.  [default: raw]")
RESULTS = folder("--out", "", "Folder that gets processed/ and reports/.  [default: here]")
VEHICLES = click.argument("vehicles", nargs=-1, metavar="[VEHICLE]...")
CORES = click.option(
    "--cores", type=click.IntRange(1), metavar="N", help="Cores to use.  [default: all]"
)


def json_option(meaning: str = "Print one JSON object.") -> Callable[[_F], _F]:
    """Make the option that prints for a machine."""
    return click.option("--json", "as_json", is_flag=True, help=meaning)


AS_JSON = json_option()


def to_folder(meaning: str, *, required: bool = False) -> Callable[[_F], _F]:
    """Make the option that takes the folder of what is written."""
    kind = click.Path(path_type=Path, file_okay=False)
    return click.option("--to", type=kind, required=required, metavar="DIR", help=meaning)


def to_file(meaning: str, *, required: bool = False) -> Callable[[_F], _F]:
    """Make an option that takes a file to write."""
    kind = click.Path(path_type=Path, dir_okay=False)
    return click.option("--to", type=kind, required=required, metavar="FILE", help=meaning)


def several(option: str, metavar: str, meaning: str) -> Callable[[_F], _F]:
    """Make an option that may be given several times."""
    return click.option(option, multiple=True, metavar=metavar, help=meaning)


def keep_raw_apart(parameters: Mapping[str, Any]) -> None:
    """Refuse to write (``--to``) where raw data lie, whatever command these parameters are of."""
    from pipeline.plan import POOL, RAW_KINDS, UsageError

    raw = parameters.get("raw")
    vehicles = [parameters.get(name) for name in ("vehicle", "subject", "vehicles")]
    named = [one for some in vehicles for one in (some if isinstance(some, tuple) else (some,))]
    paths = [Path(one) for one in named if one]
    folders = [path.resolve() for path in paths if (path / "vehicle.yaml").is_file()]
    to = parameters.get("to")
    if not isinstance(to, Path):
        return
    target = to.resolve()
    roots = [(raw if isinstance(raw, Path) else Path("raw")).resolve()]
    roots += [folder / kind for folder in folders for kind in (*RAW_KINDS, POOL)]
    inside = any(root == target or root in target.parents for root in roots)
    if inside or target in folders or target in {one / "vehicle.yaml" for one in folders}:
        raise UsageError(
            f"--to {to}: raw data lie there, and no command writes among them. Name another place."
        )


class NumberRange(click.FloatRange):
    """A range that NaN lies outside of, which is neither below its least nor above its largest."""

    def convert(
        self,
        value: Any,  # noqa: ANN401 - as click has it
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> float:
        """Return the number, or refuse it as any other beyond the range."""
        number: float = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{number} is not in the range {self._describe_range()}.", param, ctx)
        return number


class ValuesCommand(click.Command):
    """A command whose repeatable options take all values up to the next option.

    ``diagnose VEHICLE RUN --healthy A B`` is ``--healthy A --healthy B``: a shell writes it that
    way for ``--healthy day/*.mcap``, and a healthy run read as a sick one would spoil the answer
    without a word. Before the arguments are there an option takes one value, as usual.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the command line with its options repeated for each of their values."""
        return super().parse_args(ctx, list(self._repeated(ctx, args)))

    def _repeated(self, ctx: click.Context, args: Sequence[str]) -> Iterator[str]:
        params = self.get_params(ctx)
        options = {
            name: one for one in params if isinstance(one, click.Option) for name in one.opts
        }
        wanted = sum(isinstance(one, click.Argument) for one in params)
        found, takes_all = 0, ""
        rest = iter(args)
        for word in rest:
            if word == "--":
                yield word
                yield from rest
            elif word.startswith("-") and len(word) > 1:
                yield word
                option = options.get(word)
                several = option is not None and option.multiple and found >= wanted
                takes_all = word if several else ""
                if option is not None and not option.is_flag:
                    yield from [value for value in [next(rest, None)] if value is not None]
            elif takes_all:
                yield takes_all
                yield word
            else:
                found += 1
                yield word
