"""From the vehicle file to the kernel's inputs, against hand-worked numbers."""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.records.fits import SignedFamily, ThrustFamily
from pipeline.simulate.context import BenchModel
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.pack_thrusters import bollard_table
from pipeline.vehicle.model_schema import FromBollard
from pipeline.vehicle.schema import Vehicle

THRUST = {"kind": "bollard", "thrust_max_n": 50.0, "thrust_min_n": -40.0}


def law(**keys: float) -> FromBollard:
    return FromBollard.model_validate(
        {**THRUST, "zero_thrust_speed_mps": 4.0, "dead_zone_code": 20.0, **keys}
    )


def test_carrier_by_hand(packed_vehicles: dict[str, PackedVehicle]) -> None:
    """192.9 + 30 + 20 kg; centres and inertia by the parallel-axis theorem."""
    vector = packed_vehicles["cargo_carrier"].vector
    assert read(vector, "mass") == pytest.approx(242.9)
    assert read(vector, "weight") == pytest.approx(242.9 * 9.81)
    assert read(vector, "buoyancy") == pytest.approx(1025 * 9.81 * (0.2 + 0.022 + 0.016))
    x = (30 * 0.25 - 20 * 0.5) / 242.9
    z = (192.9 * 0.04 + 30 * 0.07 + 20 * 0.13) / 242.9
    assert read(vector, "centre_of_mass") == pytest.approx([x, 0.0, z])
    xx = 16.1 + 192.9 * 0.04**2 + 0.62 + 30 * 0.07**2 + 0.26 + 20 * 0.13**2
    zz = 33.4 + 0.23 + 30 * 0.25**2 + 0.16 + 20 * 0.5**2
    xz = 30 * 0.25 * 0.07 - 20 * 0.5 * 0.13
    inertia = read(vector, "inertia")
    assert inertia[0, 0] == pytest.approx(xx)
    assert inertia[2, 2] == pytest.approx(zz)
    assert inertia[0, 2] == inertia[2, 0] == pytest.approx(-xz)
    lift = (0.2 * -0.04 + 0.022 * 0.07 + 0.016 * 0.13) / 0.238
    assert read(vector, "centre_of_buoyancy")[2] == pytest.approx(lift)


def test_the_munk_moment_is_counted_once(packed_vehicles: dict[str, PackedVehicle]) -> None:
    """mmt300: M = (A_33 - A_11) u w of C(nu) nu and the slope give -K_z alpha at 3 m/s together."""
    vector = packed_vehicles["mmt300"].vector
    added = read(vector, "added_mass")
    u, w = 3.0, 0.03
    moment = ((added[2, 2] - added[0, 0]) + float(read(vector, "pitch_lift_slope"))) * u * w
    assert moment == pytest.approx(-66.6 * w / u)
    yaw = ((added[0, 0] - added[1, 1]) + float(read(vector, "yaw_lift_slope"))) * u * w
    assert yaw == pytest.approx(66.6 * w / u)
    assert float(read(vector, "heave_lift_slope")) * u * w == pytest.approx(278.4 * w / u)


def test_strips_add_up_to_the_integrals(packed_vehicles: dict[str, PackedVehicle]) -> None:
    """A box of 1.2 m x 0.8 m x 0.6 m: area and second moment of area along x, no strip twice."""
    strips = packed_vehicles["cargo_carrier"].strips
    assert strips[:, 1].sum() == pytest.approx(1.2 * 0.6)
    assert strips[:, 2].sum() == pytest.approx(1.2 * 0.8)
    assert (strips[:, 1] * strips[:, 0] ** 2).sum() == pytest.approx(0.6 * 1.2**3 / 12)


@pytest.mark.parametrize("exponent", [1.33, 2.0, 3.0])
def test_bollard_law_at_rest_and_under_way(exponent: float) -> None:
    table, speed_step, code_step = bollard_table(law(exponent=exponent), 148)
    assert code_step == 148 / 128
    assert table.shape == (2, 41, 129)
    assert table[0, 0, -1] == 50.0
    assert table[1, 0, -1] == 40.0
    # at full code the thrust falls along a line to zero at V_0
    assert table[0, :, -1] == pytest.approx(50.0 * (1 - np.arange(41) * speed_step / 4.0))
    # code 74 = 64 steps: s = 54 / 128
    s = (74.0 - 20.0) / 128.0
    assert table[0, 0, 64] == pytest.approx(50.0 * s**exponent)
    q = s ** (exponent / 2)
    assert table[0, 10, 64] == pytest.approx(50.0 * max(q * (q - 0.25), 0.0))
    assert (table[:, :, code_step * np.arange(129) <= 20.0] == 0.0).all()


def test_exponent_two_is_a_shaft_speed_in_proportion_to_the_code() -> None:
    """T / T_max = s^2 (1 - (J / J_0)) with J / J_0 = (V / V_0) / s."""
    table, speed_step, _ = bollard_table(law(dead_zone_code=0.0), 128)
    s, v = 96 / 128, 12 * speed_step / 4.0
    assert table[0, 12, 96] == pytest.approx(50.0 * s**2 * (1 - v / s))


def test_rov8_is_near_the_measured_thruster(packed_vehicles: dict[str, PackedVehicle]) -> None:
    """T200 at 16 V, +-200 us of 400: 17.9 N and -14.1 N were measured."""
    packed = packed_vehicles["rov8"]
    rest = packed.thrust_tables[0, :, 0]
    codes = np.arange(rest.shape[1]) * packed.steps[0, 1]
    assert np.interp(200.0, codes, rest[0]) == pytest.approx(17.9, abs=1.0)
    assert np.interp(200.0, codes, rest[1]) == pytest.approx(14.1, abs=1.0)


