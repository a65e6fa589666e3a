"""``rig2sea identify``."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

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
from pipeline.commands.common.say import print_json, say, telling, warn

if TYPE_CHECKING:
    from pipeline.records.identification import (
        ChannelQuality,
        Identification,
        StraightLineIdentification,
        VehicleIdentification,
    )


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


def identification_text(found: "Identification") -> str:
    """Return the lines of an identification for a terminal."""
    from pipeline.check.pool_runs import gains_text

    runs = ", ".join(f"{run.name} ({run.seconds:.0f} s)" for run in found.runs)
    lines = [f"{found.vehicle} from {runs}"]
    if found.holdout:
        lines.append("held out: " + ", ".join(run.name for run in found.holdout))
    if found.whole_vehicle is not None:
        lines += ["", *_whole(found.whole_vehicle)]
    elif found.why_no_whole_vehicle:
        lines += ["", f"No whole-vehicle fit: {found.why_no_whole_vehicle}"]
    lines += ["", *_straight(found.straight_line, found.why_no_straight_line)]
    if found.gains is not None:
        lines += ["", *gains_text(found.gains)]
    return "\n".join(lines)


def _whole(fit: "VehicleIdentification") -> list[str]:
    settled = "settled" if fit.converged else "DID NOT SETTLE"
    lines = [
        (
            f"Whole-vehicle fit: {fit.windows} windows of {fit.window_s:.0f} s, {fit.readings} "
            f"readings; {settled} after {fit.iterations} steps"
        ),
        (
            f"  {'parameter':25} {'value':>10} {'95 % interval':>23} {'vehicle file':>21} "
            f"{'corrected':>10}  unit"
        ),
    ]
    for one in fit.parameters:
        low, high = one.ci95
        prior = f"{one.prior_value:.4g} +- {one.prior_std:.2g}"
        mark = " " if one.stands else "?"
        filed = "as it was" if not one.stands or one.file_value is None else f"{one.file_value:.4g}"
        lines.append(
            f"{mark} {one.name:25} {one.value:10.4g} {low:10.4g} ... {high:<8.4g} {prior:>21} "
            f"{filed:>10}  {one.unit}"
        )
    lines.append("  The intervals hold what the uncertainty of the bench's thrust does.")
    lines += _thrust(fit)
    if fit.cannot_identify:
        lines += ["", "? Of these the runs do not tell enough to use them:"]
        lines += [f"  {sentence}" for sentence in fit.cannot_identify]
    lines += ["", *_quality(fit.quality, fit.holdout)]
    return [*lines, *(f"note: {note}" for note in fit.notes)]


def _thrust(fit: "VehicleIdentification") -> list[str]:
    """Factors of the thrusters on what the file states, and the share that the hull takes."""
    factors = [one for one in fit.thrust if one.unit == "1"]
    if not factors:
        return []
    lines = ["", f"  {'thrust over the stated one':25} {'value':>10} {'95 % interval':>23}"]
    total = () if fit.thrust_deduction is None else (fit.thrust_deduction,)
    for one in (*factors, *total):
        low, high = one.ci95
        lines.append(
            f"  {one.name.removeprefix('thrust_') if one in factors else one.name:25} "
            f"{one.value:10.3f} {low:10.3f} ... {high:<8.3f}"
        )
    return lines


def _quality(quality: "Sequence[ChannelQuality]", holdout: Sequence[str]) -> list[str]:
    if not quality:
        return ["No window was left to judge the fit by; give --holdout RUN."]
    of = "runs" if holdout else "windows"
    lines = [
        (
            f"Prediction of {of} that were not used for the fit, over {quality[0].horizon_s:.0f} s "
            "(rms error):"
        ),
        (
            f"  {'channel':18} {'identified':>10} {'corrected':>10} {'file':>10} "
            f"{'last value':>10} {'black box':>10} {'sensor':>10}  unit"
        ),
    ]
    for one in quality:
        numbers = (
            one.rmse_identified,
            one.rmse_corrected_file,
            one.rmse_vehicle_file,
            one.rmse_last_value,
            one.rmse_black_box,
            one.sensor_noise,
        )
        cells = " ".join(f"{'-' if n is None else f'{n:.3g}':>10}" for n in numbers)
        lines.append(f"  {one.channel:18} {cells}  {one.unit}")
    lines.append(
        "  Corrected: the vehicle file with what stands and the factors of the thrusters, without "
        "the curves found."
    )
    return lines


def _straight(found: "Sequence[StraightLineIdentification]", why_not: dict[str, str]) -> list[str]:
    lines = []
    for one in found:
        lines.append(
            f"Slope of acceleration against thrust, {one.axis}: {len(one.segments)} straight "
            f"stretches, {one.seconds:.0f} s, {one.smoother}"
        )
        estimates = (*one.plain, *((one.with_terms,) if one.with_terms else ()))
        for estimate in estimates:
            if estimate.refused:
                lines.append(f"  {estimate.estimator:40} refused: {estimate.refused}")
                continue
            if estimate.ci95_kg is None:
                lines.append(f"  {estimate.estimator:40} bounds no mass")
                continue
            low, high = estimate.ci95_kg
            lines.append(
                f"  {estimate.estimator:40} {estimate.added_mass_kg:8.2f} kg "
                f"({low:.2f} to {high:.2f})"
            )
        lines += [f"  warning: {warning}" for warning in one.warnings]
    by_reason: dict[str, list[str]] = {}
    for axis, reason in why_not.items():
        by_reason.setdefault(reason, []).append(axis)
    lines += [f"No slope in {', '.join(axes)}: {why}" for why, axes in by_reason.items()]
    return lines
