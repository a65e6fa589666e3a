"""The vehicle file of mmt300 is valid and prints the paper's numbers."""

from pathlib import Path

import numpy as np
import pytest

from evaluation.bundled import mmt300_truth as truth
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle


@pytest.fixture(scope="module")
def vehicle(repository: Path) -> Vehicle:
    return load_vehicle(repository / "raw" / "mmt300" / "vehicle.yaml")


def test_water_and_screw_are_those_of_the_paper(vehicle: Vehicle) -> None:
    assert vehicle.water.density_kgpm3 == pytest.approx(truth.DENSITY_KGPM3, abs=0.005)
    assert vehicle.water.gravity_mps2 == truth.GRAVITY_MPS2
    assert vehicle.propeller.diameter_m == truth.DIAMETER_M
    assert (vehicle.drive.code_min, vehicle.drive.code_max) == (-127, 127)


def test_published_tables_are_those_of_the_generator(vehicle: Vehicle) -> None:
    published = vehicle.published
    assert published is not None
    assert published.table1 is not None
    assert published.table2 is not None
    assert published.table3 is not None
    assert (published.table1.KT, published.table1.KM) == (truth.KT, truth.KM)
    rows = zip(published.table2.KF0, published.table2.KF1, published.table2.KF2, strict=True)
    assert dict(zip(published.table2.speed_mps, rows, strict=True)) == truth.TABLE2
    assert published.table3.positive == truth.TABLE3_POSITIVE
    assert published.table3.negative == truth.TABLE3_NEGATIVE


def test_table_4_inverts_table_2_as_well_as_the_paper_does(vehicle: Vehicle) -> None:
    """Its round trip through Table 2 is off by at most 0.72, 0.72, 0.76, 0.62, 0.68 N.

    On a grid of half newtons; at the edge of the dead zone a finer one finds 0.04 N more at rest.
    """
    assert vehicle.published is not None
    table = vehicle.published.table4
    assert table is not None
    worst = []
    for speed, largest, *row in zip(
        table.speed_mps, table.T_max_n, table.KN0, table.KN1, table.KN2, table.KN3, strict=True
    ):
        thrust_n = np.append(np.arange(0.5, largest, 0.5), largest)
        codes = np.polynomial.polynomial.polyval(thrust_n, row)
        back = np.array([truth.table2_thrust(float(code), speed) for code in codes])
        worst.append(float(np.abs(back - thrust_n).max()))
    assert worst == pytest.approx([0.72, 0.72, 0.76, 0.62, 0.68], abs=0.015)


def test_thrusters_give_the_wrench_of_eq_5(vehicle: Vehicle) -> None:
    """Paper's heave, yaw and pitch against SNAME: F_y = -Z, M_y = -N, M_z = M."""
    allocator = vehicle.allocator
    assert allocator is not None
    assert allocator.bow_arm_m is not None
    thrust_n = {"upper": 3.0, "lower": 1.0, "left": 2.0, "right": 5.0, "bow": 0.7}
    force = np.zeros(3)
    moment = np.zeros(3)
    for thruster in vehicle.thrusters:
        push = thrust_n[thruster.name] * np.array(thruster.direction)
        force += push
        moment += np.cross(np.array(thruster.position_m), push)
    sine, cosine = np.sin(np.radians(22.5)), np.cos(np.radians(22.5))
    arm_s, arm_b = allocator.stern_arm_m, allocator.bow_arm_m
    assert force == pytest.approx(
        [11.0 * cosine, (5.0 - 2.0) * sine, -((3.0 - 1.0) * sine + 0.7)], abs=1e-4
    )
    assert moment == pytest.approx(
        [0.0, 0.7 * arm_b - 2.0 * sine * arm_s, -(5.0 - 2.0) * sine * arm_s], abs=1e-4
    )


def test_the_vehicle_file_says_that_nothing_was_measured(vehicle: Vehicle) -> None:
    assert "Nothing in this folder was measured" in vehicle.data_note
