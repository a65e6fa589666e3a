"""The model and sensor sections: good ones are read, bad ones get one message with its line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipeline.errors import InputError
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.model_checks import added_mass_fault, inertia_fault
from pipeline.vehicle.model_schema import FromBollard, FromTables
from pipeline.vehicle.schema import Vehicle

GOOD = """\
name: one
title: one
water: {density_kgpm3: 1000, gravity_mps2: 9.81}
propellers:
  screw: {diameter_m: 0.2}
drives:
  motor: {code_min: -127, code_max: 127}
  other: {code_min: -127, code_max: 127}
thrusters:
  - name: stern
    propeller: screw
    drive: motor
    position_m: [-1, 0, 0]
    direction: [1, 0, 0]
tables: {propeller: screw, drive: motor}
model:
  rigid_body:
    mass_kg: 10
    inertia_kgm2: [1, 2, 2.5, 0, 0, 0]
    displaced_volume_m3: 0.01
  added_mass:
    diagonal: [1, 8, 9, 0, 2, 3]
  damping:
    linear: [1, 1, 1, 1, 1, 1]
    quadratic: [1, 1, 1, 1, 1, 1]
  payloads:
    - {name: box, mass_kg: 1, volume_m3: 0.001, position_m: [0, 0, 1]}
  thrusters:
    motor:
      characteristic:
        kind: bollard
        thrust_max_n: 40
        thrust_min_n: -30
        zero_thrust_speed_mps: 4
  tether:
    attachment_m: [0, 0, 0]
    anchor_ned_m: [30, 0, -40]
    length_m: 60
    diameter_m: 0.01
    mass_kgpm: 0.1
  pool:
    walls:
      - {point_ned_m: [5, 0, 0], normal_ned: [-1, 0, 0]}
    vehicle_radius_m: 0.2
sensors:
  dvl: {rate_hz: 5, noise_mps: 0.01}
