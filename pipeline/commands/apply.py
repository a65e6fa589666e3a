"""``rig2sea apply``."""

from pathlib import Path

import click

from pipeline.commands.common.options import AS_JSON, OUT, RAW
from pipeline.commands.common.say import print_json, say
from pipeline.language import translate


@click.command()
@click.argument("vehicle")
@click.argument("source", required=False, metavar="[DIAGNOSIS | IDENTIFICATION | DAY | RUN]")
@click.option("--yes", is_flag=True, help="Write without asking.")
@click.option("--undo", is_flag=True, help="Undo the last change.")
@AS_JSON
@RAW
@OUT
def apply(
    *, vehicle: str, source: str | None, yes: bool, undo: bool, as_json: bool, raw: Path, out: Path
) -> None:
    r"""Write what was found into vehicle.yaml, after showing what changes.

    The second argument is "diagnosis" or "identification" (the last one of the vehicle), the path
    of a diagnosis.json or identification.json or of its folder, the name of a diagnosis under
    reports/, a trial day or a pool run. Shown are values before and after with their interval, the
    codes of thrusters that change, and the errors on held-out data. Comments and layout of the file
    stay; the former file is kept beside it. With --json nothing is written unless --yes is given
    too.

    \b
    Examples:
      rig2sea apply mmt300 diagnosis
      rig2sea apply myauv 2024-05-15 --yes
      rig2sea apply myauv --undo
    """
    from pipeline.workflow import apply as work
    from pipeline.workflow import apply_text as text

    if undo == (source is not None):
        raise click.UsageError(
            "Give what was found (diagnosis, identification, a trial day, a run or a file), or "
            "--undo."
        )
    if undo:
        file, entry = work.undo(vehicle, raw, out)
        if as_json:
            print_json({"undone": entry.model_dump(mode="json")})
            return
        say(f"{file} is as it was before {entry.date_utc} UTC ({entry.reason}).")
        return
    assert source is not None  # noqa: S101 - refused above
    proposal = work.propose(vehicle, source, raw, out)
    if as_json:
        written = work.apply(proposal, out) if yes else None
        print_json(text.as_json(proposal, written))
        return
    say(text.as_text(proposal))
    if not yes and not click.confirm(translate(f"Write this into {proposal.file}?")):
        say("Nothing was written.")
        return
    entry = work.apply(proposal, out)
    say(f"written: {proposal.file}; the former one: {entry.former}")
    say(f"To bring tables, allocator and firmware up to date: rig2sea run {vehicle}")
