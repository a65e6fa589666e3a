"""``rig2sea diagnose``."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.command_options import OUT, RAW, ValuesCommand
from pipeline.command_progress import telling
from pipeline.language import translate

if TYPE_CHECKING:
    from pipeline.records.diagnosis import DiagnosisRecord


@click.command(cls=ValuesCommand)
@click.argument("vehicle")
@click.argument("runs", nargs=-1, required=True, metavar="RUN...")
@click.option(
    "--holdout",
    multiple=True,
    metavar="RUN...",
    help="Runs that take no part and by which the answer is judged.  [default: every 4th window]",
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
    r"""Say where the simulation and the vehicle disagree, and because of what.

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
    from pipeline.stages.bench_diagnosis import are_tables

    if are_tables(runs):
        _diagnose_tables(vehicle, runs, holdout, healthy, to=to, as_json=as_json, raw=raw, out=out)
        return
    from pipeline.stages.diagnosis import DiagnosisRequest, diagnose_to_files

    request = DiagnosisRequest(vehicle, runs, holdout, healthy, to=to, raw=raw, out=out)
    with telling() as tell:
        files = diagnose_to_files(request, tell)
    if as_json:
        click.echo(json.dumps(files.record.model_dump(mode="json"), indent=1))
        return
    click.echo(translate(_text(files.record)))
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
    from pipeline.stages.bench_diagnosis import TableRequest, diagnose_table_to_file
    from pipeline.stages.bench_diagnosis_text import bench_text

    record, result, page = diagnose_table_to_file(
        TableRequest(vehicle, runs, holdout, healthy, to=to, raw=raw, out=out)
    )
    if as_json:
        click.echo(json.dumps(record.model_dump(mode="json"), indent=1))
        return
    click.echo(translate(bench_text(record)))
    click.echo(str(result))
    click.echo(translate(f"report: {page}"))


def _text(record: "DiagnosisRecord") -> str:
    from pipeline.report.diagnosis_words import closed_text

    lines = [record.verdict.sentence, ""]
    gaps = sorted(record.gap.channels.items(), key=lambda item: -item[1].ratio)
    lines.append(
        "gap over the healthy floor: " + ", ".join(f"{name} {one.ratio:.2f}" for name, one in gaps)
    )
    lines.extend(
        f"  {row.share:.0%} of it where {row.regressor} is {row.range[0]:.3g} to "
        f"{_with_unit(f'{row.range[1]:.3g}', row.unit)} ({row.share_of_time:.0%} of the time)"
        for row in record.gap.where.regimes[:3]
    )
    lines.append("")
    for answer in record.ranking[:5]:
        values = ", ".join(
            _with_unit(f"{name} {one.value:.4g} [{one.ci95[0]:.4g}, {one.ci95[1]:.4g}]", one.unit)
            for name, one in answer.parameters.items()
        )
        where = f" at {answer.thruster}" if answer.thruster else ""
        lines.append(f"  {answer.probability:6.1%}  {answer.effect}{where}  {values}".rstrip())
    shrink = record.shrink
    share = shrink.gap_closed
    closed = "" if share is None else f", {closed_text(share)} of the gap closed"
    held = f"held out ({shrink.held_out}): {shrink.before:.2f} before, {shrink.after:.2f} after"
    lines += ["", f"{held}, in units of the healthy floor{closed}"]
    if record.next_run is not None:
        one = record.next_run
        lines.append(
            f"fly next: {one.manoeuvre}, which separates {' and '.join(one.separates)} by "
            f"{one.expected_separation_sigma:.1f} sigma"
        )
    lines += [f"note: {note}" for note in record.notes]
    return "\n".join(lines)


def _with_unit(text: str, unit: str) -> str:
    """Write a unit behind a number; nothing where there is none."""
    return text if unit == "1" else f"{text} {unit}"
