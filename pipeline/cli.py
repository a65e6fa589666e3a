"""The command line: one command for each thing a person wants, and no logic.

Everything heavy is imported inside the command that needs it, so that ``--help`` answers at once.
"""

import io
import os
import sys
from functools import wraps
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

import click

from pipeline import __version__, commands
from pipeline.commands.common.language import (
    TranslatedGroup,
    in_our_words,
    language_option,
    translate,
)
from pipeline.commands.common.options import (
    ALL_RAW,
    AS_JSON,
    CORES,
    RESULTS,
    VEHICLES,
    folder,
    keep_raw_apart,
    to_folder,
)
from pipeline.commands.common.say import end_with, say

if TYPE_CHECKING:
    from pipeline.check.findings import Findings


class _Cli(TranslatedGroup):
    """Ends every command with one message and an exit code, never with a traceback."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:  # noqa: ANN401 - as click has it
        super().__init__(*args, **kwargs)
        self.params.append(language_option())
        _keep_lines(self)

    def add_command(self, cmd: click.Command, name: str | None = None) -> None:
        """Add a command whose examples stand on lines of their own."""
        _keep_lines(cmd)
        _keep_raw_apart(cmd)
        super().add_command(cmd, name)

    def invoke(self, ctx: click.Context) -> Any:  # noqa: ANN401 - as click has it
        from pipeline.errors import Rig2SeaError
        from pipeline.plan import UsageError

        try:
            return super().invoke(ctx)
        except (click.exceptions.Exit, click.ClickException, click.Abort):
            raise
        except UsageError as error:
            raise in_our_words(click.UsageError(str(error), ctx)) from None
        except Rig2SeaError as error:
            say(f"error: {error}", err=True)
            raise click.exceptions.Exit(1) from None
        except KeyboardInterrupt:
            said = "Stopped."
            if ctx.invoked_subcommand == "run":
                said = "Stopped. The next run goes on from here."
            say(said, err=True)
            raise click.exceptions.Exit(1) from None
        except BrokenPipeError:
            raise  # click knows what to do when the reader of a pipe has gone
        except Exception as error:  # noqa: BLE001 - whatever it is, the user gets one message
            from pipeline.commands.common.say import why_it_ended

            say(why_it_ended(error), err=True)
            raise click.exceptions.Exit(1) from None


def _keep_lines(command: click.Command) -> None:
    r"""Turn the ``\b`` of a raw docstring into the sign by which click leaves lines as they are."""
    if command.help is not None:
        command.help = command.help.replace("\\b\n", "\b\n")


def _keep_raw_apart(command: click.Command) -> None:
    """Let a command run only where it does not write among raw data."""
    run_it = command.callback
    if run_it is None or not any(one.name in {"to", "page"} for one in command.params):
        return

    @wraps(run_it)
    def guarded(*args: Any, **kwargs: Any) -> Any:  # noqa: ANN401 - as click has it
        keep_raw_apart(kwargs)
        return run_it(*args, **kwargs)

    command.callback = guarded


@click.group(
    cls=_Cli,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 done (failed checks of results are reported), 1 bad input or no result, "
    "2 wrong usage.",
)
@click.version_option(__version__, prog_name="rig2sea")
def cli() -> None:
    r"""Rig data of underwater-vehicle thrusters in, coefficient tables and firmware out.

    \b
    Example:
      rig2sea check raw/mmt300
      rig2sea run
    """


@cli.command()
@VEHICLES
@ALL_RAW
@RESULTS
@CORES
@click.option("--force", is_flag=True, help="Redo everything, changed or not.")
@click.option(
    "--profile",
    metavar="NAME",
    help='Where the jobs are executed: "slurm", or a folder of your own (docs/cluster.md).',
)
def run(**request: Any) -> None:  # noqa: ANN401 - fields of the request
    r"""Bring tables, firmware and reports up to date; only what changed is redone.

    VEHICLE is a name under raw/ or a path to a folder that holds vehicle.yaml; without one, all
    under raw/ are run.

    \b
    Examples:
      rig2sea run
      rig2sea run mmt300 --cores 2
      rig2sea run ~/bench/t200 --out ~/bench/results
      rig2sea run --profile slurm
    """
    from pipeline.workflow.outcome import summary
    from pipeline.workflow.progress import Progress
    from pipeline.workflow.run import RunRequest
    from pipeline.workflow.run import run as run_workflow

    result = run_workflow(RunRequest(**request), Progress())
    for paragraph in summary(result, request["out"]):
        click.echo(f"\n{translate(paragraph)}")
    raise click.exceptions.Exit(result.code)


@cli.command()
@click.argument("paths", nargs=-1, required=True, metavar="PATH...")
@click.option(
    "--vehicle",
    type=click.Path(path_type=Path, exists=True),
    metavar="FILE",
    help="The vehicle.yaml to use.  [default: the one in the file's vehicle folder]",
)
@folder("--raw", "raw", "Where a PATH that is a vehicle's name is looked for.  [default: raw]")
@AS_JSON
@click.option(
    "--write",
    is_flag=True,
    help="Put the columns as they were understood into vehicle.yaml, after showing the difference.",
)
@click.option("--yes", is_flag=True, help="With --write: do not ask.")
def check(
    paths: tuple[str, ...],
    *,
    vehicle: Path | None,
    raw: Path,
    as_json: bool,
    write: bool,
    yes: bool,
) -> None:
    r"""Read raw files and print what was understood and every problem.

    PATH is a raw file, a folder of them, a vehicle's folder or its name. Nothing is changed without
    --write.

    \b
    Examples:
      rig2sea check raw/mmt300
      rig2sea check raw/mmt300/load_test/drive-07.xlsx
      rig2sea check mmt300 --json
      rig2sea check mmt300 --write
    """
    from pipeline.check.files import check_paths
    from pipeline.check.text import as_text, to_json
    from pipeline.ingest.reading_process import in_reading_process

    findings = in_reading_process(
        lambda: check_paths(paths, raw=raw, vehicle_file=vehicle, tell=_tell_on_terminal)
    )
    _tell_on_terminal(None)
    click.echo(to_json(findings) if as_json else translate(as_text(findings)))
    if write:
        _write_columns(findings, vehicle, yes=yes)
    raise click.exceptions.Exit(1 if findings.failed else 0)


def _write_columns(findings: "Findings", vehicle: Path | None, *, yes: bool) -> None:
    """Show what would change in each vehicle file, ask, and write it."""
    from pipeline.check.proposal import proposals
    from pipeline.check.proposal import write as write_file

    found = proposals(findings, vehicle)
    if not found:
        say("vehicle.yaml states every column already, or none was understood.")
    for one in found:
        click.echo(one.difference())
        if yes or click.confirm(translate(f"Write this into {one.file}?")):
            write_file(one)
            say(f"written: {one.file}")


def _tell_on_terminal(path: str | None) -> None:
    """Show what is being read, on one line that goes away; say nothing into a file or a pipe."""
    if sys.stderr.isatty():
        click.echo("\r\x1b[2K" + (translate(f"reading {path}") if path else ""), err=True, nl=False)


@cli.command()
@click.argument("vehicle")
@to_folder("Folder for the files; created if it does not exist.", required=True)
@click.option(
    "--format",
    "form",
    type=click.Choice(("firmware", "px4", "ardusub", "gazebo", "stonefish")),
    default="firmware",
    help="What the files are for.  [default: firmware]",
)
@ALL_RAW
@RESULTS
def export(vehicle: str, to: Path, form: str, raw: Path, out: Path) -> None:
    r"""Write a vehicle's firmware, or its model for an autopilot or a simulator.

    firmware: tables and allocator as C99, JSON and CSV; results that are out of date are brought up
    to date first. px4, ardusub: parameters. gazebo: a world in SDF. stonefish: a scenario. All but
    firmware say in their head and here what they cannot hold, and what that costs in three
    manoeuvres.

    \b
    Examples:
      rig2sea export mmt300 --to build/firmware
      rig2sea export rov8 --format gazebo --to build/gazebo
    """
    if form != "firmware":
        from pipeline.actions.receivers import export_to_receiver

        written = export_to_receiver(vehicle, form, to, raw, out)
        click.echo(written.path)
        lost = (f"not in it: {text}" for text in written.lost)
        for text in (*written.says, *lost, *(cost.line for cost in written.costs)):
            say(text)
        return
    from pipeline.workflow.one_result import export_firmware
    from pipeline.workflow.run import RunRequest

    files, refused = export_firmware(RunRequest((vehicle,), raw, out), to)
    for path in files:
        click.echo(path)
    end_with(refused)


#: Time of the marks of finished jobs. [s since 1970]
_MARKED_AT = 946_684_800


@cli.command(hidden=True)
@click.argument("work", type=click.Path(path_type=Path))
@click.option("--done", type=click.Path(path_type=Path), required=True, help="Made at the end.")
def stages(work: Path, done: Path) -> None:
    r"""Run stages one after the other in one process.

    WORK is a JSON list of {"vehicle", "stage", "item", "code", "inputs", "outputs"}.
    """
    import json

    from pipeline.provenance import write_atomically
    from pipeline.stage_process import run_steps

    code = run_steps(json.loads(work.read_text(encoding="utf-8")))
    if code == 0:
        write_atomically(done, "done\n")
        # one time for all marks: the engine refuses what is older than what it waited for, and
        # clocks are set back, or differ from machine to machine
        os.utime(done, (_MARKED_AT, _MARKED_AT))
    raise click.exceptions.Exit(code)


# every file of pipeline/commands holds the command of its name
for _name in sorted(one.name for one in iter_modules(commands.__path__) if not one.ispkg):
    cli.add_command(getattr(import_module(f"{commands.__name__}.{_name}"), _name))


def _open_closed_streams() -> None:
    """Let what is told into a closed stream go nowhere (``2>&-`` in a table of cron).

    Python has None for such a stream; and the first file that a command opens would get its number,
    with what other programs tell into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
    nowhere = Path(os.devnull)
    if sys.stdout is None:
        sys.stdout = nowhere.open("w", encoding="utf-8")
    if sys.stderr is None:
        sys.stderr = nowhere.open("w", encoding="utf-8")


def main() -> None:
    """Run the command line."""
    _open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # a sign that the terminal's locale lacks is written as its number, not refused
            stream.reconfigure(errors="backslashreplace")
    cli.main(prog_name="rig2sea")
