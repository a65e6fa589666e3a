"""``rig2sea design``."""

from pathlib import Path

import click

from pipeline.commands.common.options import folder, json_option, to_folder
from pipeline.commands.common.say import print_json, say, warn
from pipeline.language import as_it_is

_CALCULATORS = ("balance", "propeller", "tether", "added-mass")


@click.command()
@click.argument("calculator", type=click.Choice(_CALCULATORS))
@click.argument("file", required=False, type=click.Path(path_type=Path))
@click.option(
    "--example",
    is_flag=False,
    flag_value="",
    default=None,
    metavar="[NAME]",
    help="Print an example file and end; `list` prints the names.",
)
@to_folder("Folder for page and JSON.  [default: reports/design under --out]")
@json_option("Print one JSON object; files only with --to.")
@folder("--raw", "raw", "Where a vehicle that FILE names is looked for.  [default: raw]")
@folder("--out", "", "Folder that holds processed/ and reports/.  [default: here]")
def design(
    *,
    calculator: str,
    file: Path | None,
    example: str | None,
    to: Path | None,
    as_json: bool,
    raw: Path,
    out: Path,
) -> None:
    r"""Calculate before building: thruster loads, a propeller, a tether's pull, added masses.

    balance: angle of attack and load of each stern thruster with residual buoyancy under way.
    propeller: the propeller of the Wageningen B-series that needs least power on a drive.
    tether: pull of a cable around a footprint, the forces and power that hold it.
    added-mass: of a vehicle from the shapes of its parts, as a section of its vehicle file.

    FILE is YAML; --example prints a commented one. A page with pictures and a JSON file are
    written; of added masses the section, and with --to files.

    \b
    Examples:
      rig2sea design balance --example > my.yaml
      rig2sea design balance my.yaml
      rig2sea design propeller --example remus > remus.yaml
      rig2sea design tether my_tether.yaml --to build/tether --json
    """
    if example is not None:
        click.echo(_example(calculator, example), nl=False)
        return
    if file is None:
        raise click.UsageError(
            f"Missing argument 'FILE'. `rig2sea design {calculator} --example > my.yaml` writes "
            "one to start from."
        )
    if calculator == "added-mass":
        _added_mass(file, to, as_json=as_json)
        return
    from pipeline.actions.design import (
        DesignRequest,
        compute_design,
        design_json,
        result_lines,
        write_design,
    )

    request = DesignRequest(calculator, file, raw, out)
    found = compute_design(request)
    if as_json:
        print_json(design_json(request, found))
        if to is not None:
            write_design(request, found, to)
        return
    page, data = write_design(request, found, out / "reports/design" if to is None else to)
    warn(found.warnings)
    say("\n".join(result_lines(found)))
    click.echo(page)
    click.echo(data)


def _added_mass(file: Path, to: Path | None, *, as_json: bool) -> None:
    from pipeline.actions.design import design_added_mass, write_added_mass

    found = design_added_mass(file)
    if as_json:
        print_json(found.body())
    else:
        say(found.text)
        click.echo(found.section, nl=False)
    for path in write_added_mass(found, to) if to is not None else ():
        click.echo(path, err=as_json)


def _example(calculator: str, name: str) -> str:
    from pipeline.bundled.design import design_example, design_examples

    names = design_examples(calculator)
    if name == "list":
        return "\n".join(names) + "\n"
    if name and name not in names:
        raise click.UsageError(
            f'there is no example "{name}" of {as_it_is(calculator)}; there are {", ".join(names)}.'
        )
    return design_example(calculator, name or names[0]).read_text(encoding="utf-8")
