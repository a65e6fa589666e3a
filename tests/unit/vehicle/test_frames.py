"""Positions in other frames: hand-worked cases, and that the same vehicle flies the same."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.cli import cli
from pipeline.errors import InputError
from pipeline.simulate.pack import pack_vehicle
from pipeline.vehicle.frames import (
    TO_SNAME,
    changes_as_stated,
    in_sname,
    rotation_in_sname,
    vector_in_sname,
)
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Frame, Vehicle
from tests.unit.vehicle.test_model_schema import FULL, replaced

MATRIX = ("diagonal: [1, 8, 9, 0, 2, 3]", FULL)


def stated(folder: Path, frame: str, *changes: tuple[str, str]) -> Vehicle:
    text = replaced(*changes)
    (folder / "vehicle.yaml").write_text(f"frame: {frame}\n{text}", encoding="utf-8")
    return load_vehicle(folder)


@pytest.mark.parametrize("frame", ["paper", "ros"])
def test_every_frame_is_right_handed(frame: Frame) -> None:
    """A mirrored frame would need other signs for moments than for forces."""
    c = np.array(TO_SNAME[frame])
    np.testing.assert_array_equal(c @ c.T, np.eye(3))
    assert np.linalg.det(c) == pytest.approx(1.0)


def test_the_axes_by_hand() -> None:
    """One metre forward, two up, three to starboard is (1, 3, -2) in SNAME."""
    assert vector_in_sname((1.0, 2.0, 3.0), "paper") == (1.0, 3.0, -2.0)
    assert vector_in_sname((1.0, -3.0, 2.0), "ros") == (1.0, 3.0, -2.0)
    assert vector_in_sname((1.0, 3.0, -2.0), "sname") == (1.0, 3.0, -2.0)


def test_a_file_in_ros_axes_by_hand(tmp_path: Path) -> None:
    mount = "position_m: [0, 0.1, -0.2], rotation_deg: [10, 20, 30],"
    vehicle = stated(
        tmp_path,
        "ros",
        ("position_m: [-1, 0, 0]", "position_m: [-1, 0.2, 0.3]"),
        ("direction: [1, 0, 0]", "direction: [0, 0, 1]"),
        ("mass_kg: 10\n", "mass_kg: 10\n    centre_of_mass_m: [0.1, 0.02, -0.03]\n"),
        ("inertia_kgm2: [1, 2, 2.5, 0, 0, 0]", "inertia_kgm2: [1, 2, 2.5, 0.1, 0.2, 0.3]"),
        ("position_m: [0, 0, 1]", "position_m: [0, 0.5, -1], inertia_kgm2: [0.1, 0.2, 0.25]"),
        ("attachment_m: [0, 0, 0]", "attachment_m: [0, 0.1, 0.4]"),
        ("dvl: {rate_hz: 5,", f"dvl: {{rate_hz: 5, {mount}"),
        MATRIX,
    )
    assert vehicle.thrusters[0].position_m == (-1.0, -0.2, -0.3)
    assert vehicle.thrusters[0].direction == (0.0, 0.0, -1.0)
    model, sensors = vehicle.model, vehicle.sensors
    assert model is not None
    assert sensors is not None
    assert sensors.dvl is not None
    assert model.tether is not None
    assert model.rigid_body.centre_of_mass_m == (0.1, -0.02, 0.03)
    # the integral of yz keeps its sign: both axes turn round
    assert model.rigid_body.inertia_kgm2 == pytest.approx((1.0, 2.0, 2.5, -0.1, -0.2, 0.3))
    assert model.payloads[0].position_m == (0.0, -0.5, 1.0)
    assert model.payloads[0].inertia_kgm2 == pytest.approx((0.1, 0.2, 0.25))
    assert model.tether.attachment_m == (0.0, -0.1, -0.4)
    assert model.tether.anchor_ned_m == (30.0, 0.0, -40.0)  # NED stays
    assert sensors.dvl.position_m == (0.0, -0.1, 0.2)
    assert sensors.dvl.rotation_deg == pytest.approx((10.0, -20.0, -30.0))
    # A_26, sway force by yaw: both turn round
    assert model.added_mass.matrix is not None
    np.testing.assert_allclose(np.array(model.added_mass.matrix)[1], [0, 8, 0, 0, 0, 4])


def test_a_file_in_the_papers_axes_by_hand(tmp_path: Path) -> None:
    """Second and third axis change places: y up is heave, z to starboard is sway."""
    vehicle = stated(
        tmp_path,
        "paper",
        ("direction: [1, 0, 0]", "direction: [0, 1, 0]"),
        ("inertia_kgm2: [1, 2, 2.5, 0, 0, 0]", "inertia_kgm2: [1, 2, 2.5, 0.1, 0.2, 0.3]"),
        ("position_m: [0, 0, 1]", "position_m: [0, -1, 0.5], inertia_kgm2: [0.1, 0.2, 0.25]"),
        MATRIX,
    )
    assert vehicle.thrusters[0].direction == (0.0, 0.0, -1.0)
    model = vehicle.model
    assert model is not None
    # X = x, Y = z, Z = -y: I_XY = xz, I_XZ = -xy, I_YZ = -yz
    assert model.rigid_body.inertia_kgm2 == pytest.approx((1.0, 2.5, 2.0, 0.2, -0.1, -0.3))
    assert model.payloads[0].position_m == (0.0, 0.5, 1.0)
    assert model.payloads[0].inertia_kgm2 == pytest.approx((0.1, 0.25, 0.2))
    # row 2, column 6 of the file is F_y by omega_z: heave up by M_z, that is -Z and M
    a = np.array(model.added_mass.matrix)
    assert a[2, 4] == pytest.approx(-4.0)
    np.testing.assert_allclose(np.diag(a), [1, 9, 8, 0, 3, 2])


def test_lists_by_motion_keep_their_order(tmp_path: Path) -> None:
    vehicle = stated(
        tmp_path, "paper", ("linear: [1, 1, 1, 1, 1, 1]", "linear: [1, 2, 3, 4, 5, 6]")
    )
    assert vehicle.model is not None
    assert vehicle.model.damping.linear == (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert vehicle.model.added_mass.diagonal == (1.0, 8.0, 9.0, 0.0, 2.0, 3.0)


def test_a_mounting_is_the_same_turn_in_either_frame() -> None:
    """What the sensor reads along its own forward axis is the same vector of the body."""
    angles = (20.0, -35.0, 130.0)
    turn = Rotation.from_euler("ZYX", angles[::-1], degrees=True)
    for frame in ("paper", "ros"):
        ours = rotation_in_sname(angles, frame)
        converted = Rotation.from_euler("ZYX", ours[::-1], degrees=True)
        forward = vector_in_sname(tuple(turn.apply([1.0, 0.0, 0.0])), frame)
        np.testing.assert_allclose(converted.apply([1.0, 0.0, 0.0]), forward, atol=1e-9)


def test_the_same_carrier_in_three_frames_is_packed_alike(tmp_path: Path) -> None:
    """Every vector of a bundled file, rewritten by hand-turned numbers, gives the same kernel."""
    source = bundled_vehicle("cargo_carrier") / "vehicle.yaml"
    text = source.read_text(encoding="utf-8")
    reference = pack_vehicle(load_vehicle(source))
    for frame, order in (("ros", "{0}, {my}, {mz}"), ("paper", "{0}, {mz}, {1}")):

        def turned(match: re.Match[str], order: str = order) -> str:
            x, y, z = (float(part) for part in match[2].split(","))
            row = order.format(x, y, mz=-z, my=-y)
            return f"{match[1]}: [{row}]"

        keys = "position_m|direction|centre_of_mass_m|centre_of_buoyancy_m|attachment_m"
        other = re.sub(rf"\b({keys}): \[([^\]]*)\]", turned, text)
        if frame == "paper":  # inertia: the second and third change places
            swap = r"inertia_kgm2: [\1, \3, \2"
            other = re.sub(r"inertia_kgm2: \[([^,]*), ([^,]*), ([^,\]]*)", swap, other)
        folder = tmp_path / frame
        folder.mkdir()
        (folder / "vehicle.yaml").write_text(f"frame: {frame}\n{other}", encoding="utf-8")
        packed = pack_vehicle(load_vehicle(folder))
        np.testing.assert_allclose(packed.vector, reference.vector, atol=1e-12)


def test_sname_changes_nothing(tmp_path: Path) -> None:
    vehicle = stated(tmp_path, "sname")
    assert in_sname(vehicle) is vehicle


def test_check_shows_what_was_converted(tmp_path: Path) -> None:
    stated(tmp_path, "ros", ("position_m: [-1, 0, 0]", "position_m: [-1, 0.2, 0]"))
    (tmp_path / "mooring").mkdir()
    done = CliRunner().invoke(cli, ["check", str(tmp_path), "--json"])
    notes = json.loads(done.stdout)["vehicles"][0]["notes"]
    assert "x forward, y to port, z up" in notes[0]
    assert "stern: position [-1, -0.2, 0] m" in notes[1]


def test_an_unknown_frame_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match='frame is "nwu"'):
        stated(tmp_path, "nwu")


def test_a_short_tether_is_measured_in_the_right_frame(tmp_path: Path) -> None:
    """Anchor 40 m above the origin, attachment 20 m further down (SNAME z = 20)."""
    anchor = ("anchor_ned_m: [30, 0, -40]", "anchor_ned_m: [0, 0, -40]")
    with pytest.raises(InputError, match=r"60\.000 m"):
        stated(tmp_path, "ros", anchor, ("attachment_m: [0, 0, 0]", "attachment_m: [0, 0, -20]"),
               ("length_m: 60", "length_m: 59"))  # fmt: skip
    stated(tmp_path, "ros", anchor, ("attachment_m: [0, 0, 0]", "attachment_m: [0, 0, 20]"),
           ("length_m: 60", "length_m: 21"))  # fmt: skip


@pytest.mark.parametrize("frame", ["sname", "paper", "ros"])
def test_what_is_written_back_is_read_as_it_was_meant(tmp_path: Path, frame: Frame) -> None:
    """SNAME values turned into the file's frame, put into the file, and read again."""
    half = np.random.default_rng(1).uniform(-1.0, 1.0, (6, 6))
    wanted = half + half.T + 8.0 * np.eye(6)
    centre = (0.1, -0.02, 0.03)
    path = "model.added_mass.matrix"
    changes: dict[str, float | tuple[float, ...]] = {
        f"{path}.{i}.{j}": float(wanted[i, j]) for i in range(6) for j in range(6)
    }
    changes["model.rigid_body.centre_of_mass_m"] = centre
    stated_as = changes_as_stated(changes, frame)
    rows = [[stated_as[f"{path}.{i}.{j}"] for j in range(6)] for i in range(6)]
    own = list(stated_as["model.rigid_body.centre_of_mass_m"])  # type: ignore[arg-type]
    vehicle = stated(
        tmp_path,
        frame,
        ("mass_kg: 10\n", f"mass_kg: 10\n    centre_of_mass_m: {own}\n"),
        (MATRIX[0], f"matrix: {rows}"),
    )
    assert vehicle.model is not None
    np.testing.assert_allclose(np.array(vehicle.model.added_mass.matrix), wanted, atol=1e-12)
    np.testing.assert_allclose(vehicle.model.rigid_body.centre_of_mass_m, centre, atol=1e-12)
