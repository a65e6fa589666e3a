"""Runs of the bundled vehicles: effects, torque balance in time, the loop over the allocator."""

import dataclasses
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from pipeline.control.autopilot import Setpoint
from pipeline.effects.effect import Effect
from pipeline.effects.library import EffectSpec, apply_effects, candidates, effects
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read, write
from pipeline.simulate.context import BenchModel
from pipeline.simulate.fly import (
    FlightPlan,
    fly,
    general_allocator,
    join,
    run_changing,
    usual_step_s,
)
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import Trajectory, initial_state, run
from pipeline.simulate.sensors import Log, measure
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

VEHICLES = ("mmt300", "rov8", "cargo_carrier")
each_vehicle = pytest.mark.parametrize("name", VEHICLES)
each_effect = pytest.mark.parametrize("effect", effects().values(), ids=list(effects()))
#: In the pool of rov8, half a metre from its bottom; moving and turning in every axis.
START = initial_state(
    position_ned_m=(1.0, -0.5, 2.5),
    attitude_rad=(0.05, -0.1, 0.6),
    nu=(0.7, -0.2, 0.15, 0.1, -0.12, 0.2),
)


def spec_of(effect: Effect, packed: PackedVehicle, values: dict[str, float]) -> EffectSpec:
    target = packed.thruster_names[0] if effect.scope == "thruster" else None
    return EffectSpec(effect.id, values, target)


def commands_for(packed: PackedVehicle) -> FloatArray:
    """Five seconds in which every thruster works both ways."""
    time_s = 0.02 * np.arange(250)
    count = len(packed.thruster_names)
    phase = np.linspace(0.0, 3.0, count)
    return 0.8 * packed.code_limits[:, 1] * np.sin(1.5 * time_s[:, None] + phase)


def flown(packed: PackedVehicle, vector: FloatArray | None = None) -> Trajectory:
    return run(packed, commands_for(packed), dt_s=0.02, vector=vector, start=START)


def same(one: Trajectory, other: Trajectory) -> bool:
    pairs = zip(dataclasses.astuple(one), dataclasses.astuple(other), strict=True)
    return all(a.tobytes() == b.tobytes() for a, b in pairs)


def same_log(one: Log, other: Log) -> bool:
    def bits(log: Log) -> dict[str, tuple[bytes, bytes, bytes]]:
        return {
            name: (c.values.tobytes(), c.valid_s.tobytes(), c.logged_s.tobytes())
            for name, c in log.items()
        }

    return bits(one) == bits(other)


@each_vehicle
@each_effect
def test_effects_at_neutral_change_no_bit(
    packed_vehicles: dict[str, PackedVehicle], name: str, effect: Effect
) -> None:
    packed = packed_vehicles[name]
    spec = spec_of(effect, packed, effect.on(packed.context).neutral_values())
    if effect.id not in candidates(packed.context):
        with pytest.raises(CannotComputeError, match=effect.id):
            apply_effects(packed.vector, [spec], packed.context)
        return
    vector = apply_effects(packed.vector, [spec], packed.context)
    assert same(flown(packed, vector), flown(packed))


@each_vehicle
@each_effect
def test_candidates_change_the_motion_or_the_readings(
    packed_vehicles: dict[str, PackedVehicle],
    vehicles: dict[str, Vehicle],
    name: str,
    effect: Effect,
) -> None:
    packed, sensors = packed_vehicles[name], vehicles[name].sensors
    if effect.id not in candidates(packed.context):
        pytest.skip("no candidate for this vehicle")
    assert sensors is not None
    parameters = effect.on(packed.context).parameters
    values = {p.name: max(p.plausible, key=lambda v: abs(v - p.neutral)) for p in parameters}
    vector = apply_effects(packed.vector, [spec_of(effect, packed, values)], packed.context)
    with_it, without = flown(packed, vector), flown(packed)
    log = partial(measure, packed=packed, sensors=sensors, seed=3)
    if effect.id.startswith("dvl_"):
        assert same(with_it, without)
        one, other = log(with_it, vector=vector), log(without)
        assert not same_log({"dvl": one["dvl"]}, {"dvl": other["dvl"]})
        assert same_log({"imu": one["imu"]}, {"imu": other["imu"]})
    else:
        assert np.abs(with_it.nu - without.nu).max() > 1e-4


