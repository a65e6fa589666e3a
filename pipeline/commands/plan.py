"""``rig2sea plan``."""

import re
from pathlib import Path

import click

from pipeline.commands.common.options import AS_JSON, OUT, RAW, to_folder
from pipeline.commands.common.say import print_json, say, telling

_POOL = re.compile(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)")


@click.command()
@click.argument("vehicle")
@click.option(
    "--minutes",
    type=click.FloatRange(0.5, 240.0),
    default=10.0,
    show_default=True,
    metavar="M",
    help="Largest number of minutes of flying.",
)
@click.option("--pool", metavar="LxWxD", help="Length, width and depth of the pool in metres.")
@to_folder("Folder of the page, logs and codes.  [default: reports/VEHICLE/plan]")
@AS_JSON
@RAW
@OUT
def plan(
    *,
    vehicle: str,
    minutes: float,
    pool: str | None,
    to: Path | None,
    as_json: bool,
    raw: Path,
    out: Path,
) -> None:
    r"""Plan the next pool day: the shortest list of manoeuvres that determines the parameters.

    Each manoeuvre is flown in simulation, inside the pool; the list grows by what helps most, until
    every parameter reaches the wanted interval or the minutes are used. The page says what each is
    for; codes over time are written as CSV and as logs to play. What was flown of the last plan is
    reported first.

    \b
    Examples:
      rig2sea plan mmt300
      rig2sea plan rov8 --minutes 20 --pool 10x5x3
    """
    found = None if pool is None else _POOL.fullmatch(pool.lower().replace(",", "."))
    if pool is not None and found is None:
        raise click.UsageError(f"--pool {pool}: metres as LxWxD are expected, e.g. 25x10x3.")
    from pipeline.actions.pool_day import plan_day
    from pipeline.report.plain_words import manoeuvre_words
    from pipeline.report.pool_day_page import plan_sentence

    room = None if found is None else (float(found[1]), float(found[2]), float(found[3]))
    with telling() as tell:
        made = plan_day(vehicle, minutes, pool_m=room, to=to, raw=raw, out=out, tell=tell)
    if as_json:
        last = [one.model_dump() for one in made.flown]
        print_json({**made.record.model_dump(mode="json"), "last": last})
        return
    for one in made.flown:
        say(f"last plan: {one.text}")
    say(plan_sentence(made.record))
    for run in made.record.runs:
        what = ", ".join(name.replace("_", " ") for name in run.what_for) or "all together"
        name = manoeuvre_words(run.manoeuvre)
        say(f"  {run.number}. {name}, {run.duration_s:.0f} s: {what}")
    click.echo(str(made.result))
    say(f"report: {made.page}")
