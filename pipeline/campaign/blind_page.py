"""The result of a blind check as a page of the documents, with its pictures."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.blind.goals import Miss
from pipeline.blind.rates import QuantileFigure, Rate
from pipeline.blind.score import BANDS, PAIR_BANDS, CampaignScore
from pipeline.campaign.blind_campaign import BlindRequest, BlindResult
from pipeline.campaign.page_block import write_csv
from pipeline.provenance import write_atomically
from pipeline.report.blind import confusion_picture, rates_picture

_DISTRUST = """\
## When to distrust this
- The truth is another simulator, written apart (`pipeline/blind/truth`): momenta, rotation matrix
  and an adaptive integrator; shafts with their own dynamics; coloured noise; every stated
  parameter drawn within its stated uncertainty. It is still a simulator: what neither knows
  (free surface, thrusters that blow at each other, hoses) is in no case.
- Gaps are measured against the healthy floor over windows of ten seconds, in the worst channel.
  Some effects cannot reach the wanted gap at any possible value: the reached one is used. One that
  opens less than 1.5 floors is drawn anew (another axis, thruster, direction), up to three times.
- A tether of the nominal model is taken out before a case is made.
- The directions and sizes of the effects are drawn from this program's idea of what is plausible.
"""

#: Strata that stand side by side, under their title.
_COLUMNS = (
    ("One effect", tuple(f"gap {name}" for name, *_ in BANDS)),
    ("Two effects", tuple(f"gap of the smaller one {name}" for name, *_ in PAIR_BANDS)),
    ("With healthy runs and without", ("with healthy runs", "without healthy runs")),
)


def write_page(result: BlindResult, request: BlindRequest, page: Path) -> None:
    """Write the page and its pictures beside it, each whole or not at all.

    Parameters
    ----------
    result : BlindResult
        The campaign.
    request : BlindRequest
        What was asked for, for the command on the page.
    page : Path
        ``*.md``; pictures go to ``images`` beside it.
    """
    images = page.parent / "images"
    images.mkdir(parents=True, exist_ok=True)
    score = result.score
    pictures = {
        "blind-confusion.svg": confusion_picture(
            score.confusion.truths, score.confusion.answers, score.confusion.counts
        ),
        "blind-rates.svg": rates_picture(
            [
                (f"{one.question}, {one.stratum}", one.share, one.low, one.high, one.met)
                for one in score.rates
                if one.share is not None and one.low is not None and one.high is not None
                if one.met is not None
            ]
        ),
    }
    for name, content in pictures.items():
        write_atomically(images / name, content)
    write_atomically(page, _text(result, request, page))


def _text(result: BlindResult, request: BlindRequest, page: Path) -> str:
    place, score = request.place, result.score
    vehicles = " ".join(f"--vehicle {name}" for name in place.vehicles)
    asked = " ".join(f"--only {number}" for number in request.only) or f"--cases {request.cases}"
    command = (
        f"rig2sea blind {asked} --seed {place.seed} --run-s {place.run_s:g} {vehicles} --to DIR"
    )
    done = (
        f"{result.done} cases."
        if result.done == result.wanted
        else f"{result.done} of the {result.wanted} cases of the campaign; the kinds of cases take "
        "turns, so what is done is a fair part."
    )
    lines = [
        "# The blind check",
        "",
        "<!-- Written by rig2sea blind --page; do not edit. -->",
        "",
        done,
        f"Vehicles {', '.join(place.vehicles)}; seed {place.seed};",
        f"six runs of {place.run_s:g} s in each case, two of them held out;",
        f"{result.not_made} could not be flown, {score.refused} were refused as hopeless;",
        f"made by the program with the digest {result.code}.",
        "The words of the tables are explained in docs/diagnosis.md, under How often it is right.",
        "Again with",
        "",
        f"    {command}",
        "",
        "Labels were sealed before each diagnosis and opened when its verdict was on disk. Bounds",
        "are those of Clopper and Pearson at 95 %. Gap means gap over healthy floor.",
        "",
        "## Against the goals",
        "",
        *_goals(score.goals),
        *_tables(score.rates),
        "![Rates with their bounds; orange: the goal is missed](images/blind-rates.svg)",
        "",
        "## Figures",
        "",
        "| figure | cases | median | 90th percentile | mean | goal | met |",
        "|---|---|---|---|---|---|---|",
        *(_figure_row(one) for one in score.figures),
        "",
        "## Confusion",
        "",
        "![Truth against answer](images/blind-confusion.svg)",
        "",
        *_baselines(score),
        *_missed(score.missed, page.with_name(f"{page.stem}_missed.csv")),
        _DISTRUST,
    ]
    return "\n".join(lines)


def _goals(goals: Sequence[Rate]) -> list[str]:
    """Tabulate the rates that the goals are stated for."""
    rows = [
        f"| {one.stratum} | {one.question} | {_cell(one)} | {one.goal} |"
        for one in goals
        if one.cases
    ]
    return ["| cases | question | rate | goal |", "|---|---|---|---|", *rows, ""]


def _tables(rates: Sequence[Rate]) -> list[str]:
    """Set the rates of strata that are compared side by side, and list all others."""
    left = [one for one in rates if one.cases]
    lines: list[str] = []
    for title, columns in _COLUMNS:
        mine = [one for one in left if _column(one, columns) is not None]
        left = [one for one in left if one not in mine]
        if mine:
            lines += [f"## {title}", "", *_beside(mine, columns), ""]
    if left:
        lines += ["## Further rates", "", "| question | rate | goal |", "|---|---|---|"]
        lines += [f"| {one.question}; {one.stratum} | {_cell(one)} | {one.goal} |" for one in left]
        lines.append("")
    return lines


def _column(one: Rate, columns: Sequence[str]) -> str | None:
    return next((part for part in one.stratum.split(", ") if part in columns), None)


def _beside(rates: Sequence[Rate], columns: Sequence[str]) -> list[str]:
    """Tabulate rates with a column for each of some strata, in the order of the questions."""
    rows: dict[str, dict[str, Rate]] = {}
    for one in rates:
        column = _column(one, columns)
        rest = ", ".join(part for part in one.stratum.split(", ") if part != column)
        row = rows.setdefault(f"{one.question}, {rest}" if rest else one.question, {})
        row[column or ""] = one
    lines = [
        f"| question | {' | '.join(columns)} | goal |",
        "|---" * (len(columns) + 2) + "|",
    ]
    for question, row in rows.items():
        cells = [_cell(row[name]) if name in row else "" for name in columns]
        goals = dict.fromkeys(row[name].goal for name in columns if name in row)
        lines.append(f"| {question} | {' | '.join(cells)} | {'; '.join(filter(None, goals))} |")
    return lines


def _cell(one: Rate) -> str:
    text = f"{one.yes} of {one.cases}"
    if one.share is not None and one.low is not None and one.high is not None:
        text += f" = {100 * one.share:.1f} % ({100 * one.low:.0f} to {100 * one.high:.0f} %)"
    return text + {None: "", True: ", met", False: ", **missed**"}[one.met]


def _figure_row(one: QuantileFigure) -> str:
    median, p90, mean = (
        "" if value is None else f"{value:.3g}" for value in (one.median, one.p90, one.mean)
    )
    met = {None: "", True: "yes", False: "**no**"}[one.met]
    return (
        f"| {one.question}; {one.stratum} | {one.cases} | {median} | {p90} | {mean} | {one.goal} "
        f"| {met} |"
    )


def _baselines(score: CampaignScore) -> list[str]:
    """Right answers of the baselines, and of this diagnosis on the same cases."""
    if not score.baselines:
        return []
    rows = []
    for name, table in (("this diagnosis", score.compared), *score.baselines.items()):
        right = total = quiet = healthy = 0
        for truth, counts in zip(table.truths, table.counts, strict=True):
            hit = counts[table.answers.index(truth)]
            if truth == "none":
                quiet, healthy = hit, sum(counts)
            elif truth != "unknown":
                right, total = right + hit, total + sum(counts)
        rows.append(f"| {name} | {right} of {total} | {quiet} of {healthy} |")
    answered = sum(sum(counts) for counts in score.compared.counts)
    return [
        "## Beside it: plain methods",
        "",
        f"The plain methods answered {answered} cases of one effect, of none, or from outside the",
        "library. The table has the first two kinds; to the third no plain method has a right",
        "answer, so it counts in neither column.",
        "",
        "| method | right effect first, single effects of all sizes | none called none |",
        "|---|---|---|",
        *rows,
        "",
    ]


def _missed(missed: Sequence[Miss], table: Path) -> list[str]:
    """List the sure mistakes; every case that a goal counts stands in the table beside the page."""
    if not missed:
        return []
    head = ("case", "vehicle", "truth", "gap", "healthy runs", "not logged", "answer", "beside it")
    rows = [(*head, "fault"), *map(_miss, missed)]
    write_csv(table, rows)
    worst = [row for row in rows[1:] if "for sure" in row[-1] or "called ill" in row[-1]]
    return [
        "## What was missed",
        "",
        f"{len(missed)} cases, one by one in [{table.name}]({table.name}). One of them again: the",
        "command above with `--only NUMBER` in place of `--cases`. Those that were wrong for sure:",
        "",
        f"| {' | '.join(rows[0])} |",
        "|---" * len(rows[0]) + "|",
        *(f"| {' | '.join(row)} |" for row in worst),
        "",
    ]


def _miss(miss: Miss) -> tuple[str, ...]:
    one = miss.score
    return (
        str(int(one.case.rpartition("_")[2])),
        one.vehicle,
        " + ".join(one.truth),
        f"{one.gap_ratio:.1f}",
        "yes" if one.healthy else "no",
        ", ".join(one.missing),
        f"{' + '.join(one.verdict)} {one.probability:.2f}",
        ", ".join(one.ambiguous_with),
        miss.fault,
    )
