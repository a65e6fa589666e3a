"""``python -m evaluation.second_generator``: the diagnosis on vehicles of another simulator.

    python -m evaluation.second_generator --cases 60 --seed 1 --to DIR --resume

One line a case in ``cases.jsonl``; a campaign that was stopped goes on with ``--resume``.
"""

import argparse
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from evaluation.campaign_page import goal_table, write_block, write_csv, write_pictures
from evaluation.cases import SecondCase, make_case
from pipeline.blind.label import CaseLabel, TrueEffect, seal
from pipeline.blind.rates import Rate, at_least, at_most, rate
from pipeline.blind.score import Score, confusion
from pipeline.blind.verdict_score import HARDLY_A_GAP, CaseScore, score_case
from pipeline.campaign.campaign import CampaignRequest, CampaignResult, diagnosed, judged, run_cases
from pipeline.diagnose.case import Case
from pipeline.effects.library import module_names
from pipeline.errors import InputError
from pipeline.inputs.runs_to_identify import read_run
from pipeline.inputs.simulated_vehicle import load_simulated
from pipeline.provenance import code_digest

SCHEMA = "rig2sea/second_generator/1"
BLOCK = "the second generator"
_HEAD = ("case", "vehicle", "as its file", "truth", "gap", "healthy runs", "answer", "p",
         "beside it")  # fmt: skip
Diagnose = Callable[[SecondCase], Mapping[str, Any]]


def diagnose_files(case: SecondCase) -> Mapping[str, Any]:
    """Read what was written and diagnose it, as the command does."""
    one = load_simulated(str(case.folder), case.folder.parent, case.folder.parent)

    def tables(names: Sequence[str]) -> tuple[Any, ...]:
        return tuple(
            read_run(case.folder / "pool" / f"{name}.mcap", one, case.folder.parent)[1]
            for name in names
        )

    runs, holdout, healthy = (tables(names) for names in (case.runs, case.holdout, case.healthy))
    return diagnosed(Case(one.name, one.vehicle, one.packed, runs, holdout, healthy))


def run_case(
    number: int, seed: int, to: Path, diagnose: Diagnose, *, keep: bool = False
) -> dict[str, Any]:
    """Make a case, have it diagnosed, and score the answer."""
    case = make_case(number, seed, to)
    sealed = to / "sealed" / f"{case.folder.name}.json"
    seal(label_of(case, seed), sealed)
    label, content, elapsed_s = judged(sealed, lambda: diagnose(case))
    if not keep:
        shutil.rmtree(case.folder)
    score = score_case(case.folder.name, label, content, elapsed_s=elapsed_s)
    return {
        "number": number,
        "exact": case.exact,
        "parameters": {} if case.fault is None else case.fault.parameters,
        "thruster": None if case.fault is None else case.fault.thruster,
        "held_out": list(case.holdout),
        "score": score.model_dump(mode="json"),
    }


def label_of(case: SecondCase, seed: int) -> CaseLabel:
    """Say what was done, as the labels of the generated blind check do."""
    fault = case.fault
    effects: tuple[TrueEffect, ...] = ()
    if fault is not None:
        effects = (
            TrueEffect(
                effect=fault.effect,
                parameters=fault.parameters,
                thruster=fault.thruster,
                axes=fault.axes,
            ),
        )
    return CaseLabel(
        vehicle=case.craft.name,
        kind=case.kind,
        effects=effects,
        trouble="snag" if case.kind == "outside" else None,
        wanted_ratio=case.wanted,
        gap_ratio=max(case.ratios.values(), default=1.0),
        channel_ratios=case.ratios,
        healthy_floor={},
        manoeuvres="open loop",
        healthy_runs=len(case.healthy),
        seed=seed,
    )


