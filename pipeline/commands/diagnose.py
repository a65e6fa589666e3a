"""``rig2sea diagnose``."""

from typing import Any

import click

from pipeline.commands.common.options import (
    OUT,
    RAW,
    ValuesCommand,
    json_option,
    several,
    to_folder,
)
from pipeline.commands.common.progress import telling
from pipeline.commands.common.say import print_json, say
from pipeline.language import translate


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
    from pipeline.actions.diagnosis import diagnosis_text
    from pipeline.actions.diagnosis_request import DiagnosisRequest, are_tables
    from pipeline.report.diagnosis_page import bench_glance
    from pipeline.report.page import glance_text

    request = DiagnosisRequest(**given)
    tables = are_tables(request.runs)
    if tables:
        from pipeline.actions.bench_diagnosis import diagnose_table_to_file

        files = diagnose_table_to_file(request)
    else:
        from pipeline.actions.diagnosis import diagnose_to_files

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
