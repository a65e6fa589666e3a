"""The result of `rig2sea blind` as a page of the documents, with its pictures."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from evaluation.baselines import ANSWERS_FILE
from evaluation.campaign_page import goal_table, stored, write_csv, write_pictures, write_rates
from pipeline.blind.goals import Miss
from pipeline.blind.rates import QuantileFigure
from pipeline.blind.score import CampaignScore, confusion, one_word
from pipeline.blind.verdict_score import CaseScore
from pipeline.campaign.blind_case import scored
from pipeline.campaign.campaign import CampaignResult, read_lines
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


def write_page(folder: Path, page: Path) -> None:
    """Write the page and its pictures, into ``images`` beside it, each whole or not at all."""
    header, asked, result = stored(folder, scored)
    write_pictures(page, "blind", result.score.rates, result.score.confusion)
    write_atomically(page, _text(result, header, asked, page))


def _text(
    result: CampaignResult[CampaignScore], header: Mapping[str, Any], asked: str, page: Path
) -> str:
    score = result.score
    vehicles = " ".join(f"--vehicle {name}" for name in header["vehicles"])
    command = (
        f"rig2sea blind {asked} --seed {header['seed']} --run-s {header['run_s']:g} "
        f"{vehicles} --to DIR"
    )
    lines = [
        "# The blind check",
        "",
        "<!-- Written by python -m evaluation.write_campaign; do not edit. -->",
        "",
        f"{result.done} cases.",
        f"Vehicles {', '.join(header['vehicles'])}; seed {header['seed']};",
        f"six runs of {header['run_s']:g} s in each case, two of them held out;",
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
        *_baselines(result),
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


def _baselines(result: CampaignResult[CampaignScore]) -> list[str]:
    """Right answers of the plain methods, and of this diagnosis on the same cases."""
    answers = {one["number"]: one["answers"] for one in read_lines(result.to / ANSWERS_FILE)}
    scores = {
        line["number"]: CaseScore.model_validate_json(json.dumps(line["score"]))
        for line in result.lines
        if line["number"] in answers
    }
    if not scores:
        return []
    ours = confusion(list(scores.values()), lambda one: one_word(one.verdict))
    told = {one.case: answers[number] for number, one in scores.items()}
    tables = {"this diagnosis": ours}
    for name in sorted(next(iter(told.values()))):
        tables[name] = confusion(list(scores.values()), _of_method(told, name))
    rows = []
    for name, table in tables.items():
        right = total = quiet = healthy = 0
        for truth, counts in zip(table.truths, table.counts, strict=True):
            hit = counts[table.answers.index(truth)]
            if truth == "none":
                quiet, healthy = hit, sum(counts)
            elif truth != "unknown":
                right, total = right + hit, total + sum(counts)
        rows.append(f"| {name} | {right} of {total} | {quiet} of {healthy} |")
    answered = sum(sum(counts) for counts in ours.counts)
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


def _of_method(told: Mapping[str, Mapping[str, str]], method: str) -> Callable[[CaseScore], str]:
    """Answer of a plain method to each case."""
    return lambda one: told[one.case][method]


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
