"""Options that take all values that follow them."""

import click
import pytest
from click.testing import CliRunner

from pipeline.cli import cli
from pipeline.commands.common.options import ValuesCommand


@click.command(cls=ValuesCommand)
@click.argument("vehicle")
@click.argument("runs", nargs=-1, required=True)
@click.option("--healthy", multiple=True)
@click.option("--holdout", multiple=True)
@click.option("--to")
@click.option("--json", "as_json", is_flag=True)
def command(
    *,
    vehicle: str,
    runs: tuple[str, ...],
    healthy: tuple[str, ...],
    holdout: tuple[str, ...],
    to: str | None,
    as_json: bool,
) -> None:
    click.echo(f"{vehicle}|{' '.join(runs)}|{' '.join(healthy)}|{' '.join(holdout)}|{to}|{as_json}")


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("V a b", "V|a b|||None|False"),
        ("V a b --healthy h1 h2 h3", "V|a b|h1 h2 h3||None|False"),
        ("V a --healthy h1 h2 --holdout c d --to out", "V|a|h1 h2|c d|out|False"),
        ("V a --healthy h1 --healthy h2", "V|a|h1 h2||None|False"),
        ("V a --healthy=h1 b", "V|a b|h1||None|False"),
        ("V a --to out b", "V|a b|||out|False"),
        ("V a --healthy h1 --json b", "V|a b|h1||None|True"),
        ("V a --healthy h1 -- -b", "V|a -b|h1||None|False"),
        # the arguments are not there yet: one value, as of any option
        ("--healthy h1 V a b", "V|a b|h1||None|False"),
        ("V --healthy h1 a b", "V|a b|h1||None|False"),
    ],
)
def test_values_belong_to_the_option_before_them(typed: str, meant: str) -> None:
    result = CliRunner().invoke(command, typed.split())
    assert result.output.strip() == meant


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("V a --healthy", "requires an argument"),
        ("V --healthy h1", "Missing argument"),
        ("V a --healthi h1", "No such option"),
    ],
)
def test_wrong_usage_is_told_as_click_tells_it(typed: str, said: str) -> None:
    result = CliRunner().invoke(command, typed.split())
    assert result.exit_code == 2
    assert said in result.output


@pytest.mark.parametrize("typed", ["nan", "-NaN", "inf", "-1"])
@pytest.mark.parametrize(
    "words", ["watch --every", "watch --settle", "identify boat run --window", "blind --run-s"]
)
def test_a_number_of_a_command_lies_within_its_range(words: str, typed: str) -> None:
    """NaN compares with neither end of a range, and went on into the computation."""
    done = CliRunner().invoke(cli, [*words.split(), typed], prog_name="rig2sea")
    assert done.exit_code == 2
    assert f"'{words.rsplit(maxsplit=1)[-1]}': {float(typed)} is not in the range" in done.stderr
