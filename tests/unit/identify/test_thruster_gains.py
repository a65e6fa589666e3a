"""Gains of thrusters on simulated runs whose truth is known, and the algebra under them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled, mmt300_bench

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.identify.gain_estimates import (
    ALL,
    Doubt,
    Gain,
    GainSet,
    RunGains,
    gaussian_posterior,
    pool,
)
from pipeline.identify.gain_findings import findings_of
from pipeline.identify.gain_tests import adjusted, other_layouts
from pipeline.identify.heading_check import heading_check
from pipeline.identify.run_motion import run_motion
from pipeline.identify.thruster_gains import gains_of
from pipeline.identify.thruster_regression import RunLikelihood
from pipeline.records.gains import ThrusterGain, ThrusterGains
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import levers
from pipeline.simulate.context import model_of
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

WEAK = "vertical_rear_left"


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle(bundled_vehicle("rov8"))


@pytest.fixture(scope="module")
def packed(vehicle: Vehicle) -> PackedVehicle:
    return pack_vehicle(vehicle)


@pytest.fixture(scope="module")
def sensors(vehicle: Vehicle) -> Sensors:
    assert vehicle.sensors is not None
    return vehicle.sensors


def flown(packed: PackedVehicle, sensors: Sensors, *effects: str, seed: int = 1) -> RunTable:
    """A multisine of all axes, measured."""
    specs = [parse_effect(text, packed.thruster_names) for text in effects]
    vector = apply_effects(packed.vector, specs, packed.context)
    trajectory = fly(packed, MANOEUVRES["multisine"].plan(packed, 1.0, 40.0), vector=vector)
    log = measure(trajectory, packed, sensors, vector=vector, seed=seed)
    return table_of_log(log, sensors, name=f"run-{seed}")


@pytest.fixture(scope="module")
def healthy(packed: PackedVehicle, sensors: Sensors) -> RunTable:
    return flown(packed, sensors)


def asked(vehicle: Vehicle, packed: PackedVehicle, *runs: RunTable) -> ThrusterGains:
    assert vehicle.sensors is not None
    return gains_of(packed, vehicle.sensors, runs, uncertainty=model_of(vehicle).uncertainty)


def row(gains: ThrusterGains, thruster: str, axis: str = "all") -> ThrusterGain:
    return next(one for one in gains.gains if (one.thruster, one.axis) == (thruster, axis))


def test_a_healthy_vehicle_gives_one_everywhere_and_nothing_is_found(
    vehicle: Vehicle, packed: PackedVehicle, healthy: RunTable
) -> None:
    """All intervals hold 1, on single axes and on all; no finding, no delay."""
    gains = asked(vehicle, packed, healthy)
    assert gains.findings == ()
    assert gains.not_judged == {}
    assert gains.runs[0].delay_s == 0.0
    for name in packed.thruster_names:
        one = row(gains, name)
        assert one.judged
        assert one.ci95 is not None
        assert one.ci95[0] < 1.0 < one.ci95[1]
        assert one.ci95[1] - one.ci95[0] < 0.7
    yaw = row(gains, "front_left", "yaw")
    assert yaw.value == pytest.approx(1.0, abs=0.1)
    assert yaw.ci95 is not None
    assert yaw.ci95[0] < 1.0 < yaw.ci95[1]


def test_a_weak_thruster_is_named_with_its_size(
    vehicle: Vehicle, packed: PackedVehicle, sensors: Sensors
) -> None:
    """0.5 of its thrust: the interval holds it, and no other thruster is accused."""
    gains = asked(
        vehicle, packed, flown(packed, sensors, f"thruster_degraded:thrust_fraction=0.5@{WEAK}")
    )
    assert [(one.kind, one.thrusters) for one in gains.findings] == [("weak", (WEAK,))]
    one = row(gains, WEAK)
    assert one.ci95 is not None
    assert one.ci95[0] < 0.5 < one.ci95[1]
    assert gains.findings[0].runs == ("run-1",)
    assert gains.findings[0].p_value <= gains.false_alarms


def test_a_thruster_that_is_commanded_and_does_nothing_is_dead(
    vehicle: Vehicle, packed: PackedVehicle, healthy: RunTable
) -> None:
    """Its commands are written into a healthy log: held levels of 40 %, or none."""
    still = healthy.values["command"].copy()
    column = packed.thruster_names.index(WEAK)
    size = 0.4 * float(packed.code_limits[column, 1])
    levels = np.random.default_rng(3).choice([-size, 0.0, size], still.shape[0] // 75 + 1)
    still[:, column] = np.repeat(levels, 75)[: still.shape[0]]
    # the thrust that the vehicle did get is then nobody's, which the others have to bear
    table = replace(healthy, values=healthy.values | {"command": still})
    found = {one.kind: one.thrusters for one in asked(vehicle, packed, table).findings}
    assert found.get("dead") == (WEAK,)


LEVERS = np.array([[1.0, 1.0], *np.zeros((4, 2)), [0.2, -0.2]])
SURE, NOTHING = (1.0, 0.1), (0.05, 0.05)


def gains_told(name: str, *gains: tuple[float, float], **axes: tuple[float, float]) -> RunGains:
    """A run of two thrusters of `LEVERS`: gains on all axes, and of the left one by axis."""
    likelihood = RunLikelihood(name, (), 0.0, np.ones(2), np.ones(2, bool), {})
    by_axis = {ALL: gains} | {axis: (left, SURE) for axis, left in axes.items()}
    told = {
        (thruster, axis): Gain(*own, 30, runs=(name,))
        for axis, both in by_axis.items()
        for thruster, own in zip(("left", "right"), both, strict=True)
    }
    return RunGains(likelihood, told, told, None)


def kinds(asked: RunGains, *sound: RunGains) -> set[str]:
    """What is found of a run beside sound ones."""
    names, doubt = ("left", "right"), Doubt(0.1, 0.05)
    both = (GainSet(names, LEVERS, doubt, runs) for runs in ((asked,), sound))
    return {one.kind for one in findings_of(*both)}


def test_no_thruster_is_dead_where_none_of_the_run_is_seen_to_push() -> None:
    """Nor one of which sound runs do not show either that it gives anything."""
    known = [gains_told(f"sound-{k}", SURE, SURE) for k in range(3)]
    assert "dead" in kinds(gains_told("one", NOTHING, SURE), *known)
    assert "dead" not in kinds(gains_told("both", NOTHING, NOTHING), *known)
    unseen = [gains_told(f"sound-{k}", (0.02, 0.05), SURE) for k in range(3)]
    assert "dead" not in kinds(gains_told("one", NOTHING, SURE), *unseen)


def test_a_dead_thruster_is_told_by_one_axis_where_no_other_is_against() -> None:
    """All axes together are too vague for the little that sound runs gave; yaw alone is not."""
    little, vague, clear = (0.35, 0.05), (0.0, 0.08), (0.0, 0.01)
    sound = [gains_told(f"sound-{k}", little, SURE, yaw=little) for k in range(3)]
    assert "dead" not in kinds(gains_told("all", vague, SURE), *sound)
    assert "dead" in kinds(gains_told("yaw", vague, SURE, yaw=clear), *sound)
    against = gains_told("surge", vague, SURE, yaw=clear, surge=(0.3, 0.05))
    assert "dead" not in kinds(against, *sound)
    # what the file says of one axis is no evidence, nor is an axis that it gives no lever on
    assert "dead" not in kinds(gains_told("file", (0.0, 0.2), SURE, yaw=clear))
    assert "dead" not in kinds(gains_told("sway", vague, SURE, sway=clear), *sound)


def test_axes_that_are_asked_one_by_one_raise_no_false_alarms() -> None:
    """A thruster at the limit, half of what it gave, is called dead in 1 % of runs at most."""
    sound = [gains_told(f"sound-{k}", SURE, SURE, surge=SURE, yaw=SURE) for k in range(3)]
    draws = np.random.default_rng(1).normal(0.5, 0.15, (300, 3))
    found = [
        "dead" in kinds(gains_told("one", (a, 0.15), SURE, surge=(b, 0.15), yaw=(c, 0.15)), *sound)
        for a, b, c in draws.tolist()
    ]
    assert sum(found) <= 3


def test_exchanged_commands_are_a_swapped_pair(
    vehicle: Vehicle, packed: PackedVehicle, healthy: RunTable
) -> None:
    """Two columns of the commands are exchanged in a healthy log."""
    command = healthy.values["command"].copy()
    command[:, [4, 7]] = command[:, [7, 4]]
    table = replace(healthy, values=healthy.values | {"command": command})
    gains = asked(vehicle, packed, table)
    pair = tuple(packed.thruster_names[k] for k in (4, 7))
    assert ("swapped", pair) in [(one.kind, one.thrusters) for one in gains.findings]


def test_a_heading_that_counts_the_other_way_is_said(
    vehicle: Vehicle, packed: PackedVehicle, healthy: RunTable
) -> None:
    """Only the heading is turned over: roll, pitch and the gyroscope stay."""
    w, x, y, z = healthy.values["attitude"].T
    heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    # a turn by -2 psi about down, before the rest: the same roll and pitch, the heading negative
    c, s = np.cos(-heading), np.sin(-heading)
    turned = np.column_stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w])
    table = replace(healthy, values=healthy.values | {"attitude": turned})
    sound = heading_check(packed, healthy, 0.0)
    other = heading_check(packed, table, 0.0)
    assert sound is not None
    assert sound.correlation > 0.7
    assert other is not None
    assert other.correlation < -0.7
    found = [
        one for one in asked(vehicle, packed, table).findings if one.kind == "heading_reversed"
    ]
    assert len(found) == 1
    assert "counts the other way" in found[0].text


def test_without_a_velocity_the_rates_and_accelerations_still_tell(
    vehicle: Vehicle, packed: PackedVehicle, healthy: RunTable
) -> None:
    """Gyroscope, accelerometer, attitude and depth alone."""
    kept = ("command", "angular_velocity", "specific_force", "attitude", "depth")
    table = replace(
        healthy,
        values={name: healthy.values[name] for name in kept},
        valid={name: healthy.valid[name] for name in kept},
    )
    gains = asked(vehicle, packed, table)
    assert gains.findings == ()
    assert row(gains, "front_left", "yaw").value == pytest.approx(1.0, abs=0.15)
    assert sum(row(gains, name).judged for name in packed.thruster_names) >= 6


def test_thrusters_that_stand_still_are_not_judged(
    vehicle: Vehicle, packed: PackedVehicle, healthy: RunTable
) -> None:
    """No number is made up for them, and the record says why."""
    command = healthy.values["command"].copy()
    command[:, 0] = 0.0
    table = replace(healthy, values=healthy.values | {"command": command})
    gains = asked(vehicle, packed, table)
    name = packed.thruster_names[0]
    assert row(gains, name).value is None
    assert gains.not_judged[name] == "not commanded in any of these runs"


def test_a_run_without_what_it_takes_says_so(
    vehicle: Vehicle, packed: PackedVehicle, healthy: RunTable
) -> None:
    """Without commands, or without any acceleration, there is a reason and no row."""
    bare = replace(healthy, name="bare", values={"command": healthy.values["command"]})
    still = replace(healthy, name="still", values=dict(list(healthy.values.items())[1:]))
    gains = asked(vehicle, packed, bare, still)
    assert gains.gains == ()
    assert "no acceleration can be found" in gains.why_no_run["bare"]
    assert "no thruster commands" in gains.why_no_run["still"]


def test_against_a_reference_the_file_does_not_matter(
    vehicle: Vehicle, packed: PackedVehicle, sensors: Sensors, healthy: RunTable
) -> None:
    """A run of the same vehicle gives what it gave, whatever its name; its own is left out."""
    again = flown(packed, sensors, seed=2)
    gains = gains_of(
        packed,
        sensors,
        [healthy],
        uncertainty=model_of(vehicle).uncertainty,
        reference=[healthy, again],
        reference_name="24 May",
    )
    known = row(gains, WEAK).reference
    assert known is not None
    assert (known.runs, known.name) == (("run-2",), "24 May")
    assert known.ratio_ci95 is not None
    assert known.ratio_ci95[0] < 1.0 < known.ratio_ci95[1]
    assert gains.findings == ()


def test_the_rate_of_the_attitude_stands_for_a_gyroscope(
    packed: PackedVehicle, sensors: Sensors, healthy: RunTable
) -> None:
    """Rates from quaternions agree with those of the gyroscope."""
    values = {name: v for name, v in healthy.values.items() if name != "angular_velocity"}
    other = run_motion(packed, sensors, replace(healthy, values=values))
    own = run_motion(packed, sensors, healthy)
    assert other.sources[3:] == ("attitude",) * 3
    rows = slice(100, -100)
    for k in range(3, 6):
        together = np.corrcoef(own.nu[rows, k], other.nu[rows, k])[0, 1]
        assert together > 0.85


def test_levers_are_those_of_the_vehicle_file(vehicle: Vehicle, packed: PackedVehicle) -> None:
    """Force along the direction, moment r x d."""
    arms = levers(packed)
    for k, thruster in enumerate(vehicle.thrusters):
        direction = np.array(thruster.direction) / np.linalg.norm(thruster.direction)
        assert arms[:3, k] == pytest.approx(direction)
        assert arms[3:, k] == pytest.approx(np.cross(thruster.position_m, direction))


def test_pooling_tells_scatter_between_runs_from_noise() -> None:
    """Three that agree have none; three that differ by more than their errors have some."""
    alike = pool([1.0, 1.01, 0.99], [0.1, 0.1, 0.1])
    apart = pool([0.5, 1.0, 1.5], [0.1, 0.1, 0.1])
    assert alike.between == 0.0
    assert apart.between == pytest.approx(0.49, abs=0.02)
    assert apart.half_width > 4 * alike.half_width


def test_evidence_is_that_of_the_gaussian_integral() -> None:
    """One dimension, against the density of the sum of two normal variables."""
    information, vector = np.array([[4.0]]), np.array([2.0])
    _, _, found = gaussian_posterior(information, vector, np.array([1.0]), np.array([[9.0]]))
    grid = np.linspace(-60.0, 60.0, 400_001)
    prior = np.exp(-0.5 * (grid - 1.0) ** 2 / 9.0) / np.sqrt(2 * np.pi * 9.0)
    integral = np.trapezoid(prior * np.exp(-2.0 * grid**2 + 2.0 * grid), grid)
    assert found == pytest.approx(np.log(integral), abs=1e-6)


def test_holm_rejects_step_by_step() -> None:
    """The second smallest is held against one comparison less."""
    p = [0.004, 0.2, 0.003, 0.9]
    assert (adjusted(p) <= 0.012).tolist() == [True, False, True, False]
    assert not (adjusted(p) <= 0.011).any()
    assert adjusted(p) == pytest.approx([0.012, 0.4, 0.012, 0.9])


def test_thrusters_that_do_the_same_cannot_be_exchanged(packed: PackedVehicle) -> None:
    """A pair with the same levers is no hypothesis."""
    arms = levers(packed)
    twin = np.column_stack([arms[:, 0], arms[:, 0], arms[:, 1]])
    pairs = [one.thrusters for one in other_layouts(twin) if one.kind == "swapped"]
    assert (0, 1) not in pairs
    assert (0, 2) in pairs


@pytest.mark.parametrize("seed", [0, 4])
def test_noise_of_the_velocity_is_no_thrust_without_effect(
    repository: Path, tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    """Under way the thrust falls with the speed as drag rises, by its noise as well."""
    vehicle = bundled(repository, "mmt300")
    packed = pack_vehicle(vehicle, mmt300_bench(repository, tmp_path_factory))
    assert vehicle.sensors is not None
    trajectory = fly(packed, MANOEUVRES["zig_zag"].plan(packed, 1.0, 120.0))
    log = measure(trajectory, packed, vehicle.sensors, seed=seed)
    run = table_of_log(log, vehicle.sensors, name="zig-zag")
    found = gains_of(packed, vehicle.sensors, [run])
    assert not found.findings
    told = [row for row in found.gains if row.axis in {"all", "surge"} and row.judged and row.moves]
    assert len(told) >= 5
    for row in told:
        assert row.ci95 is not None
        assert row.ci95[0] <= 1.0 <= row.ci95[1], row