def test_family_of_the_bench_is_taken_as_it_is(
    packed_vehicles: dict[str, PackedVehicle], bench: BenchModel
) -> None:
    packed, static = packed_vehicles["mmt300"], bench.static
    row = static.speed_mps.index(1.0)
    assert packed.steps[0].tolist() == [0.1, 1.0]
    thrust, family = packed.thrust_tables[0, 0, 10, 1:], np.array(static.thrust_n[row])
    assert thrust[family > 0.0].tolist() == family[family > 0.0].tolist()
    assert (thrust[family <= 0.0] <= 0.0).all()
    speed, code = np.array([1.0, 1.0]), np.array([80.0, 127.0])
    assert packed.shaft_speed(0, code, speed) == pytest.approx(
        [static.shaft_speed_rpm[row][79], static.shaft_speed_rpm[row][126]]
    )


def test_context_tells_what_is_known(packed_vehicles: dict[str, PackedVehicle]) -> None:
    mmt, rov = (packed_vehicles[name].context for name in ("mmt300", "rov8"))
    assert (mmt.thrust_falls_with_speed, rov.thrust_falls_with_speed) == (True, False)
    assert (mmt.walls, rov.walls) == (False, True)
    assert "shaft_speed" in mmt.measured
    assert "shaft_speed" not in rov.measured
    assert mmt.strips
    assert mmt.lagged


def test_without_a_model_there_is_nothing_to_simulate(vehicles: dict[str, Vehicle]) -> None:
    with pytest.raises(CannotComputeError, match="no model: section"):
        pack_vehicle(vehicles["rov8"].model_copy(update={"model": None}))


def test_without_bench_results_the_tables_are_missing(vehicles: dict[str, Vehicle]) -> None:
    with pytest.raises(CannotComputeError, match="rig2sea run mmt300"):
        pack_vehicle(vehicles["mmt300"])


def test_balance_in_time_needs_inertia_and_fits(
    vehicles: dict[str, Vehicle], bench: BenchModel
) -> None:
    vehicle = vehicles["mmt300"]
    assert vehicle.model is not None
    drive = vehicle.model.thrusters["at_drive"].model_copy(update={"balance_in_time": True})

    def changed(**keys: object) -> Vehicle:
        assert vehicle.model is not None
        thrusters = {"at_drive": drive.model_copy(update=keys)}
        model = vehicle.model.model_copy(update={"thrusters": thrusters})
        return vehicle.model_copy(update={"model": model})

    with pytest.raises(CannotComputeError, match="rotor_inertia_kgm2"):
        pack_vehicle(changed(rotor_inertia_kgm2=None), bench)
    with pytest.raises(CannotComputeError, match="fitted propeller and drive"):
        pack_vehicle(changed(), BenchModel(bench.static))
    packed = pack_vehicle(changed(), bench)
    assert read(packed.vector, "rotor_inertia")[:6].tolist() == [1.4e-4] * 5 + [0.0]
    assert not packed.context.lagged


def test_the_rate_of_a_shaft_by_hand(make_packed: Callable[..., PackedVehicle]) -> None:
    """The torque falls by 2 N m over 5 rev/s; the propeller takes 2 rho D^5 K_M n more a rev/s."""
    packed = replace(
        make_packed(),
        torque_tables=np.array([[[0.0, 0.0, 0.0], [10.0, 8.0, 6.0]]]),
        screws=np.array([[0.2, 0.0, 0.0, 0.0, 0.05, 0.0, 0.0, 5.0, 1.0]]),
    )
    for density in (1000.0, 2000.0, 1000.0):
        load = 2.0 * density * 0.2**5 * 0.05 * 10.0
        expected = (2.0 / 5.0 + load) / (2.0 * np.pi)
        assert packed.fastest_shaft_rate(0, density) == pytest.approx(expected, rel=1e-12)


def test_measured_thrust_and_the_gains_of_thrusters_are_flown(
    vehicles: dict[str, Vehicle],
) -> None:
    """`kind: mooring`: each sign as it was measured; no bench family is needed."""
    text = vehicles["mmt300"].model_dump()
    text["model"]["thrusters"]["at_drive"]["characteristic"] = {"kind": "mooring"}
    text["thrusters"] = [dict(one) for one in text["thrusters"]]
    text["thrusters"][1] |= {"gain_ahead": 0.8, "gain_reverse": 0.6}
    vehicle = Vehicle.model_validate(text)

    def side(sign: Literal[1, -1], largest_n: float) -> SignedFamily:
        rest = (0.0, largest_n / 3, largest_n)
        rows = (rest, tuple(t / 2 for t in rest))
        return SignedFamily(
            sign=sign, basis="measured", speed_mps=(0.0, 1.0), code=(0.0, 64.0, 128.0),
            thrust_n=rows, half95_n=rows,
        )  # fmt: skip

    family = ThrustFamily(positive=side(1, 42.0), negative=side(-1, 33.6))
    packed = pack_vehicle(vehicle, BenchModel(None, family=family))
    assert packed.thrust_tables.shape == (1, 2, 11, 3)
    assert packed.thrust_tables[0, :, 0, -1].tolist() == [42.0, 33.6]
    assert packed.thrust_tables[0, 1, -1, -1] == pytest.approx(16.8)
    assert packed.thrust_tables[0, 0, 5, -1] == pytest.approx(31.5)
    assert read(packed.vector, "thrust_gain")[:3].tolist() == [1.0, 0.8, 1.0]
    assert read(packed.vector, "reverse_gain")[1] == pytest.approx(0.75)
