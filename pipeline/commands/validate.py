"""``rig2sea validate``."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands.common.options import AS_JSON, RAW, RESULTS, to_file
from pipeline.commands.common.say import end_with, print_json, say
from pipeline.language import as_it_is, translate

if TYPE_CHECKING:
    from pipeline.records.validation import AllocatorValidation


@click.command()
@click.argument("vehicle")
@to_file("Also write the result there, as --json prints it.")
@AS_JSON
@RAW
@RESULTS
def validate(vehicle: str, to: Path | None, as_json: bool, raw: Path, out: Path) -> None:
    r"""Fly a vehicle in simulation with its own tables, with and without speed compensation.

    VEHICLE is a name under raw/, a path to a folder that holds vehicle.yaml, or a bundled vehicle
    (rov8, cargo_carrier). Course, depth and speed are kept at several speeds, with the inverse of
    the mooring test and with the speed-compensated one; steps show what one channel does to the
    others. Tables that are out of date are made anew first. The result is in
    processed/VEHICLE/validation.json, with pictures in the vehicle's report.

    \b
    Examples:
      rig2sea validate mmt300
      rig2sea validate rov8 --json
      rig2sea validate mmt300 --to validation.json
    """
    from pipeline.workflow.one_result import validated

    result, page = validated(vehicle, raw, out)
    name = result.vehicle.name
    body = {
        "schema": "rig2sea/validate/1",
        "vehicle": name,
        **result.record.model_dump(mode="json"),
    }
    if to is not None:
        from pipeline.provenance import write_atomically

        write_atomically(to, json.dumps(body, indent=1) + "\n")
    if as_json:
        print_json(body)
    else:
        say(_text(name, result.record))
        pictures = page or f"Pictures: rig2sea run {name}, then its report."
        click.echo(f"\n{result.file}\n{translate(str(pictures))}")
    end_with(result.refused)


def _text(vehicle: str, record: "AllocatorValidation") -> str:
    head = (
        f"{vehicle}: {record.flight_s:g} s of keeping speed, course and depth, disturbed\n"
        f"  {as_it_is('mooring')}: {record.mooring_inverse}\n"
        f"  {as_it_is('compensated')}: {record.compensated_inverse}"
    )
    parts = [
        head,
        _keeping(record),
        _steps(record),
        _changes(record),
        "\n".join(f"  {text}" for text in (record.power_text, *record.explanations)),
    ]
    return "\n\n".join(part for part in parts if part)


def _keeping(record: "AllocatorValidation") -> str:
    lines = [
        "                         rms error of             surge force     demands",
        "  m/s  flown with      speed  course   depth    error   gain     cut    power",
        "                         m/s     deg       m        %                       W",
    ]
    for one in record.keeping:
        wrench = "-".rjust(7) + "-".rjust(7) + "-".rjust(8) + "-".rjust(9)
        if one.wrench_error:
            known = (one.electrical_power_w, one.shaft_power_w, one.thrust_power_w)
            watts = next(value for value in known if value is not None)
            gain = "-" if one.wrench_gain[0] is None else f"{one.wrench_gain[0]:.2f}"
            error = f"{100 * one.wrench_error[0]:.1f}"
            wrench = f"{error:>7}{gain:>7}{one.cut_share:>8.0%}{watts:>9.1f}"
        lines.append(
            f"{one.speed_mps:5.2f}  {one.variant:12}{one.speed_error_mps:8.4f}"
            f"{one.heading_error_deg:8.2f}{one.depth_error_m:8.3f}  {wrench}"
        )
    return "\n".join(lines)


def _steps(record: "AllocatorValidation") -> str:
    lines = [
        "  what a step does to the others: largest deviation",
        "  m/s  step     flown with     speed   depth  course   pitch",
        "                                 m/s       m     deg     deg",
    ]
    for one in record.steps:
        course = "step" if one.step == "heading" else f"{one.heading_deg:.2f}"
        depth = "step" if one.step == "depth" else f"{one.depth_m:.4f}"
        lines.append(
            f"{one.speed_at_mps:5.2f}  {one.step:8} {one.variant:12}{one.speed_mps:8.4f}"
            f"{depth:>8}{course:>8}{one.pitch_deg:8.2f}"
        )
    return "\n".join(lines)


def _changes(record: "AllocatorValidation") -> str:
    at = f"{record.settings_at_mps:g} m/s"
    lines = []
    if record.settings:
        lines.append(f"  compensated, with one thing changed, at {at}: rms errors")
    lines += [
        f"  speed {one.flight.speed_error_mps:.4f} m/s, course "
        f"{one.flight.heading_error_deg:.2f} deg, depth {one.flight.depth_error_m:.3f} m: "
        f"{one.setting}"
        for one in record.settings
    ]
    if record.portions_flown:
        lines.append(f"  portions of surge / heading and pitch, at {at}")
    lines += [
        f"  {one.surge:.2f} / {one.heading:.2f}: reaches {one.flight.reached_mps:.2f} m/s, "
        f"demands cut {one.flight.cut_share:.0%}; in a turn of {record.large_step_deg:g} deg "
        f"cut {one.heading_step_cut_share:.0%}"
        for one in record.portions_flown
    ]
    if record.fixed_point is not None:
        fixed = record.fixed_point
        lines.append(
            f"  fixed point against float: {fixed.differing_share:.2%} of {fixed.commands} codes "
            f"differ, by at most {fixed.largest_difference}"
        )
    return "\n".join(lines)
