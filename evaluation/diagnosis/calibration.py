"""Set the thresholds of the diagnosis from generated cases: collect the evidence, then search.

    python -m evaluation.diagnosis.calibration --cases 200 --to DIR
    python -m evaluation.diagnosis.calibration --set --to DIR

The cases come from seeds that no blind check uses. Collecting can be stopped and goes on where it
was; `--set` writes `calibration.json` into the package and says what it changes.
"""

import argparse
import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

from evaluation.diagnosis.threshold_search import (
    Known,
    decided,
    interval_factor,
    search_thresholds,
    total_cost,
)
from pipeline.blind.generate import GeneratedCase
from pipeline.blind.label import open_label
from pipeline.campaign.blind_case import BlindRequest, diagnose_in_memory, run_case
from pipeline.campaign.many_cases import as_they_come
from pipeline.diagnose.conclude.case_evidence import CaseEvidence
from pipeline.diagnose.rules.calibration import Calibration, calibration
from pipeline.provenance import write_atomically
from pipeline.simulate.pack import PackedVehicle
from pipeline.stopping import stopped_by_sigterm

_COMMAND = "python -m evaluation.diagnosis.calibration"


def collect_case(number: int, request: BlindRequest) -> dict[str, Any]:
    """Run one case and keep its evidence beside the verdict."""
    evidence = request.to / "evidence" / f"{number:05d}.json"
    return run_case(number, request, partial(_diagnose, evidence))


def _diagnose(
    file: Path, case: GeneratedCase, packed: PackedVehicle, without: tuple[str, ...]
) -> Mapping[str, Any]:
    file.parent.mkdir(parents=True, exist_ok=True)

    def keep(evidence: CaseEvidence) -> None:
        file.write_text(evidence.model_dump_json(), encoding="utf-8")

    return diagnose_in_memory(case, packed, without, keep)


def collect(first: int, request: BlindRequest) -> None:
    """Run the cases that are not there yet."""
    wanted = [
        number
        for number in range(first, first + request.cases)
        if not (request.to / "lines" / f"{number:05d}.json").exists()
    ]
    (request.to / "lines").mkdir(parents=True, exist_ok=True)
    with stopped_by_sigterm():
        for line in as_they_come(partial(collect_case, request=request), wanted, request.processes):
            file = request.to / "lines" / f"{line['number']:05d}.json"
            write_atomically(file, json.dumps(line))
            score = line.get("score")
            told = line.get("not_made") if score is None else _told(score)
            print(f"case {line['number']}: {told}", flush=True)


def _told(score: Mapping[str, Any]) -> str:
    said = "+".join(score["verdict"])
    if score["ambiguous_with"]:
        said += f" (or {', '.join(score['ambiguous_with'])})"
    return (
        f"{score['vehicle']} {score['kind']} {'+'.join(score['truth'])} at "
        f"{score['gap_ratio']:.1f}: {said} {score['probability']:.2f}, {score['elapsed_s']:.0f} s"
    )


def known_cases(folder: Path) -> list[Known]:
    """Cases whose evidence is there, with their truth."""
    found = []
    for file in sorted((folder / "evidence").glob("*.json")):
        name = f"case_{file.stem}"
        verdict = folder / "verdicts" / name / "diagnosis.json"
        if not verdict.exists():
            continue
        label = open_label(folder / "sealed" / f"{name}.json", verdict)
        evidence = CaseEvidence.model_validate_json(file.read_text(encoding="utf-8"))
        found.append(Known(evidence, label.truth, label.gap_ratio, label.overlaps))
    return found


def misses_of(folder: Path) -> list[float]:
    """Errors of right answers' parameters over the half-widths that the linear model gives."""
    found = []
    for file in sorted((folder / "lines").glob("*.json")):
        evidence = folder / "evidence" / file.name
        score = json.loads(file.read_text(encoding="utf-8")).get("score")
        if score is None or not evidence.exists():
            continue
        factor = CaseEvidence.model_validate_json(evidence.read_text("utf-8")).interval_factor
        found += [factor * one["miss"] for one in score["intervals"]]
    return found


def set_thresholds(folder: Path, *, write: bool) -> Calibration:
    """Search the thresholds, and write them where asked."""
    cases = known_cases(folder)
    before = calibration()
    found, least = search_thresholds(cases, before)
    found = replace(found, interval_factor=interval_factor(misses_of(folder)))
    print(f"{len(cases)} cases: cost {total_cost(cases, before):.1f} -> {least:.1f}")
    numbers = sorted(int(file.stem) for file in (folder / "evidence").glob("*.json"))
    content = asdict(found)
    content.pop("source")
    for name, value in content.items():
        print(f"  {name}: {getattr(before, name)} -> {value}")
    for one in cases:
        said = decided(one.evidence, found)
        if said.names != one.truth:
            truth, names = "+".join(one.truth), "+".join(said.names)
            print(f"  {truth} at {one.gap_ratio:.1f}: {names} or {list(said.ambiguous)}")
    content |= {
        "made_by": f"{_COMMAND} --set",
        "cases": len(cases),
        "seeds": f"{numbers[0]} to {numbers[-1]}" if numbers else "",
    }
    if write:
        target = Path(str(files("pipeline.diagnose.rules").joinpath("calibration.json")))
        write_atomically(target, json.dumps(content, indent=1) + "\n")
    return replace(found, source=f"{len(cases)} generated cases")


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--vehicles", default="mmt300,rov8,cargo_carrier")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--raw", type=Path, default=Path("raw"))
    parser.add_argument("--out", type=Path, default=Path(), help="folder that holds processed/")
    parser.add_argument("--to", type=Path, required=True, help="folder of the cases")
    parser.add_argument("--set", action="store_true", dest="set_them", help="search and write")
    parser.add_argument("--dry", action="store_true", help="search, write nothing")
    given = parser.parse_args()
    if given.set_them or given.dry:
        set_thresholds(given.to, write=given.set_them)
        return
    request = BlindRequest(
        to=given.to,
        cases=given.cases,
        processes=given.processes,
        raw=given.raw,
        out=given.out,
        vehicles=tuple(given.vehicles.split(",")),
        baselines=False,
        calibration=True,
    )
    try:
        collect(given.first, request)
    except KeyboardInterrupt:
        print("stopped; the same command goes on from here")


if __name__ == "__main__":
    main()
