"""Flying on a tether under the autopilot: one stepping loop, the same run however it is cut."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.control.autopilot import Setpoint
from pipeline.errors import CannotComputeError
from pipeline.physics.winch import Winch
from pipeline.simulate import tethered_mover
from pipeline.simulate.fly import FlightPlan, fly, run_changing
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import initial_state
from pipeline.simulate.tethered import fly_tethered
from pipeline.simulate.tethered_mover import TetheredMover, WinchOrder, nominal_mover
from pipeline.vehicle.attachment_schema import Tether
from pipeline.vehicle.schema import Vehicle

Make = Callable[..., PackedVehicle]
POINT = (0.4, -0.1, -0.2)
CABLE = Tether(
    attachment_m=POINT,
    length_m=30.0,
    diameter_m=0.01,
    mass_kgpm=0.12,
    axial_stiffness_n=2e4,
    segments=10,
)
WINCH = Winch(0.2, 3.0, 60.0, 5.0, dry_friction_nm=2.0, brake_nm=80.0, shortest_m=8.0)
START = initial_state(position_ned_m=(12.0, 2.0, 8.0))


@pytest.fixture
def packed(make_packed: Make) -> PackedVehicle:
    return make_packed(tether_point=POINT, lag=np.full(12, 0.15))


def codes(steps: int) -> np.ndarray:
    return np.tile([60.0, 40.0, 50.0, 50.0, 20.0], (steps, 1))


def test_the_pieces_of_a_control_loop_are_one_run(
    packed: PackedVehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However a run is cut: by the loop, by what happens in it, by the memory of a piece."""
    whole, line = fly_tethered(
        packed,
        codes(200),
        CABLE,
        dt_s=0.02,
        start=START,
        winch=WINCH,
        winch_command=np.where(np.arange(200) < 100, 0.0, 0.5),
    )
    monkeypatch.setattr(tethered_mover, "_STEPS_AT_A_TIME", 30)
    mover = TetheredMover(CABLE, WINCH, [WinchOrder(2.0, 0.5)])
    cut = run_changing(
        packed,
        codes(200),
        lambda _time, state: (state, packed.vector),
        [0.5, 1.7],
        dt_s=0.02,
        start=START,
        mover=mover,
    )
    np.testing.assert_array_equal(cut.final_state, whole.final_state)
    np.testing.assert_array_equal(cut.nu, whole.nu)
    log = mover.log()
    np.testing.assert_allclose(log.time_s, whole.time_s, atol=1e-12)
    np.testing.assert_array_equal(log.lower_tension_n, line.lower_tension_n)
    np.testing.assert_array_equal(log.wrench_on_vehicle, line.wrench_on_vehicle)
    np.testing.assert_array_equal(log.paid_out_m, line.paid_out_m)
    np.testing.assert_array_equal(log.payout_mps, 0.2 * line.drum_speed_radps)
    assert log.paid_out_m[-1] > 30.3


def test_the_autopilot_holds_depth_against_the_cable(packed: PackedVehicle) -> None:
    """The pull of the cable is what the thrusters then carry on top."""
    plan = FlightPlan(
        40.0, lambda _t: Setpoint(depth_m=8.0, heading_rad=0.0, pitch_rad=0.0), start=START
    )
    free = fly(packed, plan)
    mover = TetheredMover(CABLE)
    held = fly(packed, plan, mover=mover)
    assert held.position_ned_m[-1, 2] == pytest.approx(8.0, abs=0.15)
    pull = float(mover.log().wrench_on_vehicle[-1, 2])
    assert pull > 1.0  # the weight of the hanging cable
    down = [run.thrust_n[-1] @ packed.vector[_directions(packed)][:, 2] for run in (free, held)]
    assert down[1] - down[0] == pytest.approx(-pull, rel=0.25)


def _directions(packed: PackedVehicle) -> np.ndarray:
    from pipeline.physics.parameters import offset

    count = len(packed.thruster_names)
    return offset("thruster_direction") + np.arange(3 * count).reshape(count, 3)


def test_a_taut_cable_can_be_flown_on(packed: PackedVehicle) -> None:
    """Stretched it is longer than what was paid out: no reason to refuse the next piece."""
    mover = TetheredMover(CABLE)
    state = initial_state(position_ned_m=(29.0, 0.0, 5.0))
    state[7] = 0.5
    reach = 0.0
    for k in range(40):
        piece = mover(packed, codes(10) * 2, dt_s=0.02, start=state, start_time_s=0.2 * k)
        state = piece.final_state
        assert mover.state is not None
        reach = max(reach, float(np.linalg.norm(mover.state.position_ned_m[-1])))
    assert mover.log().lower_tension_n.max() > 20.0
    assert reach > 30.0  # beyond the length that is paid out, between two pieces


def test_the_nominal_tether_of_a_vehicle_file(vehicles: dict[str, Vehicle]) -> None:
    carrier, rov = vehicles["cargo_carrier"].model, vehicles["rov8"].model
    assert carrier is not None
    assert rov is not None
    mover = nominal_mover(carrier, [WinchOrder(3.0, 0.4)])
    assert mover is not None
    assert mover.winch is not None
    assert mover.winch.drum_radius_m == pytest.approx(0.2)
    assert nominal_mover(rov) is None  # it has one, but not in the nominal model
    with pytest.raises(CannotComputeError, match="nominal model has no tether"):
        nominal_mover(rov, [WinchOrder(3.0, 0.4)])


def test_what_cannot_be_done_is_refused(packed: PackedVehicle) -> None:
    with pytest.raises(CannotComputeError, match="has no winch"):
        TetheredMover(CABLE, orders=[WinchOrder(0.0, 0.1)])
    with pytest.raises(CannotComputeError, match="1 m/s at most"):
        TetheredMover(CABLE, WINCH, [WinchOrder(0.0, 1.1)])
    far = initial_state(position_ned_m=(40.0, 0.0, 0.0))
    with pytest.raises(CannotComputeError, match="does not reach"):
        TetheredMover(CABLE)(packed, codes(2), dt_s=0.02, start=far)
    with pytest.raises(CannotComputeError, match="nothing was flown"):
        TetheredMover(CABLE).log()