@each_vehicle
def test_every_angle_of_a_misaligned_thruster_tilts_it(
    packed_vehicles: dict[str, PackedVehicle], name: str
) -> None:
    """Five degrees make 5 degrees between stated and true thrust, whatever the direction is."""
    packed = packed_vehicles[name]
    for i, thruster in enumerate(packed.thruster_names):
        stated = read(packed.vector, "thruster_direction")[i]
        tilted = []
        for angle in ("azimuth_deg", "elevation_deg"):
            spec = EffectSpec("thruster_misalignment", {angle: 5.0}, thruster)
            vector = apply_effects(packed.vector, [spec], packed.context)
            write(vector, "thruster_count", float(len(packed.thruster_names)))
            tilted.append(push_of(packed, vector, i))
            assert np.degrees(np.arccos(tilted[-1] @ stated)) == pytest.approx(5.0, abs=1e-4)
        # the two turn it about axes at right angles
        across = [d - (d @ stated) * stated for d in tilted]
        assert across[0] @ across[1] == pytest.approx(0.0, abs=1e-12)


def push_of(packed: PackedVehicle, vector: FloatArray, index: int) -> FloatArray:
    """Direction in which a thruster pushes a sphere at rest."""
    vector = vector.copy()
    for slot in ("added_mass", "inertia", "linear_damping"):
        write(vector, slot, 0.0)
    write(vector, "inertia", np.eye(3))
    for slot in ("centre_of_mass", "centre_of_buoyancy", "weight", "buoyancy"):
        write(vector, slot, 0.0)
    write(vector, "lag", 0.0)
    commands = np.zeros((1, len(packed.thruster_names)))
    commands[0, index] = 0.9 * packed.code_limits[index, 1]
    force = run(packed, commands, dt_s=0.01, vector=vector).nu_dot[0, :3]
    return np.asarray(force / np.linalg.norm(force))


def test_tilts_of_a_thruster_ahead_and_of_vertical_ones_by_hand(
    make_packed: Callable[..., PackedVehicle],
) -> None:
    """Azimuth to starboard; elevation up, for one that pushes up towards the stern."""
    packed = make_packed()
    read(packed.vector, "thruster_direction")[:3] = np.array([[1, 0, 0], [0, 0, -1], [0, 0, 1.0]])
    a, e = np.radians(10.0), np.radians(20.0)
    read(packed.vector, "misalignment_azimuth")[:3] = a
    read(packed.vector, "misalignment_elevation")[:3] = e
    ahead, up, down = (push_of(packed, packed.vector, i) for i in range(3))
    ca, sa, ce, se = np.cos(a), np.sin(a), np.cos(e), np.sin(e)
    assert ahead == pytest.approx([ca * ce, sa * ce, -se])
    assert up == pytest.approx([-se, sa * ce, -ca * ce])
    assert down == pytest.approx([se, sa * ce, ca * ce])


@pytest.fixture(scope="module")
def in_time(vehicles: dict[str, Vehicle], bench: BenchModel) -> PackedVehicle:
    """mmt300 with the torque balance of its shafts solved in time."""
    vehicle = vehicles["mmt300"]
    assert vehicle.model is not None
    drive = vehicle.model.thrusters["at_drive"].model_copy(update={"balance_in_time": True})
    model = vehicle.model.model_copy(update={"thrusters": {"at_drive": drive}})
    return pack_vehicle(vehicle.model_copy(update={"model": model}), bench)


@pytest.mark.parametrize("speed_mps", [0.0, 0.5, 1.0, 1.5, 2.0])
def test_torque_balance_in_time_settles_onto_the_static_family(
    in_time: PackedVehicle, bench: BenchModel, speed_mps: float
) -> None:
    """Towed at a speed: so heavy that no thrust changes it, all thrusters along it."""
    vector = in_time.vector.copy()
    for slot in ("linear_damping", "quadratic_damping", "added_mass", "coriolis_fraction"):
        write(vector, slot, 0.0)
    write(vector, "mass", 1e12)
    write(vector, "inertia", 1e12 * np.eye(3))
    write(vector, "weight", float(read(vector, "buoyancy")))
    directions = read(vector, "thruster_direction")
    directions[:5] = [1.0, 0.0, 0.0]
    row = bench.static.speed_mps.index(speed_mps)
    status, thrust = bench.static.status[row], bench.static.thrust_n[row]
    codes = np.array(bench.static.code)
    found = []
    for begin in range(0, codes.size - 4, 5):
        commands = np.tile(codes[begin : begin + 5], (1000, 1))
        start = initial_state(nu=(speed_mps, 0, 0, 0, 0, 0))
        end = run(in_time, commands, dt_s=0.005, vector=vector, start=start)
        assert end.nu[-1, 0] == pytest.approx(speed_mps, abs=1e-6)
        found += end.thrust_n[-1].tolist()
    live = [i for i in range(len(found)) if status[i] == "live"]
    assert len(live) > 40
    errors = [abs(found[i] - thrust[i]) for i in live]
    assert max(errors) <= 0.1, codes[live[int(np.argmax(errors))]]


