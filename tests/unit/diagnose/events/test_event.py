"""A module let go in flight is found with its time; what goes with the commands is no event."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.case import Case
from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.events.event import ForceEvent, with_events
from pipeline.diagnose.events.force_step import force_step, outside_force
from pipeline.effects.library import apply_effects, candidates, parse_effect
from pipeline.records.run_table import RunTable
from pipeline.simulate.events import PayloadEvent, PayloadSchedule
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

AT_S = 15.0


def flown(
    vehicle: Vehicle,
    packed: PackedVehicle,
    manoeuvre: str,
    *,
    release: str | None = None,
    fault: str | None = None,
) -> RunTable:
    """30 s as the sensors saw it."""
    assert vehicle.model is not None
    assert vehicle.sensors is not None
    vector = packed.vector
    if fault is not None:
        vector = apply_effects(vector, [parse_effect(fault)], packed.context)
    plan = MANOEUVRES[manoeuvre].plan(packed, 1.0, 30.0)
    change = None
    if release is not None:
        change = PayloadSchedule(
            packed, vehicle.model, [PayloadEvent(AT_S, "release", release)]
        ).change
    run = fly(packed, plan, vector=vector, change=change)
    log = measure(run, packed, vehicle.sensors, vector=vector, seed=3)
    return table_of_log(log, vehicle.sensors, name="flight")


@pytest.fixture(scope="module")
def carrier() -> Vehicle:
    return load_vehicle(bundled_vehicle("cargo_carrier"))


@pytest.fixture(scope="module")
def packed(carrier: Vehicle) -> PackedVehicle:
    return pack_vehicle(carrier)


@pytest.fixture(scope="module")
def dropped(carrier: Vehicle, packed: PackedVehicle) -> RunTable:
    return flown(carrier, packed, "straight", release="module_1")


def events_of(
    vehicle: Vehicle, packed: PackedVehicle, run: RunTable
) -> tuple[Case, list[ForceEvent]]:
    case, found = with_events(Case(packed.name, vehicle, packed, (run,)))
    return case, list(found)


def test_a_module_let_go_is_found_with_its_time(
    carrier: Vehicle, packed: PackedVehicle, dropped: RunTable
) -> None:
    case, (event,) = events_of(carrier, packed, dropped)
    assert event.body is not None
    assert event.body.name == "module_1"
    assert event.released
    low, high = event.step.between_s
    assert low <= AT_S <= high
    assert high - low <= 2.0
    (run,) = case.runs
    assert [one.name for one in run.conditions_at(AT_S + 2.0).bodies] == ["module_1"]
    assert run.conditions_at(AT_S - 2.0).as_stated
    # once it is known there is nothing left that sets in
    assert force_step(outside_force(packed, run, carrier.sensors)) is None


def test_without_a_module_in_the_file_the_force_itself_is_told(
    carrier: Vehicle, packed: PackedVehicle, dropped: RunTable
) -> None:
    assert carrier.model is not None
    bare = carrier.model_copy(update={"model": carrier.model.model_copy(update={"payloads": ()})})
    case, (event,) = events_of(bare, packed, dropped)
    assert event.body is None
    # 30 kg that displace 22 l weigh 73.1 N in sea water (r g V = 221.2 N of 294.3 N)
    assert event.step.force[2] == pytest.approx(-73.1, abs=4.0)
    (run,) = case.runs
    assert run.known is not None
    assert run.known.force is not None
    assert np.array_equal(run.known.force[-1], event.step.force)


@pytest.mark.parametrize(
    "fault",
    [
        None,
        "thruster_degraded:thrust_fraction=0.3@front_left",
        "quadratic_damping:surge=2.0",
        "residual_buoyancy:force_n=40",
    ],
)
def test_what_goes_with_motion_and_commands_is_no_event(
    carrier: Vehicle, packed: PackedVehicle, fault: str | None
) -> None:
    """The commands of the run step up in the middle of what is looked at, too."""
    run = flown(carrier, packed, "surge_steps", fault=fault)
    assert events_of(carrier, packed, run)[1] == []


def test_without_attitude_nothing_is_said(
    carrier: Vehicle, packed: PackedVehicle, dropped: RunTable
) -> None:
    values = {name: one for name, one in dropped.values.items() if name != "attitude"}
    assert events_of(carrier, packed, replace(dropped, values=values))[1] == []


def test_the_answer_is_the_event_and_its_time(
    carrier: Vehicle, packed: PackedVehicle, dropped: RunTable
) -> None:
    every = candidates(packed.context)
    few = {name: every[name] for name in ("residual_buoyancy", "thruster_degraded", "payload")}
    record = diagnose(Case(packed.name, carrier, packed, (dropped,), effects=few))
    verdict = record.verdict
    assert verdict.effects == ("payload",)
    assert verdict.from_s == pytest.approx(AT_S, abs=0.5)
    assert verdict.events[0].note == f"events: [{{at_s: {verdict.from_s:.1f}, release: module_1}}]"
    assert verdict.runs == ("flight",)
    assert record.ranking[0].effect == "payload"
    assert record.ranking[0].probability == verdict.probability
    low, high = record.ranking[0].parameters["mass_kg"].ci95
    assert low <= -30.0 <= high
