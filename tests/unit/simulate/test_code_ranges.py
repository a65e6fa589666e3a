"""Codes: how they are numbered, where they end, and what a higher voltage does beyond their end."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.effects.library import apply_effects, parse_effect
from pipeline.simulate.context import BenchModel
from pipeline.simulate.fly import general_allocator
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.pack_thrusters import stacked
from pipeline.simulate.run import run
from pipeline.simulate.sensors import measure
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import FromBollard, ThrusterModel
from pipeline.vehicle.schema import Vehicle


def with_model(vehicle: Vehicle, **keys: object) -> Vehicle:
    assert vehicle.model is not None
    return vehicle.model_copy(update={"model": vehicle.model.model_copy(update=keys)})


def rov(vehicles: dict[str, Vehicle], dead: float = 0.0, **limits: int) -> PackedVehicle:
    """rov8 with other ends of its codes."""
    vehicle = vehicles["rov8"]
    assert vehicle.model is not None
    drive = vehicle.drives["t200_esc"].model_copy(update=limits)
    behaviour = vehicle.model.thrusters["t200_esc"]
    if dead:
        curve = behaviour.characteristic.model_copy(update={"dead_zone_code": dead})
        behaviour = behaviour.model_copy(update={"characteristic": curve})
    vehicle = with_model(vehicle, thrusters={"t200_esc": behaviour})
    return pack_vehicle(vehicle.model_copy(update={"drives": {"t200_esc": drive}}))


def renumbered(vehicle: Vehicle, bench: BenchModel, times: int) -> PackedVehicle:
    """mmt300 with its shafts in time, and the code numbers of its drive `times` as large."""
    assert vehicle.model is not None
    assert bench.surface is not None
    largest = 127 * times
    drive = vehicle.drives["at_drive"].model_copy(
        update={"code_max": largest, "code_min": -largest}
    )
    behaviour = vehicle.model.thrusters["at_drive"].model_copy(update={"balance_in_time": True})
    vehicle = with_model(vehicle, thrusters={"at_drive": behaviour})
    surface = replace(
        bench.surface,
        code_scale=bench.surface.code_scale * times,
        band_code=bench.surface.band_code * times,
    )
    old = np.array([0.0, *bench.static.code])
    code = np.arange(1.0, largest + 1.0)

    def finer(rows: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(np.interp(code / times, old, [0.0, *row]).tolist()) for row in rows)

    static = bench.static.model_copy(
        update={
            "code": tuple(code.tolist()),
            "thrust_n": finer(bench.static.thrust_n),
            "shaft_speed_rpm": finer(bench.static.shaft_speed_rpm),
        }
    )
    changed = vehicle.model_copy(update={"drives": {"at_drive": drive}})
    return pack_vehicle(changed, BenchModel(static, bench.propeller, surface))


def test_the_shaft_of_a_renumbered_drive_turns_alike(
    vehicles: dict[str, Vehicle], bench: BenchModel
) -> None:
    """The same drive with codes 0 to 254: code 120 is what code 60 was."""
    command = np.array([60.0, 60, 60, 60, 20])
    ends = []
    for times in (1, 2):
        packed = renumbered(vehicles["mmt300"], bench, times)
        flown = run(packed, np.tile(times * command, (1000, 1)), dt_s=0.005)
        ends.append((flown.actuator[-1], flown.thrust_n[-1], flown.nu[-1]))
    for one, other in zip(*ends, strict=True):
        np.testing.assert_allclose(other, one, rtol=2e-3, atol=1e-4)


def test_a_table_that_ends_earlier_goes_on_along_its_slope() -> None:
    short = np.ones((2, 3, 128)) * np.arange(128.0) - np.arange(3.0)[:, None]
    both = stacked([short, np.zeros((2, 5, 131))])
    expected = np.ones((2, 5, 131)) * np.arange(131.0) - np.arange(5.0)[:, None]
    np.testing.assert_allclose(both[0], expected)


def stern_thrust(packed: PackedVehicle, drop: float) -> float:
    specs = [parse_effect(f"voltage_sag:drop={drop}")]
    vector = apply_effects(packed.vector, specs, packed.context)
    commands = np.tile([127.0, 0, 0, 0, 0], (60, 1))
    return float(run(packed, commands, dt_s=0.02, vector=vector).thrust_n[-1, 0])


def test_a_second_kind_of_drive_changes_nothing_of_the_first(
    vehicles: dict[str, Vehicle], bench: BenchModel, packed_vehicles: dict[str, PackedVehicle]
) -> None:
    """A bow with a bollard curve: the stern's thrust at a higher voltage stays as it was."""
    vehicle = vehicles["mmt300"]
    assert vehicle.model is not None
    curve = FromBollard(
        kind="bollard", thrust_max_n=5.0, thrust_min_n=-5.0, zero_thrust_speed_mps=3.0
    )
    mixed = with_model(
        vehicle,
        thrusters={**vehicle.model.thrusters, "small": ThrusterModel(characteristic=curve)},
    )
    thrusters = tuple(
        one.model_copy(update={"drive": "small"}) if one.name == "bow" else one
        for one in vehicle.thrusters
    )
    drives = {**vehicle.drives, "small": vehicle.drives["at_drive"]}
    mixed = mixed.model_copy(update={"thrusters": thrusters, "drives": drives})
    # the two bows stand still, and drag differently: here neither does
    packed, first = (
        replace(one, thrust_tables=np.maximum(one.thrust_tables, 0.0))
        for one in (pack_vehicle(mixed, bench), packed_vehicles["mmt300"])
    )
    for drop in (0.0, -0.15):
        alone = stern_thrust(first, drop)
        assert stern_thrust(packed, drop) == pytest.approx(alone, rel=1e-9)
    assert alone > 1.15 * stern_thrust(first, 0.0)