def rates_of(scores: Sequence[CaseScore]) -> tuple[Rate, ...]:
    """Count the answers against the goals, and by size and vehicle."""
    single = [one for one in scores if one.kind == "single"]
    clear = [one for one in single if one.gap_ratio >= 3.0]
    small = [one for one in single if HARDLY_A_GAP <= one.gap_ratio < 3.0]
    found = [
        rate("right effect first", "single, gap >= 3", (o.first_right for o in clear),
             at_least(0.90)),
        rate("truth in the answer set", "single, gap >= 3", (o.in_set for o in clear),
             at_least(0.97)),
        rate("false alarm", "none", (o.false_alarm for o in scores), at_most(0.01)),
        rate("surely wrong", "single", (o.confidently_wrong for o in single)),
        rate("right effect first", f"single, gap {HARDLY_A_GAP:g}-3",
             (o.first_right for o in small)),
        rate("truth in the answer set", f"single, gap {HARDLY_A_GAP:g}-3",
             (o.in_set for o in small)),
        rate("right thruster or axis", "single, gap >= 3", (o.detail_right for o in clear)),
        rate("unknown caught", "a line that catches", (o.unknown_right for o in scores)),
        rate("95 % intervals cover the truth", "right answers",
             (one.inside for o in scores for one in o.intervals)),
    ]  # fmt: skip
    for healthy, word in ((True, "with healthy runs"), (False, "without healthy runs")):
        part = [one for one in clear if one.healthy == healthy]
        found.append(rate("right effect first", f"gap >= 3, {word}", (o.first_right for o in part)))
    for vehicle in sorted({one.vehicle for one in clear}):
        part = [one for one in clear if one.vehicle == vehicle]
        found.append(
            rate("right effect first", f"gap >= 3, {vehicle}", (o.first_right for o in part))
        )
    return tuple(found)


def write_page(result: CampaignResult[Score], command: str, page: Path) -> None:
    """Write tables and pictures of the campaign into its part of a page."""
    score = result.score
    write_pictures(page, "second", score.goals, score.confusion)
    cases = page.with_name(f"{page.stem}_second.csv")
    write_csv(cases, [_HEAD, *(_row(line, *_scores([line])) for line in result.lines)])
    text = [
        f"{result.done} cases by the program with the digest {result.code}. Again with",
        "",
        f"    {command}",
        "",
        *goal_table(score.goals),
        "![Rates with their bounds; orange: the goal is missed](images/second-rates.svg)",
        "![Truth against answer](images/second-confusion.svg)",
        "",
        f"Every case: [{cases.name}]({cases.name}).",
    ]
    write_block(page, BLOCK, "A second generator", "\n".join(text))


def _row(line: Mapping[str, Any], score: CaseScore) -> tuple[str, ...]:
    return (
        str(line["number"]),
        score.vehicle,
        "yes" if line["exact"] else "no",
        " ".join([" + ".join(score.truth), line["thruster"] or ""]).strip(),
        f"{score.gap_ratio:.1f}",
        "yes" if score.healthy else "no",
        "refused" if score.refused else " + ".join(score.verdict),
        f"{score.probability:.2f}",
        ", ".join(score.ambiguous_with),
    )


def _scores(lines: Sequence[Mapping[str, Any]]) -> list[CaseScore]:
    return [CaseScore.model_validate_json(json.dumps(line["score"])) for line in lines]


def run_campaign(
    request: CampaignRequest, diagnose: Diagnose = diagnose_files, *, keep: bool = False
) -> CampaignResult[Score]:
    """Run the cases that are not done yet, and score all that are; raises as `run_cases`."""
    code = code_digest("pipeline.diagnose.engine", *module_names())
    return run_cases(
        request,
        {"schema": SCHEMA, "code": code},
        lambda number: run_case(number, request.seed, request.to, diagnose, keep=keep),
        score_of,
        lambda _done, _wanted, line: print(line, flush=True),
    )


def score_of(lines: Sequence[Mapping[str, Any]]) -> Score:
    """Put the lines of a campaign together."""
    scores = _scores(lines)
    return Score(
        cases=len(scores),
        refused=sum(bool(one.refused) for one in scores),
        goals=rates_of(scores),
        rates=(),
        confusion=confusion(scores, lambda one: "+".join(one.verdict)),
    )


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--to", type=Path, required=True)
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--keep-logs", action="store_true")
    parser.add_argument("--page", type=Path, help="page with a place for the result")
    asked = parser.parse_args()
    request = CampaignRequest(
        to=asked.to, cases=asked.cases, seed=asked.seed, resume=asked.resume, processes=1
    )
    try:
        result = run_campaign(request, keep=asked.keep_logs)
        command = (
            f"python -m evaluation.second_generator --cases {asked.cases} --seed {asked.seed} "
            "--to DIR"
        )
        if asked.page is not None:
            write_page(result, command, asked.page)
    except InputError as error:
        raise SystemExit(str(error)) from None
    for one in result.score.goals:
        if one.share is not None:
            goal = f"  (goal {one.goal})" if one.goal else ""
            print(f"{one.stratum}: {one.question}: {one.yes} of {one.cases}{goal}")


if __name__ == "__main__":
    main()
