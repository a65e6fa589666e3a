"""``rig2sea identify``."""

import json
from pathlib import Path
from typing import Literal

import click

from pipeline.commands.common.options import OUT, RAW, NumberRange, ValuesCommand
from pipeline.commands.common.progress import telling
from pipeline.language import translate


@click.command(cls=ValuesCommand)
@click.argument("vehicle")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@click.option(
    "--holdout",
    multiple=True,
    metavar="RUN...",
    help="Runs that are kept out of the fit and judge it: all names up to the next option.",
)
@click.option(
    "--method",
    type=click.Choice(["both", "whole-vehicle", "straight-line"]),
    default="both",
    show_default=True,
    help="The fit of the whole vehicle, the slope of acceleration against thrust, or both.",
)
@click.option(
    "--without",
    multiple=True,
    metavar="CHANNEL...",
    help="Leave a channel out of the fit: velocity, angular_velocity, specific_force, attitude, "
    "depth or position; for one that is an estimate, or not to be trusted.",
)
@click.option(
    "--only",
    multiple=True,
    metavar="PARAMETER...",
    help="Free these parameters alone: names of the result, or an axis (yaw: all of yaw).",
)
@click.option(
    "--smoother",
    type=click.Choice(["local-polynomial", "moving-average"]),
    default="local-polynomial",
    show_default=True,
    help="How the velocity is smoothed for the slope; Potapov and Galyaev take the moving average.",
)
@click.option(
    "--window",
    "window_s",
    type=NumberRange(1.0, 120.0),
    metavar="S",
    help="Length of the windows of the fit.  [default: 8, or 20 without velocity and position]",
)
@click.option(
    "--no-advice",
    is_flag=True,
    help="Do not compute which manoeuvre would help most; saves half a minute.",
)
@click.option(
    "--to",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder of the results.  [default: processed/VEHICLE/identification]",
)
@click.option("--json", "as_json", is_flag=True, help="Print identification.json.")
@RAW
@OUT
def identify(  # noqa: PLR0917 - click passes every option by its name
    vehicle: str,
    runs: tuple[str, ...],
    holdout: tuple[str, ...],
    method: Literal["both", "whole-vehicle", "straight-line"],
    without: tuple[str, ...],
    only: tuple[str, ...],
    smoother: str,
    window_s: float | None,
    no_advice: bool,
    to: Path | None,
    as_json: bool,
    raw: Path,
    out: Path,
) -> None:
    r"""Identify added masses, damping, buoyancy and righting moment from pool runs.

    VEHICLE is a name under raw/, a path to a folder that holds vehicle.yaml, or a bundled vehicle
    (rov8, cargo_carrier). RUN is a name under the vehicle's pool/, a log (*.mcap), or a folder of
    logs. Writes identification.json and vehicle_identified.yaml, the vehicle file with the values
    found; the vehicle file itself is never changed. "?" marks what the runs hardly determine.

    \b
    Examples:
      rig2sea identify mmt300 2024-05-14-zig-zag --holdout 2024-05-15-zig-zag
      rig2sea identify rov8 trial.mcap --to trial/
      rig2sea identify mmt300 2024-05-15-straight --method straight-line
    """
    from pipeline.actions.identification import IdentificationRequest, identify_runs
    from pipeline.actions.identification_text import identification_text

    request = IdentificationRequest(
        vehicle,
        runs,
        holdout,
        method=method,
        smoother="moving_average" if smoother == "moving-average" else "local_polynomial",
        without=without,
        only=only,
        window_s=window_s,
        to=to,
        raw=raw,
        out=out,
        suggest=not no_advice,
    )
    with telling() as tell:
        files = identify_runs(request, tell)
    record = files.record
    if as_json:
        click.echo(json.dumps(record.model_dump(mode="json"), indent=1))
        return
    for warning in record.warnings:
        click.echo(translate(f"warning: {warning}"), err=True)
    for run in (*record.runs, *record.holdout):
        for warning in run.warnings:
            click.echo(translate(f"{run.name}: {warning}"), err=True)
    click.echo(translate(identification_text(record)))
    click.echo()
    for picture in files.pictures:
        click.echo(picture)
    if files.corrected is not None:
        click.echo(translate(f"vehicle file with these values: {files.corrected}"))
    click.echo(str(files.result))