def test_the_logged_shaft_speed_follows_a_higher_voltage(
    vehicles: dict[str, Vehicle], packed_vehicles: dict[str, PackedVehicle]
) -> None:
    """Thrust goes about with the shaft speed squared, beyond the last code of the bench too."""
    packed, sensors = packed_vehicles["mmt300"], vehicles["mmt300"].sensors
    assert sensors is not None
    commands = np.tile([127.0, 0, 0, 0, 0], (150, 1))

    def end(drop: float) -> tuple[float, float]:
        specs = [parse_effect(f"voltage_sag:drop={drop}")]
        vector = apply_effects(packed.vector, specs, packed.context)
        flown = run(packed, commands, dt_s=0.02, vector=vector)
        speed = measure(flown, packed, sensors, vector=vector)["shaft_speed"].values[-20:, 0]
        return float(flown.thrust_n[-1, 0]), float(np.nanmean(speed))

    (thrust, speed), (more, faster) = end(0.0), end(-0.15)
    assert (faster / speed) ** 2 == pytest.approx(more / thrust, abs=0.08)
    assert faster / speed > 1.08


@pytest.mark.parametrize(
    ("limits", "command", "expected"),
    [
        ({"code_min": -250}, -400.0, -250.0),
        ({"code_min": 0}, -300.0, 0.0),
        ({"code_min": -600}, -600.0, -400.0),  # the curve ends at -code_max
        ({}, 500.0, 400.0),
    ],
)
def test_a_command_beyond_the_codes_is_held_at_their_end(
    vehicles: dict[str, Vehicle], limits: dict[str, int], command: float, expected: float
) -> None:
    packed = rov(vehicles, **limits)

    def thrust(code: float) -> FloatArray:
        return run(packed, np.full((100, 8), code), dt_s=0.02).thrust_n[-1]

    np.testing.assert_array_equal(thrust(command), thrust(expected))


def test_the_smallest_thrust_belongs_to_the_largest_code(vehicles: dict[str, Vehicle]) -> None:
    """thrust_min_n is that of -code_max: a range that ends before leaves the curve as it is."""
    commands = np.full((100, 8), -250.0)
    one = run(rov(vehicles), commands, dt_s=0.02).thrust_n
    other = run(rov(vehicles, code_min=-250), commands, dt_s=0.02).thrust_n
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("lowest", [-20, 0])
def test_reverse_codes_inside_the_dead_zone_leave_the_other_demands(
    vehicles: dict[str, Vehicle], lowest: int
) -> None:
    """A drive that gives nothing backwards loses its share of a demand, not the demand."""
    allocator = general_allocator(rov(vehicles, dead=28.0, code_min=lowest))
    demand = np.array([20.0, 0, 0, 0, 0, 2.0])
    codes, _, cut = allocator.decide(demand, np.zeros(6))
    assert not cut
    assert (codes[[0, 1, 2, 3]] > 50).sum() >= 2
    full, _, _ = general_allocator(rov(vehicles, dead=28.0)).decide(demand, np.zeros(6))
    np.testing.assert_array_equal(codes[full > 0], full[full > 0])
