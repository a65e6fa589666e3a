"""The blind check on generated cases: each made, sealed, diagnosed, opened, scored."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.blind.cases import RUN_S, case_of
from pipeline.blind.generate import GeneratedCase, generate
from pipeline.blind.label import seal
from pipeline.blind.score import CampaignScore, score_campaign
from pipeline.blind.subject import BlindSubject, subject_from
from pipeline.blind.truth.sensors import Log as TrueLog
from pipeline.blind.verdict_score import CaseScore, score_case
from pipeline.campaign.campaign import (
    CampaignRequest,
    CampaignResult,
    Said,
    diagnosed,
    judged,
    run_cases,
)
from pipeline.effects.library import candidates, module_names
from pipeline.errors import CannotComputeError
from pipeline.export.mcap_log import write_run_log
from pipeline.inputs.simulated_vehicle import bench_result
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.provenance import code_digest
from pipeline.records.fits import StaticCharacteristic
from pipeline.simulate.context import BenchModel
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.sensors import Channel, Log
from pipeline.vehicle.load import VEHICLE_FILE, load_vehicle
from pipeline.vehicle.schema import Vehicle

SCHEMA = "rig2sea/blind/1"
#: Vehicles of a campaign that names none.
USUAL = ("mmt300", "rov8", "cargo_carrier")
#: From a case, as an engineer would have it, and the effects that are left out of the library, to
#: the content of ``diagnosis.json``.
Diagnose = Callable[[GeneratedCase, PackedVehicle, tuple[str, ...]], Mapping[str, Any]]


@dataclass(frozen=True, kw_only=True)
class BlindRequest(CampaignRequest):
    """A campaign of generated cases: where its vehicles come from, and what each case is."""

    raw: Path = Path("raw")
    out: Path = Path()
    vehicles: tuple[str, ...] = USUAL
    keep_logs: bool = False
    run_s: float = RUN_S


@cache
def subjects_of(names: tuple[str, ...], raw: Path, out: Path) -> dict[str, BlindSubject]:
    """Vehicles of a campaign by name, read once a process."""
    return {one.name: one for one in (load_subject(name, raw, out) for name in names)}


def load_subject(text: str, raw: Path, out: Path) -> BlindSubject:
    """Find a vehicle by name or path and read it, with the bench's family where it needs one."""
    name, file = find_vehicle(text, raw, out)
    model = load_vehicle(file).model
    drives = () if model is None else model.thrusters.values()
    static: StaticCharacteristic | None = None
    if any(one.characteristic.kind == "tables" for one in drives):
        static, _ = bench_result(name, out, "static", StaticCharacteristic)
    return subject_from(file, static)


def packed_of(subject: BlindSubject) -> PackedVehicle:
    """Pack a case's vehicle file for the simulation that the diagnosis fits."""
    bench = BenchModel(subject.static) if subject.static is not None else None
    return pack_vehicle(subject.vehicle, bench)


def diagnose_in_memory(
    case: GeneratedCase,
    packed: PackedVehicle,
    without: tuple[str, ...],
) -> Mapping[str, Any]:
    """Diagnose a case's tables."""
    from pipeline.diagnose.case import Case

    library = {
        name: effect for name, effect in candidates(packed.context).items() if name not in without
    }
    asked = Case(
        name=case.subject.name,
        vehicle=case.subject.vehicle,
        packed=packed,
        runs=case.runs,
        holdout=case.holdout,
        healthy=case.healthy,
        effects=library,
    )
    return diagnosed(asked)


def run_case(
    number: int, request: BlindRequest, diagnose: Diagnose = diagnose_in_memory
) -> dict[str, Any]:
    """Run one case and return its line: ``number`` and either ``score`` or ``not_made``."""
    subjects = subjects_of(request.vehicles, request.raw, request.out)
    numbered = case_of(number, subjects, request.seed, run_s=request.run_s)
    name, spec = numbered.name, numbered.spec
    try:
        case = generate(subjects[numbered.vehicle], spec)
    except CannotComputeError as error:
        return {"number": number, "not_made": str(error), "what": list(spec.what)}
    sealed = request.to / "sealed" / f"{name}.json"
    if request.keep_logs:
        write_case(case, name, request.to / "cases", sealed.parent)
    else:
        seal(case.label, sealed)
    packed = packed_of(case.subject)
    without = spec.what if spec.kind == "leave_one_out" else ()
    label, content, elapsed_s = judged(sealed, lambda: diagnose(case, packed, without))
    score = score_case(name, label, content, elapsed_s=elapsed_s)
    return {"number": number, "score": score.model_dump(mode="json")}


def run_campaign(
    request: BlindRequest, said: Said = lambda *_: None
) -> CampaignResult[CampaignScore]:
    """Run the cases that are not done yet, and score all that are; raises as `run_cases`."""
    # a vehicle that cannot be read is found before any case is made
    subjects_of(request.vehicles, request.raw, request.out)
    header = {
        "schema": SCHEMA,
        "vehicles": list(request.vehicles),
        "run_s": request.run_s,
        "code": code_digest(__name__, *module_names()),
    }
    return run_cases(request, header, partial(run_case, request=request), scored, said)


def scored(lines: Sequence[Mapping[str, Any]]) -> CampaignScore:
    """Score the lines of a campaign."""
    return score_campaign(
        [CaseScore.model_validate_json(json.dumps(line["score"])) for line in lines]
    )


#: Instrument of the truth -> what its columns are called in a log.
_COLUMNS = {
    "imu": (
        *("p_radps", "q_radps", "r_radps", "fx_mps2", "fy_mps2", "fz_mps2"),
        *("qw", "qx", "qy", "qz"),
    ),
    "dvl": ("vx_mps", "vy_mps", "vz_mps"),
    "depth": ("depth_m",),
    "position": ("north_m", "east_m", "down_m"),
    "voltage": ("supply_v",),
}


def write_case(case: GeneratedCase, name: str, folder: Path, sealed: Path) -> None:
    """Write a case to disk: what an engineer would have, and the sealed label elsewhere.

    ``<name>/vehicle.yaml`` and ``<name>/pool/*.mcap`` go to `folder`, ``<name>.json`` to `sealed`.
    """
    here, vehicle = folder / name, case.subject.vehicle
    (here / "pool").mkdir(parents=True, exist_ok=True)
    (here / VEHICLE_FILE).write_text(case.subject.text, encoding="utf-8")
    for table in (*case.runs, *case.holdout, *case.healthy):
        write_run_log(
            here / "pool" / f"{table.name}.mcap",
            _channels(case.logs[table.name], vehicle),
            vehicle_name=vehicle.name,
            density_kgpm3=vehicle.water.density_kgpm3,
            gravity_mps2=vehicle.water.gravity_mps2,
            start_time_ns=table.start_time_ns,
        )
    seal(case.label, sealed / f"{name}.json")


def _channels(log: TrueLog, vehicle: Vehicle) -> Log:
    """Name the columns of what the truth's instruments read, the DVL's in its own axes."""
    from scipy.spatial.transform import Rotation

    thrusters = tuple(one.name for one in vehicle.thrusters)
    found: Log = {}
    for instrument, reading in log.items():
        values = reading.values
        if instrument == "dvl":
            dvl = vehicle.sensors.dvl if vehicle.sensors is not None else None
            turn = dvl.rotation_deg if dvl is not None else (0.0, 0.0, 0.0)
            values = Rotation.from_euler("ZYX", np.radians(turn)[::-1]).inv().apply(values)
        columns = _COLUMNS.get(instrument, thrusters)
        found[instrument] = Channel(columns, reading.stamp_s, reading.logged_s, values)
    return found
