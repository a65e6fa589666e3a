"""``rig2sea diagnose``."""

import json
from pathlib import Path

import click

from pipeline.commands.common.options import OUT, RAW, ValuesCommand
from pipeline.commands.common.progress import telling
from pipeline.language import translate


@click.command(cls=ValuesCommand)
@click.argument("vehicle")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@click.option(
    "--holdout",
    multiple=True,
    metavar="RUN...",
    help="Runs that are kept out of the fit and judge the answer.  [default: every 4th window]",
)
@click.option(
    "--healthy",
    multiple=True,
    metavar="RUN...",
    help="Runs from when the vehicle was well: they show what is ordinary on it.",
)
@click.option(
    "--to",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder of the results.  [default: processed/VEHICLE/diagnosis]",
)
@click.option("--json", "as_json", is_flag=True, help="Print diagnosis.json.")
@RAW
@OUT
def diagnose(  # noqa: PLR0917 - click passes every option by its name
    vehicle: str,
    runs: tuple[str, ...],
    holdout: tuple[str, ...],
    healthy: tuple[str, ...],
    to: Path | None,
    as_json: bool,
    raw: Path,
    out: Path,
) -> None:
    r"""Say where the simulation and the vehicle disagree, and why.

    VEHICLE is a name under raw/, a path to a folder that holds vehicle.yaml, or a bundled vehicle
    (rov8, cargo_carrier). RUN is a name under the vehicle's pool/, a log (*.mcap), or a folder of
    logs; or a mooring table (*.xlsx, *.csv), which is judged against the thruster model. All names
    after --holdout or --healthy belong to it, up to the next option. Writes diagnosis.json and,
    where the verdict changes it, vehicle_corrected.yaml; the vehicle file itself is never changed.

    \b
    Examples:
      rig2sea diagnose mmt300 2024-05-15-zig-zag --healthy 2024-05-14-zig-zag
      rig2sea diagnose mmt300 new_bollard_test.xlsx
      rig2sea diagnose rov8 trial1.mcap trial2.mcap --holdout trial3.mcap --to trial/
    """
    from pipeline.actions.bench_diagnosis import are_tables

    if are_tables(runs):
        _diagnose_tables(vehicle, runs, holdout, healthy, to=to, as_json=as_json, raw=raw, out=out)
        return
    from pipeline.actions.diagnosis import DiagnosisRequest, diagnose_to_files
    from pipeline.actions.diagnosis_text import diagnosis_text
    from pipeline.report.first_screen import glance_text

    request = DiagnosisRequest(vehicle, runs, holdout, healthy, to=to, raw=raw, out=out)
    with telling() as tell:
        files = diagnose_to_files(request, tell)
    if as_json:
        click.echo(json.dumps(files.record.model_dump(mode="json"), indent=1))
        return
    if files.record.glance is not None:
        click.echo(translate(glance_text(vehicle, files.record.glance)) + "\n")
    click.echo(translate(diagnosis_text(files.record)))
    if files.corrected is not None:
        click.echo(translate(f"vehicle file with the effect: {files.corrected}"))
    for overlay in files.overlays:
        click.echo(translate(f"measured and simulated with the effect: {overlay}"))
    for reason in files.without_overlay:
        click.echo(translate(f"no log with the effect: {reason}"))
    click.echo(str(files.result))
    click.echo(translate(f"report: {files.page}"))


def _diagnose_tables(
    vehicle: str,
    runs: tuple[str, ...],
    holdout: tuple[str, ...],
    healthy: tuple[str, ...],
    *,
    to: Path | None,
    as_json: bool,
    raw: Path,
    out: Path,
) -> None:
    """Ask the same question of mooring tables."""
    from pipeline.actions.bench_diagnosis import TableRequest, diagnose_table_to_file
    from pipeline.actions.diagnosis_text import diagnosis_text
    from pipeline.report.diagnosis_page import bench_glance
    from pipeline.report.first_screen import glance_text

    record, result, page = diagnose_table_to_file(
        TableRequest(vehicle, runs, holdout, healthy, to=to, raw=raw, out=out)
    )
    if as_json:
        click.echo(json.dumps(record.model_dump(mode="json"), indent=1))
        return
    click.echo(glance_text(record.vehicle, bench_glance(record)))
    click.echo(translate(diagnosis_text(record)))
    click.echo(str(result))
    click.echo(translate(f"report: {page}"))
