"""``rig2sea blind``."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline.commands.common.options import AS_JSON, OUT, RAW, NumberRange, to_folder
from pipeline.commands.common.say import print_json, say
from pipeline.language import translate

if TYPE_CHECKING:
    from pipeline.blind.rates import Rate
    from pipeline.blind.score import Score
    from pipeline.campaign.campaign import CampaignResult


@click.command()
@click.option("--cases", type=click.IntRange(1, 100_000), default=60, show_default=True)
@click.option(
    "--only",
    type=click.IntRange(0, 99_999),
    multiple=True,
    metavar="NUMBER",
    help="This case alone, whatever --cases says.  May be given several times.",
)
@click.option("--seed", type=click.IntRange(0, 10_000), default=0, show_default=True)
@to_folder("Folder of the campaign: labels, verdicts, scores.  [default: processed/blind]")
@click.option(
    "--measured",
    "data",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    metavar="DATA",
    help="Put effects into measured runs instead: DATA has a folder for each vehicle.",
)
@click.option(
    "--vehicle",
    "vehicles",
    multiple=True,
    metavar="VEHICLE",
    help="May be given several times.  [default: mmt300, rov8, cargo_carrier]",
)
@click.option("--resume", is_flag=True, help="Go on with the campaign that the folder holds.")
@click.option(
    "--processes", type=click.IntRange(1, 64), default=2, show_default=True, help="Cases at a time."
)
@click.option(
    "--run-s",
    type=NumberRange(20.0, 1800.0),
    default=60.0,
    show_default=True,
    metavar="SECONDS",
    help="Length of each of a case's six runs.",
)
@click.option("--keep-logs", is_flag=True, help="Write the logs of every case as well.")
@AS_JSON
@RAW
@OUT
def blind(
    *,
    to: Path | None,
    data: Path | None,
    as_json: bool,
    raw: Path,
    out: Path,
    vehicles: tuple[str, ...],
    run_s: float,
    keep_logs: bool,
    **what: Any,  # noqa: ANN401 - fields of the request
) -> None:
    r"""Check the diagnosis blindly: make cases, diagnose them, open the labels, score.

    The cases come from a simulator of their own that shares nothing with the one that the
    diagnosis fits, or from runs that were measured (--measured): there the logged commands are
    rewritten, so that they claim what a vehicle with an effect would have needed. A campaign can be
    stopped with Ctrl-C at any time and resumed.

    \b
    Examples:
      rig2sea blind --cases 20 --to blind-20
      rig2sea blind --cases 848 --seed 1 --to blind-848
      rig2sea blind --cases 848 --seed 1 --to blind-848 --resume
      rig2sea blind --only 368 --seed 1 --to one-case --keep-logs
      rig2sea blind --measured data --cases 120 --to measured --resume
    """
    from pipeline.campaign import blind_case, measured_campaign

    result: CampaignResult[Any]
    if data is not None:
        if vehicles or keep_logs:
            raise click.UsageError(
                "--vehicle and --keep-logs belong to generated cases, not to --measured."
            )
        to = to or out / "processed" / "blind_measured"
        measured = measured_campaign.MeasuredRequest(to=to, data=data, **what)
        result = measured_campaign.run_measured(measured, _said)
    else:
        request = blind_case.BlindRequest(
            to=to or out / "processed" / "blind",
            raw=raw,
            out=out,
            vehicles=vehicles or blind_case.USUAL,
            keep_logs=keep_logs,
            run_s=run_s,
            **what,
        )
        result = blind_case.run_campaign(request, _said)
    if as_json:
        print_json(result.to_json())
    else:
        say(_text(result))
    if result.done < result.wanted:  # stopped: a script must not take it for a whole campaign
        raise click.exceptions.Exit(1)


def _said(done: int, wanted: int, line: str) -> None:
    click.echo(f"[{done}/{wanted}] {translate(line)}", err=True)


def _rates(rates: "Iterable[Rate]") -> list[str]:
    lines = []
    for one in rates:
        if one.share is None or one.low is None or one.high is None:
            continue
        met = {None: "", True: ", met", False: ", NOT met"}[one.met]
        goal = f"  (goal {one.goal}{met})" if one.goal else ""
        lines.append(
            f"  {one.stratum}: {one.question}: {one.yes} of {one.cases} = {one.share:.1%} "
            f"[{one.low:.1%}, {one.high:.1%}]{goal}"
        )
    return lines


def _text(result: "CampaignResult[Score]") -> str:
    lines = [f"{result.done} of {result.wanted} cases done, {result.not_made} could not be made"]
    lines += _rates(result.score.goals)
    lines += [
        f"  {figure.question}; {figure.stratum}: median {figure.median:.3g}, "
        f"p90 {figure.p90:.3g} of {figure.cases}  (goal {figure.goal})"
        for figure in result.score.figures
        if figure.median is not None and figure.p90 is not None
    ]
    lines.append(str(result.to))
    return "\n".join(lines)
