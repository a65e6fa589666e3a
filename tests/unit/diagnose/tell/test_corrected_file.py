"""What a verdict writes into the vehicle file is what the verdict says."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.tell.file_changes import left_to_say
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.physics.parameters import SLOTS, read
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import run
from pipeline.simulate.sensors import measure
from pipeline.simulate.unpack import changed_keys
from pipeline.types import FloatArray
from pipeline.vehicle.frames import changes_as_stated
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.write_back import updated_vehicle_text

#: What an effect changes and the file says in another way; see `test_thrust_of_a_corrected_file`.
_SAID_OTHERWISE = {
    *("thrust_gain", "reverse_gain", "dead_zone", "drive_dead", "crossflow_fraction"),
    *("thruster_direction", "misalignment_azimuth", "misalignment_elevation", "turnover_slope"),
    *("dvl_lever_arm", "dvl_rotation", "dvl_delay", "dvl_scale"),
}
_SAYABLE = (
    "added_mass:heave=1.3,pitch=0.8",
    "linear_damping:surge=1.4",
    "quadratic_damping:sway=0.6",
    "residual_buoyancy:force_n=4",
    "cg_shift:dx_m=0.01,dy_m=-0.003,dz_m=-0.005",
    "payload:mass_kg=2,volume_m3=0.0005,x_m=0.1,y_m=0.05,z_m=0.1",
    "thruster_lag:lag_s=0.1",
)
_ON_ONE_VEHICLE = (
    "wall_effect:strength=1.2",
    "voltage_sag:drop=0.1,load_drop=0.05",
    "current:north_mps=0.2,east_mps=-0.1",
    "tether:drag_area_m2=0.02,pull_n=3",
    "lift:heave_slope=20,pitch_slope=-5,sway_slope=11,yaw_slope=4",
    "advance_speed_loss:inflow_fraction=0.7",
    "dvl_delay:delay_s=0.2",
    "dvl_scale:scale=1.05",
    "dvl_misalignment:yaw_deg=4,pitch_deg=1",
    "dvl_lever_arm:x_m=0.1,z_m=-0.05",
    "crossflow_coupling:fraction=0.7",
)


def corrected(original: Path, effect: str, folder: Path) -> tuple[PackedVehicle, FloatArray]:
    """Vehicle of the corrected file, and the vector it is to have."""
    vehicle = load_vehicle(original)
    packed = pack_vehicle(vehicle)
    assert vehicle.model is not None
    spec = parse_effect(effect.replace("THRUSTER", packed.thruster_names[1]))
    wanted = apply_effects(packed.vector, [spec], packed.context)
    changes = changed_keys(vehicle, vehicle.model, packed, wanted)
    assert left_to_say([spec], changes) == ()
    text = updated_vehicle_text(
        original.read_text(encoding="utf-8"), changes_as_stated(changes, vehicle.frame), "changed"
    )
    file = folder / "vehicle.yaml"
    file.write_text(text, encoding="utf-8")
    return pack_vehicle(load_vehicle(file)), wanted


def vehicle_file(name: str) -> Path:
    found = bundled_vehicle(name)
    return found if found.is_file() else found / "vehicle.yaml"


@pytest.mark.parametrize(
    ("vehicle", "effect"),
    [
        *((vehicle, effect) for effect in _SAYABLE for vehicle in ("rov8", "cargo_carrier")),
        *(("rov8", effect) for effect in _ON_ONE_VEHICLE),
    ],
)
def test_the_corrected_file_is_the_vehicle_of_the_verdict(
    vehicle: str, effect: str, tmp_path: Path
) -> None:
    found, wanted = corrected(vehicle_file(vehicle), effect, tmp_path)
    for slot in SLOTS:
        if slot.name not in _SAID_OTHERWISE:
            got, meant = read(found.vector, slot.name), read(wanted, slot.name)
            # the file has seven digits
            np.testing.assert_allclose(got, meant, rtol=2e-6, atol=2e-7, err_msg=slot.name)


@pytest.mark.parametrize("effect", [_SAYABLE[4], _SAYABLE[5]])
def test_a_file_in_other_axes_is_corrected_in_its_own(effect: str, tmp_path: Path) -> None:
    """The same numbers read as those of the papers' axes are another vehicle, as good as any."""
    text = vehicle_file("cargo_carrier").read_text(encoding="utf-8")
    other = tmp_path / "other" / "vehicle.yaml"
    other.parent.mkdir()
    other.write_text(f"frame: paper\n{text}", encoding="utf-8")
    found, wanted = corrected(other, effect, tmp_path)
    for name in ("mass", "centre_of_mass", "centre_of_buoyancy", "inertia", "buoyancy"):
        np.testing.assert_allclose(
            read(found.vector, name), read(wanted, name), rtol=2e-6, atol=2e-7
        )


