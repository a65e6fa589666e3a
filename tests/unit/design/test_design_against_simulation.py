"""What balance and tether calculate is where simulated vehicles come to rest."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled, mmt300_bench
from scipy.spatial.transform import Rotation

from pipeline.actions.design import held_vehicle
from pipeline.design.balance import Condition, exact_balance, inflows_mps
from pipeline.design.balance_hull import BodyHull
from pipeline.design.balance_limits import TableLimits, table_limits
from pipeline.design.tether_held import HeldVehicle
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.physics.parameters import write
from pipeline.physics.tether_cable import Cable
from pipeline.physics.tether_static import solve_tether
from pipeline.simulate.context import BenchModel
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import initial_state, run
from pipeline.simulate.tether import LumpedMassTether
from pipeline.simulate.tethered import fly_tethered
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle


@pytest.fixture(scope="module")
def auv(repository: Path) -> Vehicle:
    return bundled(repository, "mmt300")


@pytest.fixture(scope="module")
def bench(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> BenchModel:
    return mmt300_bench(repository, tmp_path_factory)


@pytest.fixture(scope="module")
def rov(repository: Path) -> Vehicle:
    return bundled(repository, "rov8")


@pytest.mark.parametrize(("speed_mps", "more_n"), [(1.5, 10.0), (1.8, -15.0)])
def test_the_auv_settles_at_the_balance_with_the_residual_buoyancy_effect(
    auv: Vehicle, bench: BenchModel, speed_mps: float, more_n: float
) -> None:
    """The codes that the balance gives bring speed, angle of attack and loads within 1 %."""
    assert auv.model is not None
    assert auv.allocator is not None
    hull, own_n = BodyHull.of_model(auv.model, auv.water.gravity_mps2, auv.water.density_kgpm3)
    arm = auv.allocator.stern_arm_m
    condition = Condition(speed_mps, own_n + more_n, auv.allocator.delta_deg, arm, arm)
    balance = exact_balance(hull, condition)
    limits = table_limits(bench.static, 127.0, -127.0, "mmt300")
    assert isinstance(limits, TableLimits)
    inflows = inflows_mps(speed_mps, balance.alpha_rad, condition.angle_deg)
    code = {
        name: limits.code(load, inflow)
        for name, load, inflow in zip(
            ("left", "right", "upper", "lower"), balance.loads_n, inflows, strict=True
        )
    }
    # the balance knows four driven propellers: the bow one, which stands still, is not to drag
    packed = pack_vehicle(auv, bench)
    packed = replace(packed, thrust_tables=np.maximum(packed.thrust_tables, 0.0))
    specs = (parse_effect(f"residual_buoyancy:force_n={more_n}", packed.thruster_names),)
    vector = apply_effects(packed.vector, specs, packed.context)
    codes = np.array([code.get(name, 0.0) for name in packed.thruster_names], float)
    # not started at the answer: slower, and with the nose off by a degree
    pitch = balance.alpha_rad + np.radians(1.0)
    start = initial_state(
        attitude_rad=(0.0, pitch, 0.0), nu=(0.9 * speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0)
    )
    flown = run(packed, np.tile(codes, (8000, 1)), dt_s=0.1, vector=vector, start=start)
    u, w = flown.nu[-1, 0], flown.nu[-1, 2]
    assert np.abs(flown.nu_dot[-1]).max() < 1e-6
    assert np.hypot(u, w) == pytest.approx(speed_mps, rel=0.01)
    assert np.arctan2(w, u) == pytest.approx(balance.alpha_rad, rel=0.01)
    # level: it neither climbs nor sinks, so the buoyancy is carried
    assert flown.position_ned_m[-1, 2] - flown.position_ned_m[-21, 2] == pytest.approx(
        0.0, abs=0.01 * abs(balance.alpha_rad) * speed_mps
    )
    by_name = dict(zip(packed.thruster_names, flown.thrust_n[-1], strict=True))
    for name, load in zip(("left", "right", "upper", "lower"), balance.loads_n, strict=True):
        assert by_name[name] == pytest.approx(load, rel=0.01, abs=0.05)


def _at_rest(
    packed: PackedVehicle, vector: FloatArray, cable: LumpedMassTether, start: FloatArray
) -> tuple[FloatArray, float, FloatArray, FloatArray]:
    none = np.zeros((6000, len(packed.thruster_names)))
    flown, tether = fly_tethered(packed, none, cable, dt_s=0.02, vector=vector, start=start)
    turn = Rotation.from_quat(flown.quaternion[-1, [1, 2, 3, 0]])
    pull = turn.apply(tether.wrench_on_vehicle[-1, :3])
    return flown.position_ned_m[-1], float(turn.as_euler("ZYX")[0]), pull, flown.nu[-1]


def test_an_rov_that_lies_at_its_tether_needs_no_thrust_there(
    rov: Vehicle, make_rest: Callable[[Vehicle], PackedVehicle]
) -> None:
    """Run to rest in a current, heavy by an effect: our cable pulls as the simulated one."""
    packed = make_rest(rov)
    specs = tuple(
        parse_effect(text, packed.thruster_names)
        for text in ("current:north_mps=-0.5", "residual_buoyancy:force_n=-12")
    )
    # the Munk moment would turn it over in the flow: the calculation is of a level vehicle
    write(packed.vector, "coriolis_fraction", 0.0)
    vector = apply_effects(packed.vector, specs, packed.context)
    length, diameter = 12.0, 0.0075
    cable = LumpedMassTether(
        length,
        14,
        diameter_m=diameter,
        mass_kgpm=0.0442,
        normal_drag=1.2,
        tangential_drag=0.01,
        axial_stiffness_n=5e4,
        density_kgpm3=1000.0,
        gravity_mps2=9.82,
    )
    start = initial_state(position_ned_m=(-9.0, 0.0, 6.0))
    place, yaw, pull, nu = _at_rest(packed, vector, cable, start)
    assert np.abs(nu[:3]).max() < 2e-3
    wet = (0.0442 - 1000.0 * np.pi / 4 * diameter**2) * 9.82
    ours = solve_tether(
        Cable(length, diameter, 1.2, 0.01, wet, 5e4),
        start_m=place,
        end_m=np.zeros(3),
        flow=np.array([-0.5, 0.0, 0.0]),
        density_kgpm3=1000.0,
    ).force_on_start_n
    size = float(np.linalg.norm(pull))
    np.testing.assert_allclose(ours, pull, atol=0.01 * size)
    held = held_vehicle(rov, packed, heading_rad=yaw)
    held = HeldVehicle(
        packed, held.linear, held.quadratic, held.buoyancy_n - 12.0, yaw, np.zeros(3)
    )
    thrust, _, _ = held.required(ours, np.array([0.5, 0.0, 0.0]))
    assert np.linalg.norm(thrust) < 0.01 * size


@pytest.fixture
def make_rest() -> Callable[[Vehicle], PackedVehicle]:
    """Pack a vehicle whose cable is attached at its origin."""

    def make(vehicle: Vehicle) -> PackedVehicle:
        packed = pack_vehicle(vehicle)
        write(packed.vector, "tether_point", np.zeros(3))
        write(packed.vector, "tether_anchor", np.zeros(3))
        return packed

    return make


def test_the_lumped_tether_effect_slows_the_rov_to_the_speed_that_the_forces_balance(
    rov: Vehicle, make_rest: Callable[[Vehicle], PackedVehicle]
) -> None:
    """The drag area of the effect, beside the hull's drag, at the speed that the run ends with."""
    packed = make_rest(rov)
    spec = parse_effect("tether:drag_area_m2=0.05,pull_n=0", packed.thruster_names)
    vector = apply_effects(packed.vector, (spec,), packed.context)
    external = np.array([[40.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    none = np.zeros((1500, len(packed.thruster_names)))
    flown = run(packed, none, dt_s=0.02, vector=vector, external=external)
    velocity = flown.nu[-1, :3]
    held = held_vehicle(rov, packed)
    tether = -0.5 * 1000.0 * 0.05 * np.linalg.norm(velocity) * velocity
    force = held.drag_n(velocity) + tether
    assert force[0] == pytest.approx(-40.0, rel=0.01)
