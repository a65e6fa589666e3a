"""``rig2sea reference``."""

import json
from pathlib import Path

import click

from pipeline.commands.common.options import OUT, RAW
from pipeline.commands.common.progress import telling
from pipeline.language import translate


@click.command()
@click.argument("vehicle")
@click.argument("runs", nargs=-1, metavar="[RUN]...")
@click.option(
    "--to",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder of reference.json.  [default: processed/VEHICLE]",
)
@click.option("--json", "as_json", is_flag=True, help="Print the reference as JSON.")
@RAW
@OUT
def reference(  # noqa: PLR0917 - click passes every option by its name
    vehicle: str, runs: tuple[str, ...], to: Path | None, as_json: bool, raw: Path, out: Path
) -> None:
    r"""Learn from sound runs what the vehicle file lacks, and test it on runs left out.

    VEHICLE is a name under raw/, a path to a folder that holds vehicle.yaml, or a bundled vehicle
    (rov8, cargo_carrier). RUN is a name under the vehicle's pool/, a log (*.mcap), or a folder of
    logs; without one, all runs whose notes say `healthy: true` and those of accepted_days: in
    vehicle.yaml. Three runs are needed. Writes reference.json; no vehicle file is changed.

    \b
    Examples:
      rig2sea reference mmt300
      rig2sea reference mmt300 2024-05-14-surge-steps 2024-05-14-zig-zag
    """
    from pipeline.actions.reference import ReferenceRequest, make_reference
    from pipeline.actions.reference_text import reference_text

    with telling() as tell:
        record, path = make_reference(ReferenceRequest(vehicle, runs, to, raw, out), tell)
    if as_json:
        click.echo(json.dumps(record.model_dump(mode="json"), indent=1))
        return
    click.echo(translate(reference_text(record)))
    click.echo(str(path))
