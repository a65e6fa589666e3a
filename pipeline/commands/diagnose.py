"""``rig2sea diagnose``."""

from typing import TYPE_CHECKING, Any

import click

from pipeline.commands.common.options import (
    OUT,
    RAW,
    ValuesCommand,
    json_option,
    several,
    to_folder,
)
from pipeline.commands.common.say import print_json, say, telling
from pipeline.language import as_it_is, translate

if TYPE_CHECKING:
    from pipeline.records.diagnosis import DiagnosisRecord


@click.command(cls=ValuesCommand)
@click.argument("vehicle")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@several(
    "--holdout",
    "RUN...",
    "Runs that judge how far the gap shrinks.  [default: each half of the runs in turn]",
)
@several(
    "--healthy", "RUN...", "Runs from when the vehicle was well: they show what is ordinary on it."
)
@to_folder("Folder of the results.  [default: processed/VEHICLE/diagnosis]")
@json_option("Print diagnosis.json.")
@RAW
@OUT
def diagnose(*, as_json: bool, **given: Any) -> None:  # noqa: ANN401 - fields of the request
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
    from pipeline.actions.diagnosis import DiagnosisRequest, are_tables, diagnose_to_files
    from pipeline.report.diagnosis_page import bench_glance
    from pipeline.report.page import glance_text

    request = DiagnosisRequest(**given)
    tables = are_tables(request.runs)
    if tables:
        from pipeline.actions.bench_diagnosis import diagnose_table_to_file

        files = diagnose_table_to_file(request)
    else:
        with telling() as tell:
            files = diagnose_to_files(request, tell)
    record = files.record
    if as_json:
        print_json(record)
        return
    if tables:
        click.echo(glance_text(record.vehicle, bench_glance(record)))
    elif record.glance is not None:
        click.echo(translate(glance_text(request.vehicle, record.glance)) + "\n")
    say(diagnosis_text(record))
    if files.corrected is not None:
        say(f"vehicle file with the effect: {files.corrected}")
    for overlay in files.overlays:
        say(f"measured and simulated with the effect: {overlay}")
    for reason in files.without_overlay:
        say(f"no log with the effect: {reason}")
    click.echo(str(files.result))
    say(f"report: {files.page}")


def diagnosis_text(record: "DiagnosisRecord") -> str:
    """Verdict, where the gap is, ranking, how far it shrinks, what to do next, notes."""
    from pipeline.report.diagnosis_words import closed_text, identifiers, of_bench, verdict_sentence

    lines = [verdict_sentence(record.verdict), ""]
    readings = "the codes" if of_bench(record) else "the time"
    gaps = sorted(record.gap.channels.items(), key=lambda item: -item[1].ratio)
    ratios = ", ".join(f"{name} {one.ratio:.2f}" for name, one in gaps)
    lines.append(f"gap over the healthy floor: {ratios}")
    lines.extend(
        f"  {row.share:.0%} of it where {row.regressor} is {row.range[0]:.3g} to "
        f"{_with_unit(f'{row.range[1]:.3g}', row.unit)} ({row.share_of_time:.0%} of {readings})"
        for row in record.gap.where.regimes[:3]
    )
    lines.append("")
    for answer in record.ranking[:5]:
        values = ", ".join(
            _with_unit(f"{name} {one.value:.4g} [{one.ci95[0]:.4g}, {one.ci95[1]:.4g}]", one.unit)
            for name, one in answer.parameters.items()
        )
        at = dict.fromkeys(answer.thrusters.values())
        where = f" at {' and '.join(at)}" if at else ""
        effect = as_it_is(answer.effect)
        lines.append(f"  {answer.probability:6.1%}  {effect}{where}  {values}".rstrip())
    shrink = record.shrink
    share = shrink.gap_closed
    closed = "" if share is None else f", {closed_text(share)} of the gap closed"
    floor = max(shrink.noise_floor, 1e-12) if of_bench(record) else 1.0
    before, after = shrink.before / floor, shrink.after / floor
    held = f"held out ({shrink.held_out}): {before:.2f} before, {after:.2f} after"
    lines += ["", f"{held}, in units of the healthy floor{closed}"]
    if record.next_run is not None:
        one = record.next_run
        separates = (
            f"{one.manoeuvre}, which separates {identifiers(one.separates)} by "
            f"{one.expected_separation_sigma:.1f} sigma"
        )
        bench = of_bench(record)
        lines.append(f"measure next: {separates}" if bench else f"fly next: {separates}")
    lines += [f"note: {note}" for note in record.notes]
    return "\n".join(lines)


def _with_unit(text: str, unit: str) -> str:
    """Write a unit behind a number; nothing where there is none."""
    return text if unit == "1" else f"{text} {unit}"