"""
FULL = """matrix:
      - [1, 0, 0, 0, 0, 0]
      - [0, 8, 0, 0, 0, 4]
      - [0, 0, 9, 0, 0, 0]
      - [0, 0, 0, 0, 0, 0]
      - [0, 0, 0, 0, 2, 0]
      - [0, 4, 0, 0, 0, 3]"""

DRUM = "drum_radius_m: 0.2, inertia_kgm2: 3, stall_torque_nm: 100, no_load_radps: 4"


def read(folder: Path, text: str) -> Vehicle:
    (folder / "vehicle.yaml").write_text(text)
    return load_vehicle(folder)


def replaced(*pairs: tuple[str, str]) -> str:
    text = GOOD
    for old, new in pairs:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def test_a_good_model_is_read(tmp_path: Path) -> None:
    vehicle = read(tmp_path, GOOD)
    assert vehicle.model is not None
    assert vehicle.sensors is not None
    assert vehicle.sensors.dvl is not None
    assert vehicle.sensors.imu is None
    characteristic = vehicle.model.thrusters["motor"].characteristic
    assert isinstance(characteristic, FromBollard)
    assert characteristic.thrust_min_n == -30.0
    assert vehicle.model.terms.coriolis
    assert vehicle.model.payloads[0].attached


def test_a_full_added_mass_matrix_and_the_tables_are_read(tmp_path: Path) -> None:
    kind = GOOD[GOOD.index("        kind: bollard") : GOOD.index("  tether:")]
    text = replaced(("diagonal: [1, 8, 9, 0, 2, 3]", FULL), (kind, "        kind: tables\n"))
    vehicle = read(tmp_path, text)
    assert vehicle.model is not None
    assert isinstance(vehicle.model.thrusters["motor"].characteristic, FromTables)
    assert vehicle.model.added_mass.matrix is not None
    assert vehicle.model.added_mass.matrix[1][5] == 4.0


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("mass_kg: 10\n", "mass_kg: -10\n", "row 18: model.rigid_body.mass_kg is -10.\nExpected a"),
        ("mass_kg: 10\n", "mass: 10\n", 'row 18: unknown key "mass" in model.rigid_body.'),
        (
            "[1, 2, 2.5, 0, 0, 0]",
            "[1, 2, 3.5, 0, 0, 0]",
            "row 19: model.rigid_body.inertia_kgm2: no body has the principal moments 1, 2, 3.5 kg",
        ),
        (
            "[1, 2, 2.5, 0, 0, 0]",
            "[1, 2, 2.5, 1.9, 0, 0]",
            "row 19: model.rigid_body.inertia_kgm2: the principal moments are -0.464688, 2.5, ",
        ),
        (
            "[1, 8, 9, 0, 2, 3]",
            "[1, -8, 9, 0, 2, 3]",
            "row 22: model.added_mass.diagonal[2] is -8.\nExpected a number of at least 0.",
        ),
        (
            "[1, 8, 9, 0, 2, 3]",
            "[1, 8, 9, 2, 3]",
            "diagonal has too few entries.\nExpected a list of 6 numbers of at least 0 in square b",
        ),
        (
            "diagonal: [1, 8, 9, 0, 2, 3]",
            FULL.replace("8, 0, 0, 0, 4", "8, 0, 0, 0, 3"),
            "row 22: model.added_mass.matrix: not symmetric: row 2, column 6 is 3, row 6, column 2",
        ),
        (
            "diagonal: [1, 8, 9, 0, 2, 3]",
            FULL.replace("4", "5"),
            "row 22: model.added_mass.matrix: not positive semidefinite (smallest eigenvalue",
        ),
        (
            "diagonal: [1, 8, 9, 0, 2, 3]",
            FULL.replace("[1,", "[-1,"),
            "row 22: model.added_mass.matrix: row 1, column 1 is -1; added masses are positive",
        ),
        (
            "diagonal: [1, 8, 9, 0, 2, 3]",
            "matrix: [1, 8, 9, 0, 2, 3]",
            "  row 22: model.added_mass.matrix[1] is 1. Expected a list of 6 numbers in square",
        ),
        (
            "diagonal: [1, 8, 9, 0, 2, 3]",
            "matrix: 3",
            "row 22: model.added_mass.matrix is 3.\nExpected a list of 6 rows, each a list of 6",
        ),
        (
            "    diagonal: [1, 8, 9, 0, 2, 3]\n",
            "    source: none\n",
            "row 21: model.added_mass: give either diagonal or matrix",
        ),
        (
            "linear: [1, 1, 1",
            "linear: [1, -1, 1",
            "row 24: model.damping.linear[2] is -1.\nExpected a number of at least 0.",
        ),
        (
            "volume_m3: 0.001",
            "volume_m3: 0.001, inertia_kgm2: [1, 1, 3]",
            "row 27: model.payloads[1].inertia_kgm2: no body has the principal moments 1, 1, 3",
        ),
        ("kind: bollard", "kind: bolard", 'row 31: model.thrusters.motor.characteristic.kind is "'),
        (
            "kind: bollard",
            "kind: bolard",
            "Expected a section with kind: bollard or mooring or tables.",
        ),
        (
            "        kind: bollard\n",
            "",
            'row 30: key "kind" is missing in model.thrusters.motor.characteristic.\nExpected a s',
        ),
        (
            "thrust_max_n: 40",
            "thrust_max_n: -40",
            "row 32: model.thrusters.motor.characteristic.thrust_max_n is -40.\nExpected a num",
        ),
        (
            "        thrust_max_n: 40\n",
            "",
            'row 30: key "thrust_max_n" is missing in model.thrusters.motor.characteristic.\nExp',
        ),
        (
            "thrust_max_n: 40",
            "dead_zone_code: 127\n        thrust_max_n: 40",
            "row 32: model.thrusters.motor.characteristic.dead_zone_code: it must be below",
        ),
        (
            "        zero_thrust_speed_mps: 4",
            "        zero_thrust_speed_mps: 4\n      balance_in_time: true",
            "row 35: model.thrusters.motor.balance_in_time: the balance takes propeller and drive",
        ),
        (
            "thrust_max_n: 40",
            "thrust_max: 40",
            'unknown key "thrust_max" in model.thrusters.motor.characteristic. Expected one of kin',
        ),
        (
            "    motor:\n      char",
            "    engine:\n      char",
            'row 29: model.thrusters.engine: there is no drive "engine"; drives has motor, other.',
        ),
        (
            "    motor:\n      char",
            "    other:\n      char",
            'row 28: model.thrusters: it lacks the drive "motor", which thruster "stern" has.',
        ),
        (
            "length_m: 60",
            "length_m: 49.9",
            "row 38: model.tether.length_m: 49.9 m is too short: from the anchor to the attachment",
        ),
        (
            "    mass_kgpm: 0.1",
            f"    mass_kgpm: 0.1\n    winch: {{{DRUM}, shortest_m: 5}}",
            "model.tether.winch: shortest_m 5 is less than two of the 20 segments of 3 m",
        ),
        (
            "    mass_kgpm: 0.1",
            f"    mass_kgpm: 0.1\n    winch: {{{DRUM}, shortest_m: 7, longest_m: 50}}",
            "model.tether.winch: length_m 60 is paid out at the start, outside of shortest_m 7",
        ),
        (
            "    mass_kgpm: 0.1",
            f"    mass_kgpm: 0.1\n    winch: {{{DRUM}, shortest_m: 70, longest_m: 50}}",
            "model.tether.winch.longest_m: 50 m is not above shortest_m, 70 m.",
        ),
        (
            "position_m: [0, 0, 1]}",
            "position_m: [0, 0, 1], latch: {strength_n: 10}}",
            'key "strength_nm" is missing in model.payloads[1].latch.',
        ),
        (
            "{name: box,",
            "{name: a box,",
            'model.payloads[1].name is "a box".',
        ),
        (
            "normal_ned: [-1, 0, 0]",
            "normal_ned: [-1, 1, 0]",
            "row 43: model.pool.walls[1].normal_ned: the vector has length 1.4142, a unit vector",
        ),
        ("rate_hz: 5", "rate_hz: 0", "row 46: sensors.dvl.rate_hz is 0.\nExpected a number above"),
        ("noise_mps: 0.01", "noise: 0.01", 'row 46: unknown key "noise" in sensors.dvl.'),
    ],
)
def test_bad_models_get_one_message_with_the_line(
    tmp_path: Path, old: str, new: str, expected: str
) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, replaced((old, new)))
    assert expected in str(caught.value)


def test_only_the_drive_of_the_tables_has_tables(tmp_path: Path) -> None:
    """The static family on file is that of tables.drive; another drive cannot borrow it."""
    text = replaced(
        ("tables: {propeller: screw, drive: motor}", "tables: {propeller: screw, drive: other}")
    )
    kind = text[text.index("        kind: bollard") : text.index("  tether:")]
    with pytest.raises(InputError, match=r'row 30: .*"kind: tables" is for the drives of tables'):
        read(tmp_path, text.replace(kind, "        kind: tables\n"))


@pytest.mark.parametrize("lowest", [-127, -21, 0])
def test_reverse_codes_reach_beyond_the_dead_zone(tmp_path: Path, lowest: int) -> None:
    """Codes that all lie inside it turn nothing; a drive without reverse codes says so with 0."""
    good = replaced(
        ("kind: bollard", "kind: bollard\n        dead_zone_code: 20"),
        ("  motor: {code_min: -127", f"  motor: {{code_min: {lowest}"),
    )
    assert read(tmp_path, good).drives["motor"].code_min == lowest
    with pytest.raises(InputError, match="dead_zone_code: code_min of the drive, -20, lies inside"):
        read(tmp_path, good.replace(f"code_min: {lowest}", "code_min: -20", 1))


def test_payload_names_differ(tmp_path: Path) -> None:
    line = "    - {name: box, mass_kg: 1, volume_m3: 0.001, position_m: [0, 0, 1]}\n"
    with pytest.raises(InputError, match=r'row 26: model.payloads: "box" is there twice'):
        read(tmp_path, replaced((line, line + line)))


@given(
    arrays(float, (5, 3), elements=st.floats(-2, 2)), arrays(float, 5, elements=st.floats(0.1, 3))
)
def test_every_cloud_of_masses_has_an_inertia_that_is_accepted(
    places_m: np.ndarray, masses_kg: np.ndarray
) -> None:
    """Small balls of 0.4 kg m^2 each keep it away from a line of points."""
    second = np.einsum("k,ki,kj->ij", masses_kg, places_m, places_m)
    tensor = np.trace(second) * np.eye(3) - second + 2.0 * np.eye(3)
    six = [*np.diag(tensor), -tensor[0, 1], -tensor[0, 2], -tensor[1, 2]]
    assert inertia_fault(six) is None


@given(arrays(float, (6, 6), elements=st.floats(-10, 10)))
def test_gram_matrices_are_accepted_and_their_negatives_are_not(root: np.ndarray) -> None:
    matrix = root @ root.T
    matrix = (matrix + matrix.T) / 2
    assert added_mass_fault(matrix.tolist()) is None
    if np.diag(matrix).max() > 0:
        assert added_mass_fault((-matrix).tolist()) is not None


def test_print_rounding_of_a_matrix_is_not_asymmetry() -> None:
    matrix = np.diag([4.0, 100.0, 100.0, 0.1, 20.0, 20.0])
    matrix[1, 5], matrix[5, 1] = 12.3456789, 12.345681
    assert added_mass_fault(matrix.tolist()) is None
    matrix[5, 1] = 12.346
    assert "row 2, column 6" in str(added_mass_fault(matrix.tolist()))
