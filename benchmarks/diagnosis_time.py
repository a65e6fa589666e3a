"""How long a diagnosis takes: by length of the runs, by their number, by the number of candidates.

    python -m benchmarks.diagnosis_time [--vehicle rov8] [--effect quadratic_damping] [--page FILE]

One case of the blind check's truth is diagnosed again and again with less of it. The peer, timed in
the same run, is the usual way: least squares for each effect, ranked by BIC. Every figure is the
shortest of `--rounds` times by the clock, after a first diagnosis that loads the compiled code.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from benchmarks import page
from evaluation.baselines import bic_baseline
from pipeline.blind.generate import CaseSpec, generate
from pipeline.campaign.blind_case import load_subject, packed_of
from pipeline.diagnose.case import Case
from pipeline.diagnose.engine import diagnose
from pipeline.records.run_table import RunTable

LENGTHS_S = (45.0, 90.0, 180.0)
RUNS = (1, 2, 4)
CANDIDATES = (6, 12, 24)
Answer = TypeVar("Answer")
MARKS = ("<!-- diagnosis time -->", "<!-- end of diagnosis time -->")


def shortest(task: Callable[[], Answer], rounds: int) -> tuple[float, Answer]:
    """Return the shortest of some times by the clock, and what the task gave. [s]."""
    taken = []
    for _ in range(rounds):
        began = time.perf_counter()
        given = task()
        taken.append(time.perf_counter() - began)
    return min(taken), given


def cut_short(run: RunTable, seconds: float) -> RunTable:
    """Keep the beginning of a run."""
    kept = run.time_s <= run.time_s[0] + seconds
    return replace(
        run,
        time_s=run.time_s[kept],
        values={name: one[kept] for name, one in run.values.items()},
        valid={name: one[kept] for name, one in run.valid.items()},
        reading={name: one[kept] for name, one in run.reading.items()},
    )


def with_effects(case: Case, count: int, true: str) -> Case:
    """Keep some of the candidates, the true effect among them."""
    names = [true, *(name for name in case.candidates if name != true)][:count]
    return replace(case, effects={name: case.candidates[name] for name in names})


def rows_of(case: Case, true: str, rounds: int) -> list[tuple[str, float, float, str]]:
    """Measure every line of the table: what, seconds, the peer's seconds, verdict."""
    rows = []

    def measure(what: str, one: Case) -> None:
        taken, answer = shortest(lambda: diagnose(one), rounds)
        peer, _ = shortest(lambda: bic_baseline(one.vehicle, one.packed, one.runs), rounds)
        verdict = " + ".join(answer.verdict.effects)
        rows.append((what, taken, peer, verdict))
        print(f"{what}: {taken:.1f} s, peer {peer:.1f} s, {verdict}", flush=True)

    diagnose(replace(case, runs=(cut_short(case.runs[0], LENGTHS_S[0]),)))
    for seconds in LENGTHS_S:
        runs = tuple(cut_short(run, seconds) for run in case.runs)
        measure(f"{len(runs)} runs of {seconds:.0f} s", replace(case, runs=runs))
    for count in RUNS[:-1]:
        measure(f"{count} of 180 s", replace(case, runs=case.runs[:count]))
    for count in CANDIDATES[:-1]:
        measure(f"4 runs of 180 s, {count} candidates", with_effects(case, count, true))
    return rows


def table(rows: Sequence[tuple[str, float, float, str]], count: int) -> str:
    """Write the rows as a table."""
    lines = [
        f"| runs (all {count} candidates, or as said) | s | peer, s | ratio | verdict |",
        "|---|---|---|---|---|",
    ]
    lines += [f"| {w} | {a:.1f} | {b:.1f} | {a / b:.2f} | `{v}` |" for w, a, b, v in rows]
    return "\n".join(lines)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--vehicle", default="rov8")
    parser.add_argument("--effect", default="quadratic_damping")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--raw", type=Path, default=Path("raw"))
    parser.add_argument("--out", type=Path, default=Path())
    parser.add_argument("--page", type=Path, help="page whose table is to be written anew")
    wanted = parser.parse_args()
    subject = load_subject(wanted.vehicle, wanted.raw, wanted.out)
    made = generate(
        subject,
        CaseSpec("single", (wanted.effect,), manoeuvres="trial", healthy=0, seed=77),
    )
    case = Case(
        wanted.vehicle, made.subject.vehicle, packed_of(made.subject), made.runs + made.holdout
    )
    case = replace(case, runs=case.runs[: RUNS[-1]])
    text = table(rows_of(case, wanted.effect, wanted.rounds), len(case.candidates))
    print(text)
    if wanted.page is not None:
        page.update(wanted.page, *MARKS, text)


if __name__ == "__main__":
    main()