_OF_THRUST = (
    "thrust_deduction:t=0.2",
    "reverse_thrust:fraction=0.7",
    "thruster_degraded:thrust_fraction=0.69@THRUSTER",
    "thruster_degraded:thrust_fraction=0@THRUSTER",
    "thruster_misalignment:azimuth_deg=5,elevation_deg=3@THRUSTER",
)


@pytest.mark.parametrize("effect", _OF_THRUST)
def test_thrust_of_a_corrected_file(effect: str, tmp_path: Path) -> None:
    original = vehicle_file("rov8")
    before = pack_vehicle(load_vehicle(original))
    found, wanted = corrected(original, effect, tmp_path)
    count = len(before.thruster_names)
    codes = np.linspace(-400.0, 400.0, 81)[:, None] * np.ones(count)
    still = np.zeros((len(codes), 6))
    got, _ = thruster_wrench(found, codes, still)
    meant, _ = thruster_wrench(before, codes, still, vector=wanted)
    stated, _ = thruster_wrench(before, codes, still)
    assert np.abs(meant - stated).max() > 1.0
    np.testing.assert_allclose(got, meant, atol=0.02 * np.abs(stated).max())


@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        (
            "thruster_degraded:thrust_fraction=0.69@THRUSTER",
            {"thrusters.1.gain_ahead": 0.69, "thrusters.1.gain_reverse": 0.69},
        ),
        ("dead_zone:codes=20", {"model.thrusters.t200_esc.characteristic.dead_zone_code": 48.0}),
    ],
)
def test_a_finding_of_thrusters_is_said_where_it_belongs(
    effect: str, expected: dict[str, float]
) -> None:
    vehicle = load_vehicle(vehicle_file("rov8"))
    packed = pack_vehicle(vehicle)
    assert vehicle.model is not None
    spec = parse_effect(effect.replace("THRUSTER", packed.thruster_names[1]))
    vector = apply_effects(packed.vector, [spec], packed.context)
    changes = changed_keys(vehicle, vehicle.model, packed, vector)
    assert changes == pytest.approx(expected)


@pytest.mark.parametrize("frame", ["sname", "paper"])
def test_the_dvl_of_the_corrected_file_reads_what_the_wrong_one_did(
    frame: str, tmp_path: Path
) -> None:
    text = vehicle_file("cargo_carrier").read_text(encoding="utf-8")
    original = tmp_path / "other" / "vehicle.yaml"
    original.parent.mkdir()
    original.write_text(f"frame: {frame}\n{text}", encoding="utf-8")
    vehicle = load_vehicle(original)
    packed = pack_vehicle(vehicle)
    assert vehicle.model is not None
    assert vehicle.sensors is not None
    wrong = [
        parse_effect(text)
        for text in (
            *("dvl_scale:scale=1.05", "dvl_delay:delay_s=0.2", "dvl_lever_arm:x_m=0.1,z_m=-0.05"),
            "dvl_misalignment:roll_deg=2,pitch_deg=1,yaw_deg=30",
        )
    ]
    vector = apply_effects(packed.vector, wrong, packed.context)
    changes = changed_keys(vehicle, vehicle.model, packed, vector)
    assert left_to_say(wrong, changes) == ()
    changes = changes_as_stated(changes, vehicle.frame)
    corrected_text = updated_vehicle_text(original.read_text(encoding="utf-8"), changes, "")
    original.write_text(corrected_text, encoding="utf-8")
    mended = load_vehicle(original).sensors
    assert mended is not None
    command = np.zeros((200, len(packed.thruster_names)))
    command[:, 0] = 300.0
    motion = run(packed, command, dt_s=0.02)
    wrong_dvl, dvl = (
        measure(motion, packed, sensors, vector=true)["dvl"]
        for sensors, true in ((vehicle.sensors, vector), (mended, packed.vector))
    )
    np.testing.assert_allclose(wrong_dvl.values, dvl.values, atol=1e-6)
    np.testing.assert_allclose(wrong_dvl.logged_s, dvl.logged_s, atol=1e-9)
    np.testing.assert_allclose(wrong_dvl.valid_s, dvl.valid_s + 0.2, atol=1e-9)
