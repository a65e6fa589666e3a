import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.control.allocate import achieved_wrench, allocate
from pipeline.control.allocation import Demand
from pipeline.control.inverse import firmware_grid, mooring_cubic
from pipeline.control.real_thrust import RealThruster
from pipeline.physics.thruster_static import StaticTable
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.vehicle.schema import Allocator

COS = float(np.cos(np.radians(22.5)))


def test_thesis_of_the_paper_by_hand(
    allocator: Allocator, paper_inverse: InverseCharacteristic, table2: StaticTable
) -> None:
    """10 N per thruster from Table 3 is 10.8 N at rest and nothing at all at 2 m/s.

    N = 12.7 + 43.36 - 7 + 0.729 = 49.789; Table 2 at 2 m/s is -2.5 N there, in the dead zone.
    For 20 N: N = 77.252, and T = -15 + 16.068 + 5.174 = 6.24 N.
    """
    moored = mooring_cubic(paper_inverse, thrust_dead_n=0.5, code_max=127)
    assert moored is not None
    codes = [
        allocate(Demand(4 * COS * t), 2.0, allocator=allocator, inverse=moored).stern_code[0]
        for t in (10.0, 20.0)
    ]
    np.testing.assert_allclose(codes, [49.789, 77.252], atol=1e-3)
    assert float(table2.thrust_n(codes[0], 0.0)) == pytest.approx(10.8, abs=0.1)
    assert float(table2.thrust_n(codes[0], 2.0)) == 0.0
    assert float(table2.thrust_n(codes[1], 2.0)) == pytest.approx(6.24, abs=0.01)


@given(
    surge=st.floats(2.5, 50.0), turn=st.floats(-1.0, 1.0), speed=st.sampled_from([0.0, 0.7, 2.0])
)
def test_compensated_wrench_is_the_asked_one(  # noqa: PLR0917 (fixtures and drawn values)
    allocator: Allocator,
    paper_inverse: InverseCharacteristic,
    paper_static: StaticCharacteristic,
    surge: float,
    turn: float,
    speed: float,
) -> None:
    """Within reach and with the motion: the yaw demand keeps every thrust positive."""
    per_moment = 2 * 1.2 * np.sin(np.radians(22.5))
    yaw = turn * (surge / (4 * COS) - 0.6) * per_moment
    yaw = float(np.clip(yaw, -9.0, 9.0))
    given_codes = allocate(
        Demand(surge, 0.0, yaw), speed, allocator=allocator, inverse=firmware_grid(paper_inverse)
    )
    real = achieved_wrench(
        given_codes.stern_code,
        speed,
        allocator=allocator,
        thruster=RealThruster.from_record(paper_static),
        bow_code=given_codes.bow_code,
    )
    np.testing.assert_allclose(given_codes.asked[[0, 5]], [surge, yaw], atol=1e-9)
    np.testing.assert_allclose(real[[0, 4, 5]], given_codes.asked[[0, 4, 5]], atol=0.1)


def test_no_cross_coupling_in_real_thrust(
    allocator: Allocator, paper_inverse: InverseCharacteristic, paper_static: StaticCharacteristic
) -> None:
    """Pure surge gives no moment, with or without compensation, however wrong the thrust."""
    moored = mooring_cubic(paper_inverse, thrust_dead_n=0.5, code_max=127)
    assert moored is not None
    thruster = RealThruster.from_record(paper_static)
    for inverse in (moored, firmware_grid(paper_inverse)):
        codes = allocate(Demand(40.0), 1.5, allocator=allocator, inverse=inverse).stern_code
        real = achieved_wrench(codes, 1.5, allocator=allocator, thruster=thruster)
        np.testing.assert_allclose(real[1:], 0.0, atol=1e-12)


def test_uncompensated_turn_is_coupled_to_nothing_but_loses_moment(
    allocator: Allocator, paper_inverse: InverseCharacteristic, paper_static: StaticCharacteristic
) -> None:
    moored = mooring_cubic(paper_inverse, thrust_dead_n=0.5, code_max=127)
    assert moored is not None
    codes = allocate(Demand(60.0, 0.0, 8.0), 1.5, allocator=allocator, inverse=moored).stern_code
    real = achieved_wrench(
        codes, 1.5, allocator=allocator, thruster=RealThruster.from_record(paper_static)
    )
    assert real[0] < 40.0
    assert 5.0 < real[5] < 8.0
    assert abs(real[4]) < 1e-9


def test_whole_codes(allocator: Allocator, paper_inverse: InverseCharacteristic) -> None:
    grid = firmware_grid(paper_inverse)
    exact = allocate(Demand(50.0, 3.0, 4.0, -6.0), 1.0, allocator=allocator, inverse=grid)
    whole = allocate(
        Demand(50.0, 3.0, 4.0, -6.0), 1.0, allocator=allocator, inverse=grid, round_codes=True
    )
    assert np.abs(whole.stern_code - exact.stern_code).max() <= 0.5
    assert (whole.stern_code == whole.stern_code.astype(int)).all()
    assert float(whole.bow_code) == int(whole.bow_code) > 0


def test_heave_goes_to_the_bow_and_brings_its_pitch_moment(
    allocator: Allocator, paper_inverse: InverseCharacteristic, paper_static: StaticCharacteristic
) -> None:
    made = allocate(
        Demand(0.0, heave_n=-10.0), 0.0, allocator=allocator, inverse=firmware_grid(paper_inverse)
    )
    real = achieved_wrench(
        made.stern_code,
        0.0,
        allocator=allocator,
        thruster=RealThruster.from_record(paper_static),
        bow_code=made.bow_code,
    )
    np.testing.assert_allclose(real[[2, 4]], [-10.0, 9.0], atol=0.05)
    assert (made.stern_code == 0).all()


def test_speed_along_the_inclined_axis_is_lower(
    allocator: Allocator, paper_static: StaticCharacteristic
) -> None:
    thruster = RealThruster.from_record(paper_static)
    paper, axis = (
        achieved_wrench(
            np.full(4, 100.0), 2.0, allocator=allocator, thruster=thruster, follow_axis=follow
        )[0]
        for follow in (False, True)
    )
    slower = 4 * COS * float(thruster.thrust(100.0, 2.0 * COS))
    assert axis == pytest.approx(slower)
    assert axis > paper
