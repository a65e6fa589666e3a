"""Diagnose measured runs: as they are, and with an effect injected that the diagnosis is not told.

    python -m pipeline.stages.measured_withheld --data ../shared/data --to measured_withheld
    python -m pipeline.stages.measured_withheld --data ../shared/data --to measured_withheld --table

One line a case in ``cases.jsonl``, a table in ``table.md``. A campaign that was stopped goes on
where it was. The nominal model is identified first, from runs that take no other part. Run it in
the project's folder: vehicle files and the converter of the tank runs are found there.
"""

import argparse
import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pipeline.diagnose.engine import diagnose
from pipeline.errors import CannotComputeError, Rig2SeaError
from pipeline.identify.file_changes import file_changes
from pipeline.plan import VEHICLE_FILE
from pipeline.provenance import write_atomically
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.records.identification import Identification, VehicleIdentification
from pipeline.simulate.context import model_of
from pipeline.stages.identification import RESULT_FILE, IdentificationRequest, identify_runs
from pipeline.stages.measured_withheld_cases import (
    Fold,
    WithheldCase,
    all_cases,
)
from pipeline.stages.measured_withheld_runs import case_to_diagnose, logs_named, logs_of
from pipeline.stages.measured_withheld_table import table, with_table
from pipeline.stages.result_lines import appending, read_lines
from pipeline.stages.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.write_back import updated_vehicle_text

#: Vehicle file of each subject.
VEHICLES = {"tank": "brov2_tank", "pool": "exjobbrov"}
#: Uncertainty of the thrust during the identification. [1]
_TRUSTED = 0.02
_NOISE_KEYS = {
    "angular_velocity": ("imu", "rate_noise_radps"),
    "attitude": ("imu", "attitude_noise_rad"),
    "velocity": ("dvl", "noise_mps"),
    "position": ("position", "noise_m"),
    "depth": ("depth", "noise_m"),
}
CASES_FILE, TABLE_FILE = "cases.jsonl", "table.md"


def identified(stated: Path, fold: Fold, logs: Sequence[Path], folder: Path) -> SimulatedVehicle:
    """Identify the nominal model of a fold, once, and read it back.

    A vehicle file has no place for a factor of each thruster, so the thrust is taken as stated:
    added mass, damping and trim are fitted to it.
    """
    place = folder / "-".join(("fit", *(name[-5:] for name in fold.fit)))
    file = place / VEHICLE_FILE
    if not file.is_file():
        text = (stated / VEHICLE_FILE).read_text(encoding="utf-8")
        if not (place / RESULT_FILE).is_file():
            trusted = updated_vehicle_text(text, {"model.uncertainty.thrust": _TRUSTED}, "")
            write_atomically(place / "stated" / VEHICLE_FILE, trusted)
            identify_runs(
                IdentificationRequest(
                    str(place / "stated"),
                    tuple(str(path) for path in logs_named(fold.fit, logs)),
                    method="whole-vehicle",
                    to=place,
                    suggest=False,
                    threads=1,
                )
            )
        told = (place / RESULT_FILE).read_text(encoding="utf-8")
        found = Identification.model_validate_json(told).whole_vehicle
        if found is None:
            raise CannotComputeError(f"{place}: nothing was identified, see {RESULT_FILE}")
        vehicle = load_vehicle(stated)
        changes, _ = file_changes(vehicle, model_of(vehicle), found.parameters)
        changes |= noise_changes(vehicle, found)
        settled = "settled" if found.converged else "did not settle, and is used as it stands"
        note = f"Identified from {', '.join(fold.fit)}; the fit {settled}."
        write_atomically(file, updated_vehicle_text(text, changes, note))
    return load_simulated(str(place), Path("raw"), Path())


def noise_changes(vehicle: Vehicle, found: VehicleIdentification) -> dict[str, float]:
    """State the noise of each channel as the identified model leaves it, where that is more.

    The stated figures are those of a reading by itself. What the readings of these runs differ from
    any smooth motion by (means over 0.2 s in a tumbling vehicle, times that are off) is in the
    errors of the prediction on windows that took no part; half of them is taken.
    """
    sensors = vehicle.sensors.model_dump() if vehicle.sensors is not None else {}
    changes = {}
    for one in found.quality:
        sensor, key = _NOISE_KEYS.get(one.channel, ("", ""))
        stated = (sensors.get(sensor) or {}).get(key)
        if stated is not None and one.rmse_identified is not None:
            changes[f"sensors.{sensor}.{key}"] = max(float(stated), 0.5 * one.rmse_identified)
    return changes


