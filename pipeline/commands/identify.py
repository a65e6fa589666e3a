"""``rig2sea identify``."""

from typing import Any

import click

from pipeline.commands.common.options import (
    OUT,
    RAW,
    NumberRange,
    ValuesCommand,
    json_option,
    several,
    to_folder,
)
from pipeline.commands.common.progress import telling
from pipeline.commands.common.say import print_json, say, warn


@click.command(cls=ValuesCommand)
@click.argument("vehicle")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@several(
    "--holdout",
    "RUN...",
    "Runs that are kept out of the fit and judge it: all names up to the next option.",
)
@click.option(
    "--method",
    type=click.Choice(["both", "whole-vehicle", "straight-line"]),
    default="both",
    show_default=True,
    help="The fit of the whole vehicle, the slope of acceleration against thrust, or both.",
)
@several(
    "--without",
    "CHANNEL...",
    "Leave a channel out of the fit: velocity, angular_velocity, specific_force, attitude, "
    "depth or position; for one that is an estimate, or not to be trusted.",
)
@several(
    "--only",
    "PARAMETER...",
    "Free these parameters alone: names of the result, or an axis (yaw: all of yaw).",
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
@to_folder("Folder of the results.  [default: processed/VEHICLE/identification]")
@json_option("Print identification.json.")
@RAW
@OUT
def identify(*, as_json: bool, smoother: str, no_advice: bool, **request: Any) -> None:  # noqa: ANN401 - fields of the request
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

    with telling() as tell:
        files = identify_runs(
            IdentificationRequest(
                smoother="moving_average" if smoother == "moving-average" else "local_polynomial",
                suggest=not no_advice,
                **request,
            ),
            tell,
        )
    record = files.record
    if as_json:
        print_json(record)
        return
    warn(record.warnings)
    for run in (*record.runs, *record.holdout):
        for warning in run.warnings:
            say(f"{run.name}: {warning}", err=True)
    say(identification_text(record))
    click.echo()
    for picture in files.pictures:
        click.echo(picture)
    if files.corrected is not None:
        say(f"vehicle file with these values: {files.corrected}")
    click.echo(str(files.result))
