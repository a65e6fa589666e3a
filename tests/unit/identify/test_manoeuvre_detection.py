"""Manoeuvres are recognised by what they are: flown by the simulator, joined, made up."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from evaluation.bundled.mmt300_runs import true_vehicle
from pipeline.identify.manoeuvre_detection import find_manoeuvres
from pipeline.records.run_table import RunTable
from pipeline.records.trial import ManoeuvreFound
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

#: The others are made up below; `python -m benchmarks.manoeuvres` flies all with every vehicle.
IN_OPEN_WATER = (
    *("surge_steps", "surge_ramp", "zig_zag", "pitch_steps"),
    *("multisine", "chirp", "prbs", "free_decay"),
)
#: Those of which a pool makes something else: to and fro, small.
IN_A_POOL = ("straight", "prbs")


@pytest.fixture(scope="module")
def vehicles(repository: Path) -> dict[str, tuple[Vehicle, PackedVehicle]]:
    auv = load_vehicle(repository / "raw" / "mmt300")
    rov = load_vehicle(repository / "pipeline" / "bundled" / "vehicles" / "rov8")
    return {"mmt300": (auv, true_vehicle(auv)), "rov8": (rov, pack_vehicle(rov))}


def flown(
    name: str, vehicles: dict[str, tuple[Vehicle, PackedVehicle]], vehicle: str = "mmt300"
) -> RunTable:
    stated, packed = vehicles[vehicle]
    assert stated.sensors is not None
    manoeuvre = MANOEUVRES[name]
    trajectory = fly(packed, manoeuvre.plan(packed, 1.0, manoeuvre.duration_s))
    log = measure(trajectory, packed, stated.sensors, seed=3)
    return table_of_log(log, stated.sensors, name=name, period_s=0.1)


def code_max(vehicle: Vehicle) -> FloatArray:
    return np.array([vehicle.drives[one.drive].code_max for one in vehicle.thrusters], float)


def check_order(found: tuple[ManoeuvreFound, ...], run: RunTable) -> None:
    assert all(one.to_s > one.from_s for one in found)
    assert all(one.to_s <= other.from_s + 1e-9 for one, other in pairwise(found))
    assert found[0].from_s >= 0.0
    assert found[-1].to_s <= run.time_s[-1] + 1e-9


CASES = [("mmt300", name) for name in IN_OPEN_WATER] + [("rov8", name) for name in IN_A_POOL]


@pytest.mark.parametrize(("vehicle", "name"), CASES)
def test_what_the_simulator_flies_is_recognised(
    vehicle: str, name: str, vehicles: dict[str, tuple[Vehicle, PackedVehicle]]
) -> None:
    run = flown(name, vehicles, vehicle)
    found = find_manoeuvres(run, code_max(vehicles[vehicle][0]))
    check_order(found, run)
    of_it = sum(one.to_s - one.from_s for one in found if one.name == name)
    assert of_it > 0.7 * run.time_s[-1], [(one.name, one.from_s, one.to_s) for one in found]
    assert "mixed" not in {one.name for one in found}
    if name == "surge_ramp" and vehicle == "mmt300":
        assert found[-1].name == "coast_down"
        assert found[-1].from_s == pytest.approx(0.75 * 90.0, abs=2.0)


def made(seconds: float = 60.0, **channels: FloatArray | float) -> RunTable:
    """A run at 10 Hz; heading, pitch [rad], surge, depth and one command as functions of time."""
    time_s = np.arange(0.0, seconds, 0.1)

    def of(name: str) -> FloatArray:
        return np.broadcast_to(np.asarray(channels.get(name, 0.0), float), time_s.shape)

    angles = np.stack([of("heading"), of("pitch"), of("roll")], axis=1)
    x, y, z, w = Rotation.from_euler("ZYX", angles).as_quat().T
    zero = np.zeros_like(time_s)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(time_s.size)
    values = {
        "command": np.stack([of("command"), of("command")], axis=1),
        "attitude": np.stack([w, x, y, z], axis=1),
        "velocity": np.stack([of("surge") + noise, zero, zero], axis=1),
        "depth": (of("depth") + noise)[:, None],
    }
    valid = {name: np.ones(time_s.size, np.bool_) for name in values}
    return RunTable("made up", time_s, values, valid)


TIME_S = np.arange(0.0, 60.0, 0.1)
LIMIT = np.array([100.0, 100.0])


def names(run: RunTable) -> list[str]:
    return [one.name for one in find_manoeuvres(run, LIMIT)]


def test_off_is_idle_coasting_or_decay() -> None:
    assert names(made()) == ["idle"]
    assert names(made(surge=np.exp(-TIME_S / 8.0))) == ["coast_down"]
    swing = 0.3 * np.exp(-TIME_S / 20.0) * np.cos(1.5 * TIME_S)
    assert names(made(roll=swing)) == ["free_decay"]


def test_a_straight_run_and_hovering_are_told_by_the_speed() -> None:
    assert names(made(command=40.0, surge=1.0)) == ["straight"]
    assert names(made(command=40.0)) == ["hover"]
    without = made(command=40.0)
    del without.values["velocity"], without.valid["velocity"]
    (only,) = find_manoeuvres(without, LIMIT)
    assert only.name == "hover"
    assert "speed was not measured" in only.sentence


def test_parts_of_a_run_are_told_apart() -> None:
    """Rest, then steps of depth, then a turn; the edges within some seconds."""
    time_s = np.arange(0.0, 200.0, 0.1)
    command = np.where(time_s < 20.0, 0.0, 40.0)
    depth = np.zeros_like(time_s)
    for begin, size in ((30.0, 1.0), (50.0, -1.0), (70.0, 0.5)):
        depth += size * np.clip((time_s - begin) / 5.0, 0.0, 1.0)
    surge = np.clip((time_s - 100.0) / 10.0, 0.0, 1.0)
    heading = np.radians(9.0) * np.clip(time_s - 130.0, 0.0, 60.0)
    run = made(200.0, command=command, depth=depth, surge=surge, heading=heading)
    found = find_manoeuvres(run, LIMIT)
    check_order(found, run)
    told = [one.name for one in found]
    assert told[:2] == ["idle", "heave_steps"]
    assert told[-1] == "circle"
    assert "straight" in told
    assert found[0].to_s == pytest.approx(20.0, abs=0.3)
    steps, circle = found[1], found[-1]
    assert steps.to_s == pytest.approx(87.0, abs=6.0)
    assert circle.from_s == pytest.approx(118.0, abs=6.0)
    assert "540 deg to starboard" in circle.sentence


def test_heading_steps_at_rest_are_no_zig_zag() -> None:
    heading = 0.4 * np.sign(np.sin(2 * np.pi * TIME_S / 20.0))
    assert names(made(command=40.0, heading=heading)) == ["heading_steps"]
    assert names(made(command=40.0, heading=heading, surge=1.0)) == ["zig_zag"]


def test_a_turn_each_way_is_a_spiral_one_way_a_circle() -> None:
    rate = np.where(TIME_S < 30.0, 0.2, -0.2)
    there_and_back = 0.1 * np.cumsum(rate)
    assert names(made(command=40.0, heading=there_and_back, surge=1.0)) == ["spiral"]
    assert names(made(command=40.0, heading=-0.2 * TIME_S, surge=1.0)) == ["circle"]


def test_a_run_without_commands_or_of_no_length_says_nothing() -> None:
    run = made()
    values = {name: column for name, column in run.values.items() if name != "command"}
    assert find_manoeuvres(replace(run, values=values)) == ()
    assert find_manoeuvres(made(2.0)) == ()


def test_gaps_are_bridged() -> None:
    run = made(command=40.0, surge=1.0)
    run.values["velocity"][200:230] = np.nan
    run.valid["velocity"][200:230] = False
    assert names(run) == ["straight"]
