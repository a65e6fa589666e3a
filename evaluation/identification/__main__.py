"""Run the coverage campaign of the identification: many seeds, one line each, stoppable.

    python -m evaluation.identification mmt300 --seeds 300 --to coverage.jsonl
    python -m evaluation.identification --summary coverage.jsonl

A campaign that was stopped goes on where it was; what a seed is made of depends on nothing but its
number. The table names the seeds, so that a part of them can be run and shown too.
"""

import argparse
from functools import partial
from pathlib import Path

from evaluation.identification.coverage import EXCITING, RUN_S, Campaign, one_seed, table
from pipeline.campaign.campaign import appending, as_they_come, read_lines
from pipeline.inputs.simulated_vehicle import load_simulated
from pipeline.stopping import stopped_by_sigterm


def load_campaign(
    vehicle: str,
    raw: Path,
    out: Path,
    *,
    manoeuvres: tuple[str, ...],
    run_s: float,
    thrust: bool = True,
) -> Campaign:
    """Read the vehicle and what the bench gave of it."""
    one = load_simulated(vehicle, raw, out)
    return Campaign(one.vehicle, one.packed, manoeuvres, run_s, thrust)


def run_campaign(campaign: Campaign, file: Path, *, first: int, seeds: int, workers: int) -> None:
    """Run the seeds that the file does not hold yet, and append a line for each."""
    known = {line["seed"] for line in read_lines(file)}
    wanted = [seed for seed in range(first, first + seeds) if seed not in known]
    with appending(file) as append, stopped_by_sigterm():
        for line in as_they_come(partial(one_seed, campaign), wanted, workers):
            append(line)
            print(f"seed {line['seed']}: {line['elapsed_s']:.1f} s", flush=True)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        prog="python -m evaluation.identification", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("vehicle", nargs="?", default="mmt300", help="name, folder or bundled")
    parser.add_argument("--manoeuvres", default=",".join(EXCITING))
    parser.add_argument("--run-s", type=float, default=RUN_S, help="length of each run")
    parser.add_argument("--seeds", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument(
        "--exact-thrust", action="store_true", help="fly with the thrust as the bench says"
    )
    parser.add_argument("--raw", type=Path, default=Path("raw"))
    parser.add_argument("--out", type=Path, default=Path(), help="folder that holds processed/")
    parser.add_argument("--to", type=Path, help="result file, one line a seed")
    parser.add_argument("--summary", type=Path, help="show the table of a result file and stop")
    wanted = parser.parse_args()
    if wanted.summary is not None:
        print(table(read_lines(wanted.summary)))
        return
    campaign = load_campaign(
        wanted.vehicle,
        wanted.raw,
        wanted.out,
        manoeuvres=tuple(wanted.manoeuvres.split(",")),
        run_s=wanted.run_s,
        thrust=not wanted.exact_thrust,
    )
    file = wanted.to or Path(f"coverage-{campaign.packed.name}.jsonl")
    try:
        run_campaign(campaign, file, first=wanted.first, seeds=wanted.seeds, workers=wanted.workers)
    except KeyboardInterrupt:
        print("stopped; the same command goes on from here")
    print(table(read_lines(file)))


if __name__ == "__main__":
    main()