def test_a_shaft_takes_time_to_turn_up(in_time: PackedVehicle) -> None:
    commands = np.tile(np.array([100.0, -100, 100, 100, 100]), (200, 1))
    run_up = run(in_time, commands, dt_s=0.005)
    shaft = run_up.actuator
    assert shaft[0, 0] == 0.0
    # J = 1.4e-4 kg m^2 and about 1 N m: 20 rev/s in some hundredths of a second, not at once
    assert 0.05 < shaft[1, 0] / shaft[-1, 0] < 0.9
    assert np.all(np.diff(shaft[:40, 0]) >= -1e-9)
    # astern, at the same speed of the vehicle next to none, it mirrors
    np.testing.assert_allclose(shaft[:10, 1], -shaft[:10, 0], rtol=1e-3)


def test_a_step_too_large_for_a_shaft_is_refused_and_the_usual_one_fits(
    in_time: PackedVehicle, packed_vehicles: dict[str, PackedVehicle]
) -> None:
    with pytest.raises(CannotComputeError, match="too large for the shafts of mmt300"):
        run(in_time, np.full((10, 5), 50.0), dt_s=0.02)
    step_s = usual_step_s(in_time)
    assert step_s < 0.02
    assert round(0.1 / step_s) * step_s == pytest.approx(0.1)
    assert usual_step_s(packed_vehicles["mmt300"]) == pytest.approx(0.02)
    plan = MANOEUVRES["straight"].plan(in_time, 1.0, 5.0)
    assert fly(in_time, plan).time_s[1] == pytest.approx(step_s)


def test_lag_is_no_effect_where_the_shaft_is_solved_in_time(in_time: PackedVehicle) -> None:
    spec = EffectSpec("thruster_lag", {"lag_s": 0.2})
    with pytest.raises(CannotComputeError, match="balance of the shafts is solved in time"):
        apply_effects(in_time.vector, [spec], in_time.context)


@each_vehicle
def test_allocator_gives_the_wrench_that_was_asked(
    packed_vehicles: dict[str, PackedVehicle], name: str
) -> None:
    """Codes into thrust by the nominal characteristic, within the rounding of the code."""
    packed = packed_vehicles[name]
    allocator = general_allocator(packed)
    matrix = allocator.configuration()
    generator = np.random.default_rng(4)
    for _ in range(20):
        demand = matrix @ generator.uniform(-0.4, 0.6, matrix.shape[1]) * 20.0
        codes, _, saturated = allocator.decide(demand, np.zeros(6))
        assert not saturated
        assert codes.tolist() == np.round(codes).tolist()
        vector = packed.vector.copy()
        write(vector, "lag", 0.0)
        thrust = run(packed, codes[None], dt_s=1e-6, vector=vector).thrust_n[0]
        slope = np.abs(np.diff(packed.thrust_tables[:, :, 0], axis=2)).max() / packed.steps[0, 1]
        most = np.abs(matrix).sum(axis=1) * slope
        assert np.all(np.abs(matrix @ thrust - demand) <= 0.75 * most + 1e-9)


@each_vehicle
def test_allocator_knows_where_the_codes_end(
    packed_vehicles: dict[str, PackedVehicle], name: str
) -> None:
    packed = packed_vehicles[name]
    kinds = read(packed.vector, "thruster_type")[: len(packed.thruster_names)].astype(int)
    whole = general_allocator(packed)
    assert whole.largest_n.tolist() == packed.thrust_tables[kinds, 0, 0, -1].tolist()
    assert whole.smallest_n.tolist() == (-packed.thrust_tables[kinds, 1, 0, -1]).tolist()
    limits = packed.code_limits * np.array([0.5, 1.0])
    half = general_allocator(dataclasses.replace(packed, code_limits=limits))
    assert half.largest_n.tolist() == whole.largest_n.tolist()
    assert (half.smallest_n > 0.5 * whole.smallest_n).all()