def line_of(case: WithheldCase, one: SimulatedVehicle, logs: Sequence[Path]) -> dict[str, Any]:
    """Diagnose a case; the line of the result file."""
    truth = case.injection.truth
    head: dict[str, Any] = {
        "case": case.key,
        "subject": case.subject,
        "fold": case.fold.name,
        "injected": case.injection.name,
        "truth": truth,
        "thruster": case.injection.target,
        "value": case.injection.value,
        "healthy": case.healthy,
        "hidden": list(case.hidden),
    }
    began = time.perf_counter()
    try:
        record = diagnose(case_to_diagnose(case, one, logs), threads=1)
    except Rig2SeaError as error:
        return head | {"refused": str(error), "elapsed_s": time.perf_counter() - began}
    return head | _told(record, truth) | {"elapsed_s": time.perf_counter() - began}


def _told(record: DiagnosisRecord, truth: str | None) -> dict[str, Any]:
    wanted = "none" if truth is None else truth
    names = [row.effect for row in record.ranking]
    holding = [row for row in record.ranking if wanted in row.effect.split("+")]
    alone = next((row for row in record.ranking if row.effect == wanted), None)
    if wanted in record.verdict.effects:
        # as it stands in the answer, be it beside `unknown`
        alone = holding[0]
    return {
        "runs": list(record.runs),
        "verdict": record.verdict.model_dump(mode="json"),
        "rank": names.index(alone.effect) + 1 if alone is not None else None,
        "probability_of_truth": sum(row.probability for row in holding),
        "found": None if alone is None else alone.model_dump(mode="json"),
        "ranking": [
            row.model_dump(mode="json", include={"effect", "probability", "thruster", "gap_closed"})
            for row in record.ranking[:6]
        ],
        "shrink": record.shrink.model_dump(mode="json", exclude={"channels"}),
        "ratios": {name: one.ratio for name, one in record.gap.channels.items()},
        "leftover": record.leftover.model_dump(mode="json"),
        "force_scale": record.evidence.force_scale,
        "noise": {name: one.variance for name, one in record.evidence.noise.items()},
        "next_run": None if record.next_run is None else record.next_run.model_dump(mode="json"),
        "notes": list(record.notes),
    }


def run_campaign(cases: Sequence[WithheldCase], data: Path, to: Path, vehicles: Path) -> None:
    """Run the cases that the result file does not hold yet, and append a line for each."""
    file = to / CASES_FILE
    known = {line["case"] for line in read_lines(file)}
    converter = vehicles.parent.parent / "docs/examples/brov2_tank_to_mcap.py"
    with appending(file) as append:
        for case in cases:
            if case.key in known:
                continue
            logs = logs_of(case.subject, data, to, converter)
            one = identified(vehicles / VEHICLES[case.subject], case.fold, logs, to / case.subject)
            line = line_of(case, one, logs)
            append(line)
            answer = line["verdict"]["effects"] if "verdict" in line else "refused"
            print(f"{case.key}: {answer}, {line['elapsed_s']:.0f} s", flush=True)


def main() -> None:
    """Run the command."""
    # linear algebra is not to start threads on top of the simulations
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--to", type=Path, default=Path("measured_withheld"))
    parser.add_argument("--vehicles", type=Path, default=Path("tests/acceptance"))
    parser.add_argument(
        "--only", nargs="*", default=[""], help="cases whose name holds one of these"
    )
    parser.add_argument("--table", action="store_true", help="write the table and stop")
    parser.add_argument("--page", type=Path, help="page whose table is to be written anew, too")
    wanted = parser.parse_args()
    cases = [case for case in all_cases() if any(text in case.key for text in wanted.only)]
    wanted.to.mkdir(parents=True, exist_ok=True)
    if not wanted.table:
        run_campaign(cases, wanted.data, wanted.to, wanted.vehicles)
    text = table(read_lines(wanted.to / CASES_FILE), len(all_cases()))
    write_atomically(wanted.to / TABLE_FILE, text)
    if wanted.page is not None:
        write_atomically(wanted.page, with_table(wanted.page.read_text(encoding="utf-8"), text))
    print(text)


if __name__ == "__main__":
    main()
