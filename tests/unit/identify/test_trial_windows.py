"""A run that was simulated is predicted to the noise of its sensors; a wrong model is not."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled

from pipeline.errors import CannotComputeError
from pipeline.identify.day_choice import choose_stretches
from pipeline.identify.trial_errors import compared, predicted_table, trial_warnings
from pipeline.identify.trial_windows import TrialFlights, fly_trial
from pipeline.physics.parameters import read, write
from pipeline.records.run_table import RunTable, difference
from pipeline.records.trial import ChannelError, RunTrial
from pipeline.simulate.applied_wrench import actuator_states
from pipeline.simulate.fly import fly
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import run
from pipeline.simulate.sensors import measure
from pipeline.vehicle.sensor_schema import Sensors

DURATION_S = 36.0


@pytest.fixture(scope="module")
def rov(repository: Path) -> tuple[PackedVehicle, Sensors]:
    vehicle = bundled(repository, "rov8")
    assert vehicle.sensors is not None
    return pack_vehicle(vehicle, None), vehicle.sensors


@pytest.fixture(scope="module")
def table(rov: tuple[PackedVehicle, Sensors]) -> RunTable:
    packed, sensors = rov
    flown = fly(packed, MANOEUVRES["heave_steps"].plan(packed, 1.0, DURATION_S))
    found = table_of_log(measure(flown, packed, sensors, seed=3), sensors, name="steps")
    return replace(found, thrusters=packed.thruster_names)


def errors(
    packed: PackedVehicle, sensors: Sensors, table: RunTable
) -> tuple[TrialFlights, dict[str, ChannelError]]:
    flights = fly_trial(packed, sensors, table, threads=1)
    windows = predicted_table(packed, sensors, table, flights)
    found = compared(sensors, table, windows, flights)
    return flights, {one.channel: one for one in found}


@pytest.fixture(scope="module")
def right(
    rov: tuple[PackedVehicle, Sensors], table: RunTable
) -> tuple[TrialFlights, dict[str, ChannelError]]:
    return errors(*rov, table)


def test_right_model_predicts_to_the_noise(
    right: tuple[TrialFlights, dict[str, ChannelError]],
) -> None:
    flights, found = right
    assert (flights.windows, flights.left_out) == (4, 0)
    for name in ("u", "v", "w", "q", "r", "depth", "down", "supply"):
        over = found[name].over_noise
        assert over is not None
        # the start takes up the offset that is part of the depth sensor's noise
        assert 0.2 < over < 1.5, name
        assert not found[name].loses, name
    held = found["down"].rmse_last_value
    assert held is not None
    assert held > 10 * found["down"].rmse_windows, "the vehicle dives, so holding must lose"


def test_windows_cover_the_run_once(
    rov: tuple[PackedVehicle, Sensors],
    table: RunTable,
    right: tuple[TrialFlights, dict[str, ChannelError]],
) -> None:
    flights = right[0]
    covered = table.time_s[flights.valid]
    assert covered[0] == pytest.approx(flights.lead_s)
    assert covered[-1] == pytest.approx(table.time_s[-1])
    assert np.diff(covered).max() == pytest.approx(0.02)
    heave = predicted_table(*rov, table, flights).values["velocity"][:, 2]
    assert np.isnan(heave[: round(flights.lead_s / 0.02) - 1]).all()


def test_wrong_damping_shows_in_the_channel_that_it_acts_on(
    rov: tuple[PackedVehicle, Sensors],
    table: RunTable,
    right: tuple[TrialFlights, dict[str, ChannelError]],
) -> None:
    packed, sensors = rov
    vector = packed.vector.copy()
    damping = np.array(read(vector, "quadratic_damping"))
    damping[2] *= 10.0
    write(vector, "quadratic_damping", damping)
    _, wrong = errors(replace(packed, vector=vector), sensors, table)
    assert wrong["w"].rmse_windows > 3 * right[1]["w"].rmse_windows
    assert wrong["u"].rmse_windows < 1.5 * right[1]["u"].rmse_windows


def test_gap_in_the_commands_costs_its_windows_alone(
    rov: tuple[PackedVehicle, Sensors], table: RunTable
) -> None:
    there = table.valid["command"].copy()
    there[700:720] = False
    values = {**table.values, "command": np.where(there[:, None], table.values["command"], np.nan)}
    holed = replace(table, values=values, valid={**table.valid, "command": there})
    flights, found = errors(*rov, holed)
    assert (flights.windows, flights.left_out) == (5, 0)
    covered = flights.valid
    assert not covered[701:720].any(), "the last command known leads to the row after it"
    assert not covered[720:750].any(), "a new start is estimated after the gap"
    assert covered[750:].all()
    assert covered[30:701].all()
    assert found["w"].over_noise == pytest.approx(1.0, abs=0.4)


def test_run_without_commands_or_motion_is_refused(
    rov: tuple[PackedVehicle, Sensors], table: RunTable
) -> None:
    def without(*names: str) -> RunTable:
        return replace(table, values={k: v for k, v in table.values.items() if k not in names})

    with pytest.raises(CannotComputeError, match="no commands"):
        fly_trial(*rov, without("command"))
    motion = [name for name in table.values if name not in ("command", "voltage")]
    with pytest.raises(CannotComputeError, match="nothing to compare"):
        fly_trial(*rov, without(*motion))
    with pytest.raises(CannotComputeError, match="too short"):
        fly_trial(*rov, table.rows(0, 60))


def test_angles_differ_by_the_shorter_way() -> None:
    gap = difference("attitude", np.array([[0.0, 0.0, 3.1]]), np.array([[0.0, 0.0, -3.1]]))
    assert gap[0, 2] == pytest.approx(6.2 - 2 * np.pi)
    assert difference("depth", np.array([[7.0]]), np.array([[1.0]]))[0, 0] == 6.0


def channel(**more: float | None) -> ChannelError:
    values: dict[str, object] = {
        "channel": "u", "quantity": "velocity", "unit": "m/s", "readings": 9, "sensor_noise": 0.01,
        "rmse_windows": 0.05, "mean_windows": 0.0, "worst_windows": 0.1, "worst_at_s": 1.0,
        "rmse_last_value": 0.04,
    }  # fmt: skip
    return ChannelError.model_validate({**values, **more})


def test_losing_against_the_last_value_is_a_warning_unless_it_is_noise() -> None:
    assert channel().loses
    assert not channel(rmse_last_value=0.06).loses
    assert not channel(sensor_noise=0.03).loses
    assert channel(sensor_noise=None).loses
    trial = RunTrial(
        vehicle="a", run="r", day="", start_time_ns=0, duration_s=1.0, horizon_s=10.0, windows=3,
        windows_left_out=1, channels=(channel(),), commands_at_limit={"up": 0.5, "down": 0.1},
    )  # fmt: skip
    first, second, third = trial_warnings(trial)
    assert "predicts velocity (u) worse" in first
    assert second.startswith("1 of 4 windows")
    assert third == "Thruster up is at the end of its range for 50% of the time."


def test_exciting_stretches_are_chosen_within_the_time() -> None:
    time_s = np.arange(0.0, 200.0, 0.02)
    busy = np.where(time_s < 100.0, 5.0, 50.0)[:, None] * np.sin(time_s)[:, None]

    def run(name: str, command: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> RunTable:
        there = np.ones(time_s.size, bool)
        values = {"command": command, "depth": np.zeros((time_s.size, 1))}
        return RunTable(name, time_s, values, {"command": there, "depth": there})

    runs = [run("busy", busy), run("still", np.ones_like(busy))]
    tables, used, passed = choose_stretches(runs, np.array([100.0]), 80.0)
    assert [(one.run, one.from_s) for one in used] == [("busy", 120.0)]
    assert used[0].to_s == pytest.approx(200.0, abs=0.03)
    assert used[0].excitation == pytest.approx(0.5 / np.sqrt(2), rel=0.05)
    assert tables[0].time_s[0] == 0.0
    assert passed == ("still: its commands hardly change.",)
    _, few, said = choose_stretches([runs[0], run("also", 0.9 * busy)], np.array([100.0]), 40.0)
    assert [one.run for one in few] == ["busy"]
    assert said == ("also: others have commands that change more, and 40 s are full.",)


def test_a_run_that_is_passed_over_is_told_the_true_reason() -> None:
    time_s = np.arange(0.0, 60.0, 0.02)
    busy = 50.0 * np.sin(time_s)[:, None]
    there = np.ones(time_s.size, bool)
    values = {"command": busy, "depth": np.zeros((time_s.size, 1))}
    whole = RunTable("long", time_s, values, {"command": there, "depth": there})
    short = replace(whole.rows(0, 750), name="short")
    lost = replace(whole, name="lost", valid={"command": time_s < 10.0, "depth": there})
    _, used, passed = choose_stretches([whole, short, lost], np.array([100.0]), 80.0)
    assert [one.run for one in used] == ["long"]
    assert passed == (
        "short: 15 s are too short; 20 s at least are needed.",
        "lost: most of its commands are missing.",
    )


def test_start_of_a_window_does_not_flatter_a_wrong_model(
    rov: tuple[PackedVehicle, Sensors], table: RunTable
) -> None:
    """Windows whose starts are estimated with a wrong model, and the same from the true state."""
    packed, sensors = rov
    truth = fly(packed, MANOEUVRES["heave_steps"].plan(packed, 1.0, DURATION_S))
    vector = packed.vector.copy()
    read(vector, "quadratic_damping")[2] *= 1.3
    read(vector, "linear_damping")[2, 2] *= 1.3
    wrong = replace(packed, vector=vector)
    flights = fly_trial(wrong, sensors, table, threads=1)
    row_of = np.searchsorted(truth.time_s, table.time_s - 1e-9)
    heave = truth.nu[row_of, 2]
    estimated = (flights.trajectory.nu[:, 2] - heave)[flights.valid]
    exact = []
    actuator = actuator_states(wrong, table.values["command"], 0.02)
    for begin, end in pairwise((*flights.first_rows, table.time_s.size)):
        start = np.zeros(STATE)
        state = (truth.position_ned_m, truth.quaternion, truth.nu)
        start[:13] = np.concatenate([part[row_of[begin]] for part in state])
        start[BODY : BODY + actuator.shape[1]] = actuator[begin]
        command = table.values["command"][begin : end - 1]
        exact.append(run(wrong, command, dt_s=0.02, start=start).nu[:, 2] - heave[begin:end])
    from_truth = np.concatenate(exact)
    over = float(np.sqrt(np.mean(estimated**2) / np.mean(from_truth**2)))
    # 6.2 mm/s over 6.0 mm/s
    assert over == pytest.approx(1.035, abs=0.02)
