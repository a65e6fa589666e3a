"""``rig2sea reference``."""

from typing import Any

import click

from pipeline.commands.common.options import OUT, RAW, json_option, to_folder
from pipeline.commands.common.say import print_json, say, telling


@click.command()
@click.argument("vehicle")
@click.argument("runs", nargs=-1, metavar="[RUN]...")
@to_folder("Folder of reference.json.  [default: processed/VEHICLE]")
@json_option("Print the reference as JSON.")
@RAW
@OUT
def reference(*, as_json: bool, **request: Any) -> None:  # noqa: ANN401 - fields of the request
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
    from pipeline.actions.reference import ReferenceRequest, make_reference, reference_text

    with telling() as tell:
        record, path = make_reference(ReferenceRequest(**request), tell)
    if as_json:
        print_json(record)
        return
    say(reference_text(record))
    click.echo(str(path))
