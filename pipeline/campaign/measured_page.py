"""The result of a measured blind check as tables and pictures of a page."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.blind.rates import Rate
from pipeline.campaign.measured_campaign import MeasuredRequest, MeasuredResult
from pipeline.campaign.measured_score import MeasuredLine
from pipeline.campaign.page_block import write_block, write_csv
from pipeline.provenance import write_atomically
from pipeline.report.blind import confusion_picture, rates_picture

BLOCK, TITLE = "the measured campaign", "The measured blind check"
_CASES_HEAD = (
    *("case", "vehicle", "runs", "healthy", "put in", "floors", "in the log, %", "answer"),
    *("probability", "beside it", "interval", "outcome"),
)


def write_page(result: MeasuredResult, request: MeasuredRequest, page: Path) -> None:
    """Write tables between the marks of a page, and pictures into `images` beside it.

    Parameters
    ----------
    result : MeasuredResult
        The campaign.
    request : MeasuredRequest
        What was asked for, for the command on the page.
    page : Path
        ``*.md``.
    """
    images = page.parent / "images"
    images.mkdir(parents=True, exist_ok=True)
    score = result.score
    pictures = {
        "measured-rates.svg": rates_picture(picture_rows(score.goals)),
        "measured-confusion.svg": confusion_picture(
            score.confusion.truths, score.confusion.answers, score.confusion.counts
        ),
    }
    for name, content in pictures.items():
        write_atomically(images / name, content)
    cases = page.with_name(f"{page.stem}_cases.csv")
    write_csv(cases, [_CASES_HEAD, *(_row(line) for line in result.lines)])
    write_block(page, BLOCK, TITLE, "\n".join([*_text(result, request), _led_to(cases)]))


def picture_rows(rates: Sequence[Rate]) -> list[tuple[str, float, float, float, bool]]:
    """Make the rows of a picture of those rates that have a goal."""
    return [
        (f"{one.question}, {one.stratum}", one.share, one.low, one.high, one.met)
        for one in rates
        if one.share is not None and one.low is not None and one.high is not None
        if one.met is not None
    ]


def goal_table(rates: Sequence[Rate]) -> list[str]:
    """Tabulate rates with their bounds and goals."""
    rows = [
        f"| {one.stratum} | {one.question} | {_cell(one)} | {one.goal} |"
        for one in rates
        if one.cases
    ]
    return ["| cases | question | rate (95 %) | goal |", "|---|---|---|---|", *rows, ""]


def _cell(one: Rate) -> str:
    text = f"{one.yes} of {one.cases}"
    if one.share is not None and one.low is not None and one.high is not None:
        text += f" = {100 * one.share:.0f} % ({100 * one.low:.0f} to {100 * one.high:.0f} %)"
    return text + {None: "", True: ", met", False: ", **missed**"}[one.met]


def _text(result: MeasuredResult, request: MeasuredRequest) -> list[str]:
    score = result.score
    asked = " ".join(f"--only {number}" for number in request.only) or f"--cases {request.cases}"
    return [
        f"{result.done} of {result.wanted} cases of seed {request.seed};",
        f"{result.not_made} could not be made, {score.refused} were refused;",
        f"by the program with the digest {result.code}. Again with",
        "",
        f"    rig2sea blind --measured DATA {asked} --seed {request.seed} --to DIR",
        "",
        *goal_table(score.goals),
        "![Rates with their bounds; orange: the goal is missed](images/measured-rates.svg)",
        "",
        *goal_table(score.rates),
        "![Truth against answer](images/measured-confusion.svg)",
        "",
    ]


def _led_to(cases: Path) -> str:
    return f"Every case, what was put in and what was said: [{cases.name}]({cases.name})."


def _row(line: MeasuredLine) -> tuple[str, ...]:
    score = line.score
    put = "as it is"
    if line.effect is not None:
        values = ", ".join(f"{name} {value:.3g}" for name, value in line.parameters.items())
        put = f"{line.effect} {values}" + (f" {line.thruster}" if line.thruster else "")
        put += ", commanded" if line.kind == "dead" and line.size == 0.0 else ""
    told = "refused" if score.refused else " + ".join(score.verdict)
    told += f" {line.told_thruster}" if line.told_thruster else ""
    return (
        str(line.number),
        line.subject,
        ", ".join(dict.fromkeys(_short(name) for name in line.runs)),
        str(len(line.healthy)),
        put,
        f"{line.size:.1f}" if line.size else "",
        f"{100.0 * line.share:.0f}" if line.effect else "",
        told,
        f"{score.probability:.2f}",
        ", ".join(score.ambiguous_with),
        ", ".join("held" if one.inside else "missed" for one in score.intervals),
        _outcome(line),
    )


def _outcome(line: MeasuredLine) -> str:
    if line.effect is None:
        right = line.score.verdict == ("none",)
        return "right" if right else "false alarm" if line.sure_effect else "open"
    if line.first:
        return "right"
    if line.surely_wrong:
        return "surely wrong"
    return "in the set" if line.in_set else "missed"


def _short(name: str) -> str:
    """Shorten the name of a log of the public data: what tells it from the others."""
    return name.removeprefix("rosbag2_2025_05_27-").replace("_2016-05-25-", " ")[:22]
