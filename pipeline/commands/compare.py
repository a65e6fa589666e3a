"""``rig2sea compare``."""

from pathlib import Path

import click

from pipeline.commands.common.options import AS_JSON, OUT, RAW, to_folder
from pipeline.commands.common.say import print_json, say, telling


@click.command()
@click.argument("a")
@click.argument("b")
@click.option(
    "--vehicle", metavar="VEHICLE", help="The vehicle that they belong to, if it is not clear."
)
@to_folder("Folder of the page and comparison.json.  [default: reports/comparisons/A-B]")
@AS_JSON
@RAW
@OUT
def compare(
    *, a: str, b: str, vehicle: str | None, to: Path | None, as_json: bool, raw: Path, out: Path
) -> None:
    r"""Say whether two things can be compared, and what differs: B against A.

    A and B are two days (2024-05-14), runs or logs; bench files of thrust; one voltage or thruster
    of them (t200@12V, FILE@left); or vehicles and their files. Runs are fitted together, and which
    thruster or parameter differs in which of them is tested: no fit needs to have settled.

    \b
    Examples:
      rig2sea compare 2024-05-14 2024-05-15
      rig2sea compare t200@12V t200@16V
      rig2sea compare raw/mmt300/vehicle.yaml processed/mmt300/identified/vehicle_identified.yaml
    """
    from pipeline.actions.comparison import compare as compare_sides
    from pipeline.actions.comparison import write_comparison

    with telling() as tell:
        record = compare_sides(a, b, vehicle, raw, out, tell)
    folder = to
    if folder is None:
        plain = "".join(one if one.isalnum() or one in "-_." else "-" for one in f"{a}-{b}")
        folder = out / "reports" / "comparisons" / plain.strip("-.")[-120:]
    result, page = write_comparison(record, folder, out / "reports" / "assets")
    if as_json:
        print_json(record)
    else:
        say(record.verdict)
        for caution in record.cautions:
            say(f"note: {caution}")
        click.echo(str(result))
        say(f"report: {page}")
    raise click.exceptions.Exit(0 if record.comparable else 1)
