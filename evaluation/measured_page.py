"""The result of `rig2sea blind --measured` as tables and pictures of a page."""

from pathlib import Path

from evaluation.campaign_page import (
    goal_table,
    stored,
    write_block,
    write_csv,
    write_pictures,
    write_rates,
)
from pipeline.campaign.measured_campaign import SCHEMA, MeasuredLine, measured_lines, scored

__all__ = ["SCHEMA", "write_page"]

BLOCK, TITLE = "the measured campaign", "The measured blind check"
_CASES_HEAD = (
    *("case", "vehicle", "runs", "healthy", "put in", "floors", "in the log, %", "answer"),
    *("probability", "beside it", "interval", "outcome"),
)


def write_page(folder: Path, page: Path) -> None:
    """Write tables between the marks of a page, and pictures into `images` beside it."""
    header, asked, result = stored(folder, scored)
    score = result.score
    write_pictures(page, "measured", score.goals, score.confusion)
    cases = page.with_name(f"{page.stem}_cases.csv")
    write_csv(cases, [_CASES_HEAD, *(_row(line) for line in measured_lines(result.lines))])
    text = [
        f"{result.done} cases of seed {header['seed']};",
        f"{result.not_made} could not be made, {score.refused} were refused;",
        f"by the program with the digest {result.code}. Again with",
        "",
        f"    rig2sea blind --measured DATA {asked} --seed {header['seed']} --to DIR",
        "",
        *goal_table(score.goals),
        "![Rates with their bounds; orange: the goal is missed](images/measured-rates.svg)",
        "",
        *write_rates(page, score.rates),
        "![Truth against answer](images/measured-confusion.svg)",
        "",
        f"Every case, what was put in and what was said: [{cases.name}]({cases.name}).",
    ]
    write_block(page, BLOCK, TITLE, "\n".join(text))


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
