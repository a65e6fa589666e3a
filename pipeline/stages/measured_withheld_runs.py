"""What the diagnosis of a measured case gets: runs and model, with what is withheld in them."""

import runpy
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.errors import CannotComputeError
from pipeline.ingest.pool_run import read_pool_run, resample
from pipeline.physics.parameters import read
from pipeline.records.run_table import RunTable
from pipeline.simulate.context import model_of
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.stages.measured_withheld_cases import WEAK, Injection, WithheldCase
from pipeline.stages.runs_to_identify import RATE_HZ, read_run
from pipeline.stages.simulated_vehicle import SimulatedVehicle
from pipeline.vehicle.schema import Vehicle

#: Data folder of each subject.
DATA = {"tank": "brov2_tank_mocap", "pool": "exjobbrov_pool"}


def logs_of(subject: str, data: Path, to: Path, converter: Path) -> list[Path]:
    """Find the logs of a subject; the tank runs are converted first."""
    source = data / DATA[subject]
    if subject == "tank":
        folder = to / "tank_logs"
        if not list((folder / "pool").glob("*.mcap")):
            runpy.run_path(str(converter))["main"]([str(source), "--to", str(folder)])
        source = folder / "pool"
    found = sorted(source.glob("*.mcap"))
    if not found:
        raise CannotComputeError(f"{source} holds no logs (*.mcap)")
    return found


def logs_named(names: Sequence[str], logs: Iterable[Path]) -> list[Path]:
    """Return the logs whose names begin so, one for each name.

    Raises
    ------
    CannotComputeError
        When a name fits none, or more than one.
    """
    every, found = list(logs), []
    for name in names:
        fitting = [path for path in every if path.stem.startswith(name)]
        if len(fitting) != 1:
            raise CannotComputeError(f"{len(fitting)} logs begin with {name}; one was expected")
        found += fitting
    return found


def altered_model(one: SimulatedVehicle, injection: Injection) -> tuple[Vehicle, PackedVehicle]:
    """Return the vehicle and its model with what the injection does to the model."""
    vehicle, packed = one.vehicle, one.packed
    if injection.lighter_kg > 0.0:
        model = model_of(vehicle)
        body = model.rigid_body
        body = body.model_copy(update={"mass_kg": body.mass_kg - injection.lighter_kg})
        vehicle = vehicle.model_copy(
            update={"model": model.model_copy(update={"rigid_body": body})}
        )
        packed = pack_vehicle(vehicle)
    if injection.model:
        specs = [parse_effect(text, packed.thruster_names) for text in injection.model]
        packed = replace(packed, vector=apply_effects(packed.vector, specs, packed.context))
    return vehicle, packed


def altered_run(
    path: Path, one: SimulatedVehicle, raw: Path, case: WithheldCase, *, inject: bool
) -> RunTable:
    """Read a log as the diagnosis does, with what the case does to its readings."""
    _, table_ = read_run(path, one, raw, [name for name in case.hidden if name != "command"])
    if inject and (case.injection.scale != 1.0 or case.injection.delay_s > 0.0):
        table_ = _wrong_velocity(table_, path, one, raw, case.injection)
    if inject and case.injection.raised is not None:
        table_ = _raised_codes(table_, one.packed, case.injection.raised)
    if "command" in case.hidden:
        table_ = replace(table_, values={k: v for k, v in table_.values.items() if k != "command"})
    if inject and case.most_s is not None:
        table_ = _cut(table_, case.most_s)
    return table_


def _wrong_velocity(
    table_: RunTable, path: Path, one: SimulatedVehicle, raw: Path, injection: Injection
) -> RunTable:
    """Replace the velocity by what a wrong instrument gives: readings scaled, stamped late."""
    run = read_pool_run(path, one.vehicle, raw.resolve())
    channel = run.channels["velocity"]
    channel = replace(
        channel,
        values=injection.scale * channel.values,
        time_ns=channel.time_ns + round(1e9 * injection.delay_s),
    )
    begin, step = table_.start_time_ns, round(1e9 / RATE_HZ)
    wrong = resample(
        replace(run, channels={"velocity": channel}),
        RATE_HZ,
        quantities=("velocity",),
        begin_ns=begin,
        end_ns=begin + step * (table_.time_s.size - 1),
    )
    count = table_.time_s.size

    def put(into: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
        return into | {"velocity": part["velocity"][:count]}

    return replace(
        table_,
        values=put(table_.values, wrong.values),
        valid=put(table_.valid, wrong.valid),
        reading=put(table_.reading, wrong.reading),
        off_row={name: off for name, off in table_.off_row.items() if name != "velocity"}
        | {name: off.rows(slice(count)) for name, off in wrong.off_row.items()},
    )


def _raised_codes(table_: RunTable, packed: PackedVehicle, thruster: str) -> RunTable:
    """Raise a thruster's codes until the model's thrust at rest is what acted over `WEAK`."""
    i = packed.thruster_names.index(thruster)
    kind = int(read(packed.vector, "thruster_type")[i])
    codes = table_.values["command"].copy()
    own, low_high = codes[:, i], packed.code_limits[i]
    for side, sign in ((0, 1.0), (1, -1.0)):
        curve = packed.thrust_tables[kind, side, 0]
        every = packed.steps[kind, 1] * np.arange(curve.size)
        live = curve > 0.0
        here = sign * own > 0.0
        acted = np.interp(np.abs(own[here]), every, curve)
        wanted = np.interp(acted / WEAK, curve[live], every[live])
        own[here] = np.where(acted > 0.0, sign * wanted, own[here])
    codes[:, i] = np.clip(own, *low_high)
    return replace(table_, values=table_.values | {"command": codes})


def _cut(table_: RunTable, seconds: float) -> RunTable:
    kept = table_.time_s <= seconds

    def cut(part: dict[str, Any]) -> dict[str, Any]:
        return {name: values[kept] for name, values in part.items()}

    return replace(
        table_,
        time_s=table_.time_s[kept],
        values=cut(table_.values),
        valid=cut(table_.valid),
        reading=cut(table_.reading),
        off_row={name: off.rows(kept) for name, off in table_.off_row.items()},
    )


def case_to_diagnose(case: WithheldCase, one: SimulatedVehicle, logs: Sequence[Path]) -> Case:
    """Put together what the diagnosis gets: nothing in it says what was injected."""
    vehicle, packed = altered_model(one, case.injection)
    raw = logs[0].parent.parent
    runs, healthy = (
        tuple(altered_run(path, one, raw, case, inject=inject) for path in logs_named(names, logs))
        for names, inject in (
            (case.fold.runs, True),
            (case.fold.healthy if case.healthy else (), False),
        )
    )
    return Case(vehicle.name, vehicle, packed, runs, (), healthy)
