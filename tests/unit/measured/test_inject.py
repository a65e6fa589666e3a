"""A run with rewritten commands is one of a vehicle with the effect: by the simulator itself."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.errors import CannotComputeError
from pipeline.measured.inject import commanded_without_effect, injected
from pipeline.measured.motion import MeasuredMotion
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle, mass_of, pack_vehicle
from pipeline.simulate.run import Trajectory, run
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle

PERIOD_S = 0.02


@pytest.fixture(scope="module")
def rov() -> PackedVehicle:
    return pack_vehicle(load_vehicle(bundled_vehicle("rov8")))


@pytest.fixture(scope="module")
def flown(rov: PackedVehicle) -> Trajectory:
    """12 s of smooth commands that keep clear of dead zone and ends, once they have set out."""
    time_s = PERIOD_S * np.arange(600)
    phase = 0.7 * np.arange(len(rov.thruster_names))
    wave = 0.25 + 0.08 * np.sin(1.1 * time_s[:, None] + phase)
    side = np.where(np.arange(len(phase)) % 2, -1.0, 1.0)
    set_out = np.minimum(time_s / 2.0, 1.0)[:, None]
    return run(rov, set_out * wave * side * rov.code_limits[:, 1], dt_s=PERIOD_S)


def table(flown: Trajectory, codes: FloatArray | None = None) -> RunTable:
    command = flown.command[:-1] if codes is None else codes
    values = {
        "command": command,
        "angular_velocity": flown.nu[:-1, 3:],
        "velocity": flown.nu[:-1, :3],
        "attitude": flown.quaternion[:-1],
        "position": flown.position_ned_m[:-1],
    }
    every = np.ones(len(command), bool)
    return RunTable("run", flown.time_s[:-1], values, dict.fromkeys(values, every))


def motion(flown: Trajectory) -> MeasuredMotion:
    """The motion in the middle of each row, as it really was."""
    state = np.concatenate([flown.position_ned_m, flown.quaternion, flown.nu], axis=1)
    middle = 0.5 * (state[1:] + state[:-1])
    rates = np.diff(flown.nu, axis=0) / PERIOD_S
    return MeasuredMotion(flown.time_s[:-1], middle, rates, np.ones(6, bool), placed=True)


EFFECTS = (
    "thruster_degraded:thrust_fraction=0.7@front_left",
    "thrust_deduction:t=0.15",
    "reverse_thrust:fraction=0.8",
    "dead_zone:codes=20",
    "voltage_sag:drop=0.1",
    "thruster_lag:lag_s=0.2",
    "thruster_misalignment:azimuth_deg=8@rear_left",
    "residual_buoyancy:force_n=6",
    "cg_shift:dx_m=0.004,dy_m=-0.003",
    "linear_damping:surge=1.6,heave=1.5",
    "quadratic_damping:sway=1.8",
    "added_mass:surge=1.5,yaw=1.4",
    "payload:mass_kg=0.8,x_m=0.1",
    "current:north_mps=0.1,east_mps=-0.05",
    "lift:heave_slope=100",
)


@pytest.mark.parametrize("text", EFFECTS)
def test_a_vehicle_with_the_effect_does_by_the_new_commands_what_was_measured(
    rov: PackedVehicle, flown: Trajectory, text: str
) -> None:
    spec = parse_effect(text, rov.thruster_names)
    put = injected(rov, table(flown), [spec], motion=motion(flown))
    assert put.share > 0.97
    changed = apply_effects(rov.vector, [spec], rov.context)
    again = run(rov, put.run.values["command"], dt_s=PERIOD_S, vector=changed)
    without = run(rov, flown.command[:-1], dt_s=PERIOD_S, vector=changed)
    assert energy(rov, again.nu - flown.nu) < 0.03 * energy(rov, without.nu - flown.nu)


def energy(rov: PackedVehicle, nu: FloatArray) -> float:
    """Twice the kinetic energy of a motion, its mean."""
    return float(np.einsum("ki,ij,kj->", nu, mass_of(rov.vector), nu) / len(nu))


def test_only_the_commands_are_rewritten(rov: PackedVehicle, flown: Trajectory) -> None:
    before = table(flown)
    spec = parse_effect("thruster_degraded:thrust_fraction=0.6@front_left", rov.thruster_names)
    put = injected(rov, before, [spec])
    assert {k for k in before.values if put.run.values[k] is not before.values[k]} == {"command"}
    moved = np.abs(put.run.values["command"] - before.values["command"]).max(axis=0) > 1e-3
    assert [n for n, is_in in zip(rov.thruster_names, moved, strict=True) if is_in] == [
        "front_left"
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("dvl_scale:scale=1.1", "error of the readings"),
        ("quadratic_damping:surge=2", "velocity in surge"),
        ("voltage_sag:load_drop=0.1", "couples all thrusters"),
        ("residual_buoyancy:force_n=0", "does nothing"),
    ],
)
def test_what_cannot_be_put_in_is_refused(
    rov: PackedVehicle, flown: Trajectory, text: str, said: str
) -> None:
    blind = table(flown)
    blind = replace(blind, values={k: v for k, v in blind.values.items() if k != "velocity"})
    with pytest.raises(CannotComputeError, match=said):
        injected(rov, blind, [parse_effect(text, rov.thruster_names)])


def test_a_thruster_that_stood_still_is_commanded(rov: PackedVehicle, flown: Trajectory) -> None:
    codes = flown.command[:-1].copy()
    codes[:, 2] = 0.0
    still = table(flown, codes)
    told = commanded_without_effect(rov, still, rov.thruster_names[2], 0.4, seed=3)
    new = told.values["command"]
    assert np.abs(new[:, 2]).max() == pytest.approx(0.4 * rov.code_limits[2, 1], abs=1.0)
    np.testing.assert_array_equal(np.delete(new, 2, axis=1), np.delete(codes, 2, axis=1))
    with pytest.raises(CannotComputeError, match="gave thrust"):
        commanded_without_effect(rov, still, rov.thruster_names[1])


def test_heave_follows_from_depth_and_attitude(flown: Trajectory) -> None:
    from pipeline.measured.motion import measured_motion

    run_ = table(flown)
    values = {k: v for k, v in run_.values.items() if k not in {"velocity", "position"}}
    values["depth"] = run_.values["position"][:, 2:]
    level = Rotation.identity(len(values["depth"])).as_quat()[:, [3, 0, 1, 2]]
    blind = replace(
        run_,
        values=values | {"attitude": level},
        valid=run_.valid | {"depth": run_.valid["command"]},
    )
    found = measured_motion(blind)
    sinking = np.gradient(values["depth"][:, 0], PERIOD_S)
    assert list(found.measured) == [False, False, True, True, True, True]
    np.testing.assert_allclose(found.nu[20:-20, 2], sinking[20:-20], atol=0.02)
