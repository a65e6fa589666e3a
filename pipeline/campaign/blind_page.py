"""The result of a blind check as a page of the documents, with its pictures."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.blind.goals import Miss
from pipeline.blind.rates import QuantileFigure
from pipeline.blind.score import CampaignScore
from pipeline.campaign.blind_case import BlindRequest
from pipeline.campaign.campaign import CampaignResult
from pipeline.campaign.page import asked_for, goal_table, write_csv, write_pictures, write_rates
from pipeline.provenance import write_atomically

_DISTRUST = """\
## When to distrust this
- The truth is another simulator (`pipeline/blind/truth`): momenta, rotation matrix, adaptive
  integrator; shafts with their own dynamics; coloured noise; every stated parameter drawn within
  its stated uncertainty. What neither simulator knows (free surface, thrusters that blow at each
  other, hoses) is in no case.
- Gaps are over windows of ten seconds, in the worst channel. An effect that cannot reach the wanted
  gap has the largest that it can; below 1.5 floors it is drawn again, up to three times.
- A tether of the nominal model is taken out before a case is made.
- Directions and sizes of effects follow this program's idea of what is plausible.
"""


def write_page(result: CampaignResult[CampaignScore], request: BlindRequest, page: Path) -> None:
    """Write the page and its pictures, into ``images`` beside it, each whole or not at all."""
    write_pictures(page, "blind", result.score.rates, result.score.confusion)
    write_atomically(page, _text(result, request, page))


def _text(result: CampaignResult[CampaignScore], request: BlindRequest, page: Path) -> str:
    score = result.score
    vehicles = " ".join(f"--vehicle {name}" for name in request.vehicles)
    command = (
        f"rig2sea blind {asked_for(request)} --seed {request.seed} --run-s {request.run_s:g} "
        f"{vehicles} --to DIR"
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
        f"Vehicles {', '.join(request.vehicles)}; seed {request.seed};",
        f"six runs of {request.run_s:g} s in each case, two of them held out;",
        f"{result.not_made} could not be flown, {score.refused} were refused as hopeless;",
        f"made by the program with the digest {result.code}.",
        "The words of the tables: [diagnosis.md](diagnosis.md#how-often-it-is-right).",
        "Again with",
        "",
        f"    {command}",
        "",
        "Labels were sealed before each diagnosis and opened when its verdict was on disk. Bounds",
        "are those of Clopper and Pearson at 95 %. Gap means gap over healthy floor.",
        "",
        "## Against the goals",
        "",
        *goal_table(score.goals, "rate", digits=1),
        *write_rates(page, score.rates),
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
        f"On the {answered} cases of one effect, of none, or from outside the library. To the last",
        "kind no plain method has a right answer, so it counts in neither column.",
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
    worst = sum("for sure" in row[-1] or "called ill" in row[-1] for row in rows[1:])
    return [
        "## What was missed",
        "",
        f"{len(missed)} cases, one by one in [{table.name}]({table.name}); {worst} of them were",
        "wrong for sure. One case again: the command above with `--only NUMBER` in place of",
        "`--cases`.",
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