def test_direction_of_a_demand_is_kept_where_reverse_codes_end_early(
    packed_vehicles: dict[str, PackedVehicle],
) -> None:
    packed = packed_vehicles["rov8"]
    limits = packed.code_limits * np.array([0.25, 1.0])
    allocator = general_allocator(dataclasses.replace(packed, code_limits=limits))
    demand = np.array([-60.0, 0, 0, 0, 0, 0])
    codes, wanted, cut = allocator.decide(demand, np.zeros(6))
    assert cut
    assert codes.min() == pytest.approx(limits[0, 0], abs=1.0)
    given = allocator.configuration() @ wanted
    assert -60.0 < given[0] < -5.0
    assert np.abs(given[1:]).max() < 1e-6 * abs(given[0])
    # a drive that does not turn back at all leaves its share out, and gives the rest
    one_way = general_allocator(
        dataclasses.replace(packed, code_limits=packed.code_limits * [0.0, 1.0])
    )
    codes, _, _ = one_way.decide(np.array([20.0, 0, 0, 0, 0, 2.0]), np.zeros(6))
    assert codes.max() > 28
    assert codes.min() >= 0


def test_round_off_is_no_command(packed_vehicles: dict[str, PackedVehicle]) -> None:
    """A heave demand leaves the horizontal thrusters at rest, not at the edge of the dead zone."""
    allocator = general_allocator(packed_vehicles["rov8"])
    codes, _, _ = allocator.decide(np.array([0, 0, -8.0, 0, 0, 0]), np.zeros(6))
    assert codes[:4].tolist() == [0, 0, 0, 0]
    assert (codes[4:] > 28).all()


def test_the_loop_believes_the_nominal_vehicle(packed_vehicles: dict[str, PackedVehicle]) -> None:
    """At rest the first command is the same whatever the true vehicle is; the motion is not."""
    packed = packed_vehicles["mmt300"]
    plan = MANOEUVRES["straight"].plan(packed, 1.0, 5.0)
    weak = EffectSpec("thrust_deduction", {"t": 0.3})
    true = apply_effects(packed.vector, [weak], packed.context)
    nominal, weakened = fly(packed, plan), fly(packed, plan, vector=true)
    assert nominal.command[0].tolist() == weakened.command[0].tolist()
    assert weakened.nu[100, 0] < 0.9 * nominal.nu[100, 0]


def test_runs_in_pieces_are_one_run(packed_vehicles: dict[str, PackedVehicle]) -> None:
    packed = packed_vehicles["cargo_carrier"]
    commands = commands_for(packed)
    whole = run(packed, commands, dt_s=0.02, start=START)
    first = run(packed, commands[:100], dt_s=0.02, start=START)
    rest = run(packed, commands[100:], dt_s=0.02, start=first.final_state, start_time_s=2.0)
    pieces = join([first, rest])
    assert pieces.nu.tobytes() == whole.nu.tobytes()
    assert pieces.command.tobytes() == whole.command.tobytes()
    assert pieces.time_s == pytest.approx(whole.time_s, abs=1e-12)

    def nothing(_time_s: float, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        return state, packed.vector

    changed = run_changing(packed, commands, nothing, [1.234, 99.0], dt_s=0.02, start=START)
    assert changed.nu.tobytes() == whole.nu.tobytes()


def test_a_demand_can_be_added_to_the_references(
    packed_vehicles: dict[str, PackedVehicle],
) -> None:
    """Under the depth hold a steady push ahead comes to the speed that it sustains."""
    packed = packed_vehicles["mmt300"]
    hold = Setpoint(depth_m=0.0, heading_rad=0.0, pitch_rad=0.0)
    push = np.array([40.0, 0, 0, 0, 0, 0])
    end = fly(packed, FlightPlan(40.0, reference=lambda _t: hold, wrench=lambda _t: push))
    u = end.nu[-1, 0]
    assert 2.0 * u + 22.5 * u * u == pytest.approx(40.0, rel=0.03)
