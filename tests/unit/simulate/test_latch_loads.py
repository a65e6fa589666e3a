"""What the latches carry: against the equations of the vehicle without the module, and by hand."""

import numpy as np
import pytest

from pipeline.physics.parameters import read, write
from pipeline.simulate.events import PayloadEvent, PayloadSchedule, latch_loads, vector_with_modules
from pipeline.simulate.fly import fly, run_changing
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import initial_state, run
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vehicle


@pytest.fixture
def carrier(packed_vehicles: dict[str, PackedVehicle]) -> PackedVehicle:
    return packed_vehicles["cargo_carrier"]


@pytest.fixture
def model(vehicles: dict[str, Vehicle]) -> Model:
    found = vehicles["cargo_carrier"].model
    assert found is not None
    return found


def test_the_load_is_what_moves_the_carrier_without_its_module(
    carrier: PackedVehicle, model: Model
) -> None:
    """The bare carrier with the latch's wrench from outside accelerates as both together do."""
    true = carrier.vector.copy()
    write(true, "current", np.array([0.3, -0.2, 0.1]))
    start = initial_state(position_ned_m=(0, 0, 10), attitude_rad=(0.3, -0.2, 1.0))
    start[7:13] = [0.6, -0.2, 0.3, 0.3, -0.2, 0.4]
    codes = np.tile([50.0, 30, -20, 60, 80, 10, 0, 40], (50, 1))
    flown = run(carrier, codes, dt_s=0.02, vector=true, start=start)
    loads = {one.module: one for one in latch_loads(flown, carrier, model, [], vector=true)}
    bare = vector_with_modules(carrier, model, frozenset({"module_2"}))
    write(bare, "current", read(true, "current"))
    for k in (0, 20, 49):
        state = flown.final_state.copy()
        state[:3], state[3:7], state[7:13] = (
            flown.position_ned_m[k],
            flown.quaternion[k],
            flown.nu[k],
        )
        state[13 : 13 + 8] = flown.actuator[k]
        alone = run(
            carrier,
            codes[k : k + 1],
            dt_s=0.02,
            vector=bare,
            start=state,
            external=loads["module_1"].wrench[k : k + 1],
        )
        np.testing.assert_allclose(alone.nu_dot[0], flown.nu_dot[k], atol=1e-9)


def test_only_while_it_is_held_and_with_the_blow_of_closing(
    carrier: PackedVehicle, model: Model
) -> None:
    events = [PayloadEvent(1.0, "release", "module_1"), PayloadEvent(3.0, "attach", "module_1")]
    schedule = PayloadSchedule(carrier, model, events)
    start = initial_state(position_ned_m=(0, 0, 10), nu=(0.8, 0, 0, 0, 0, 0))
    flown = run_changing(
        carrier, np.zeros((200, 8)), schedule.change, [1.0, 3.0], dt_s=0.02, start=start
    )
    load, other = latch_loads(flown, carrier, model, schedule.outcomes, vector=carrier.vector)
    assert load.module == "module_1"
    assert load.time_s.size == 50 + 51
    assert load.time_s[49] < 1.0
    assert load.time_s[50] == pytest.approx(3.0)
    assert other.time_s.size == 201
    # 30 kg at rest to what is left of 0.8 m/s, over 0.2 s, a half sine
    impulse = np.linalg.norm(schedule.outcomes[1].impulse[:3])
    assert load.closing_n == pytest.approx(impulse * np.pi / 0.4)
    assert impulse == pytest.approx(30.0 * np.linalg.norm(flown.nu[150, :3]), rel=0.2)
    assert load.largest_share == pytest.approx(max(load.share.max(), load.closing_share))
    assert load.largest_share >= load.closing_n / 750.0
    assert other.closing_n == 0.0


def test_a_module_is_held_until_it_leaves_not_until_its_stated_time(
    carrier: PackedVehicle, model: Model
) -> None:
    """Flown, an event waits for the next command: 1.21 s becomes 1.3 s."""
    schedule = PayloadSchedule(carrier, model, [PayloadEvent(1.21, "release", "module_1")])
    plan = MANOEUVRES["hover"].plan(carrier, 1.0, 2.0)
    flown = fly(carrier, plan, change=schedule.change)
    load = latch_loads(flown, carrier, model, schedule.outcomes, vector=carrier.vector)[0]
    jump = np.abs(np.diff(flown.nu_dot[:, 2])).argmax()
    assert flown.time_s[jump + 1] == pytest.approx(1.3)
    assert load.time_s[-1] == pytest.approx(flown.time_s[jump])
    assert schedule.outcomes[0].time_s == pytest.approx(1.3)


def test_at_rest_a_module_hangs_with_its_wet_weight(carrier: PackedVehicle, model: Model) -> None:
    flown = run(carrier, np.zeros((1, 8)), dt_s=0.02, start=initial_state(position_ned_m=(0, 0, 9)))
    load = latch_loads(flown, carrier, model, [], vector=carrier.vector)[0]
    wet = 9.81 * (30.0 - 1025.0 * 0.022)
    assert load.wrench[0, 2] == pytest.approx(wet, rel=0.03)  # less the slow rise of both
    assert load.share[0] == pytest.approx(load.wrench[0, 2] / 750.0, rel=0.02)


def test_modules_without_a_latch_are_passed_over(carrier: PackedVehicle, model: Model) -> None:
    bare = model.model_copy(
        update={"payloads": tuple(one.model_copy(update={"latch": None}) for one in model.payloads)}
    )
    flown = run(carrier, np.zeros((1, 8)), dt_s=0.02)
    assert latch_loads(flown, carrier, bare, [], vector=carrier.vector) == []
