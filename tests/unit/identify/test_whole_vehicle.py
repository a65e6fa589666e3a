"""The whole-vehicle fit on simulated runs whose truth is known."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from evaluation.identification.coverage import Campaign, drawn_truth, simulated_runs, summary
from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise, channel_noise
from pipeline.identify.output_error import reduce_windows
from pipeline.identify.run_nuisance import bridge_weights, chain_precision
from pipeline.identify.vehicle_fit import fit_vehicle
from pipeline.identify.vehicle_parameters import free_parameters, vector_with
from pipeline.identify.whole_vehicle import identify_vehicle
from pipeline.identify.window_derivatives import FitProblem, derivatives, moved_starts
from pipeline.identify.window_outputs import _whitener, stack_windows
from pipeline.identify.windows import cut
from pipeline.physics.parameters import read
from pipeline.records.identification import IdentifiedParameter, VehicleIdentification
from pipeline.records.run_table import RunTable
from pipeline.simulate.context import model_of
from pipeline.simulate.kernel import STATE
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

#: The fixed part of the campaign: seeds, one run each.
SEEDS, RUN_S = (0, 1, 2), 40.0
#: What a reduced fit frees, to be quick.
FEW = ("added_mass_surge", "added_mass_heave", "quadratic_damping_heave", "residual_buoyancy")
HEAVE = (
    *("added_mass_heave", "linear_damping_heave", "quadratic_damping_heave"),
    *("residual_buoyancy", "metacentric_height", "trim_x", "trim_y"),
)


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle(bundled_vehicle("rov8"))


@pytest.fixture(scope="module")
def sensors(vehicle: Vehicle) -> Sensors:
    assert vehicle.sensors is not None
    return vehicle.sensors


@pytest.fixture(scope="module")
def packed(vehicle: Vehicle) -> PackedVehicle:
    return pack_vehicle(vehicle)


@pytest.fixture(scope="module")
def campaign(vehicle: Vehicle, packed: PackedVehicle) -> Campaign:
    """The thrust as the bench says: what it adds has tests of its own."""
    return Campaign(vehicle, packed, ("multisine",), RUN_S, thrust=False)


@pytest.fixture(scope="module")
def fits(
    campaign: Campaign, sensors: Sensors
) -> list[tuple[dict[str, float], VehicleIdentification]]:
    """Truth by name and the fit, for each seed."""
    found = []
    for seed in SEEDS:
        drawn = drawn_truth(campaign, seed)
        truth = {p.name: float(v) for p, v in zip(drawn.parameters, drawn.values, strict=True)}
        runs = simulated_runs(campaign, drawn.vector, seed, drawn.packed)
        fit = identify_vehicle(
            campaign.packed, sensors, runs, uncertainty=doubts(campaign), suggest=False
        )
        found.append((truth, fit))
    return found


def doubts(campaign: Campaign) -> Uncertainty:
    stated = model_of(campaign.vehicle).uncertainty
    return stated if campaign.thrust else stated.model_copy(update={"thrust": 0.0})


@pytest.fixture(scope="module")
def run_of_two(packed: PackedVehicle, campaign: Campaign) -> tuple[FloatArray, RunTable]:
    """One run of a vehicle with two parameters off, and its true vector."""
    parameters = free_parameters(packed, Uncertainty(), only=FEW[:2])
    vector = vector_with(packed.vector, parameters, np.array([8.0, 15.0]))
    return vector, simulated_runs(campaign, vector, 9)[0]


def test_intervals_cover_the_truth_as_often_as_they_say(
    fits: list[tuple[dict[str, float], VehicleIdentification]],
) -> None:
    inside = [
        p.ci95[0] <= truth[p.name] <= p.ci95[1]
        for truth, found in fits
        for p in found.parameters
        if p.identified
    ]
    assert len(inside) >= 50
    # both sides: intervals may be neither too narrow nor grossly too wide
    assert stats.binomtest(sum(inside), len(inside), 0.95).pvalue > 0.001


@pytest.mark.slow
def test_intervals_hold_where_the_thrust_was_drawn_too(
    vehicle: Vehicle, packed: PackedVehicle, sensors: Sensors
) -> None:
    """All of them lean with the thrust, so they are judged together: (x - m)' C^-1 (x - m)."""
    campaign = Campaign(vehicle, packed, ("multisine",), RUN_S)
    drawn = drawn_truth(campaign, 1)
    runs = simulated_runs(campaign, drawn.vector, 1, drawn.packed)
    fit = fit_vehicle(packed, sensors, runs, uncertainty=doubts(campaign), hold_out=False)
    assert fit.solution.converged
    parameters = fit.solution.problem.parameters
    count = len(parameters)
    truth = [
        (value - p.nominal) / p.prior_std for p, value in zip(parameters, drawn.values, strict=True)
    ]
    off = truth - (fit.solution.point.steps + fit.posterior.middle)[:count]
    covariance = (
        fit.posterior.covariance * np.outer(fit.posterior.inflation, fit.posterior.inflation)
    )[:count, :count]
    distance = float(off @ np.linalg.solve(covariance, off))
    assert 0.001 < stats.chi2.cdf(distance, count) < 0.999
    # no one knows the thrust better than the bench: the masses are as uncertain as it
    masses = [p.name.startswith("added_mass") for p in parameters]
    assert (fit.posterior.std[masses] > 5 * fit.posterior.known_std[masses]).all()


def test_added_mass_within_five_per_cent(
    fits: list[tuple[dict[str, float], VehicleIdentification]],
) -> None:
    errors = [
        abs(p.value / truth[p.name] - 1)
        for truth, found in fits
        for p in found.parameters
        if p.name.startswith("added_mass") and p.identified
    ]
    assert len(errors) >= 12
    assert np.median(errors) < 0.05


def test_the_fit_beats_the_vehicle_file_and_the_baselines(
    fits: list[tuple[dict[str, float], VehicleIdentification]],
) -> None:
    for _, found in fits:
        assert found.converged
        assert found.holdout_windows == 1
        quality = {q.channel: q for q in found.quality}
        for channel in ("velocity", "angular_velocity", "attitude"):
            one = quality[channel]
            assert one.rmse_identified is not None
            assert one.rmse_last_value is not None
            assert one.rmse_vehicle_file is not None
            assert one.rmse_identified < 1.6 * one.sensor_noise
            assert one.rmse_identified < 0.5 * one.rmse_last_value
            assert one.rmse_identified < one.rmse_vehicle_file
            assert one.rmse_black_box is None or one.rmse_identified < one.rmse_black_box


def identified(
    packed: PackedVehicle,
    sensors: Sensors,
    runs: list[RunTable],
    only: tuple[str, ...] = FEW,
    doubt: float = 0.02,
) -> VehicleIdentification:
    uncertainty = Uncertainty(thrust=doubt)
    return identify_vehicle(
        packed, sensors, runs, only=only, uncertainty=uncertainty, suggest=False
    )


def value(found: VehicleIdentification, name: str) -> float:
    return next(p.value for p in found.parameters if p.name == name)


@pytest.mark.parametrize(
    "missing",
    [("velocity", "position"), ("specific_force", "depth"), ("attitude", "position")],
)
def test_missing_channels_are_done_without(
    packed: PackedVehicle,
    sensors: Sensors,
    run_of_two: tuple[FloatArray, RunTable],
    missing: tuple[str, ...],
) -> None:
    _, run = run_of_two
    kept = {name: v for name, v in run.values.items() if name not in missing}
    found = identified(packed, sensors, [replace(run, values=kept)])
    assert not {n.channel for n in found.noise} & set(missing)
    assert value(found, "added_mass_surge") == pytest.approx(8.0, rel=0.05)
    assert value(found, "added_mass_heave") == pytest.approx(15.0, rel=0.05)
    assert any("No velocity" in note for note in found.notes) == ("velocity" in missing)


def test_readings_need_no_marks(
    packed: PackedVehicle, sensors: Sensors, run_of_two: tuple[FloatArray, RunTable]
) -> None:
    """Of a table that does not say which samples are readings all are."""
    _, run = run_of_two
    found = identified(packed, sensors, [replace(run, reading={})])
    assert value(found, "added_mass_surge") == pytest.approx(8.0, rel=0.05)


def test_a_channel_slower_than_stated_is_named(
    packed: PackedVehicle, sensors: Sensors, run_of_two: tuple[FloatArray, RunTable]
) -> None:
    _, run = run_of_two
    slow = run.reading["velocity"] & (np.cumsum(run.reading["velocity"]) % 10 == 0)
    found = identified(packed, sensors, [replace(run, reading={**run.reading, "velocity": slow})])
    (note,) = (note for note in found.notes if note.startswith("Measured, but not used"))
    assert "velocity (0.78 Hz in these runs, 8 Hz expected)" in note
    assert "state the sensor's true rate_hz" in note


def test_spikes_do_not_move_the_fit(
    packed: PackedVehicle, sensors: Sensors, run_of_two: tuple[FloatArray, RunTable]
) -> None:
    _, run = run_of_two
    velocity = run.values["velocity"].copy()
    velocity[::211] += 2.0
    found = identified(packed, sensors, [replace(run, values={**run.values, "velocity": velocity})])
    assert value(found, "added_mass_surge") == pytest.approx(8.0, rel=0.05)


def test_noise_beyond_the_stated_one_is_found(
    packed: PackedVehicle, sensors: Sensors, run_of_two: tuple[FloatArray, RunTable]
) -> None:
    assert sensors.imu is not None
    quiet = sensors.imu.model_copy(update={"rate_noise_radps": 8.6e-4 / 3})
    _, run = run_of_two
    found = identified(packed, sensors.model_copy(update={"imu": quiet}), [run])
    scale = {n.channel: n.scale for n in found.noise}
    assert scale["angular_velocity"] == pytest.approx(3.0, rel=0.1)
    assert scale["velocity"] == 1.0


def heave_mass(found: VehicleIdentification) -> IdentifiedParameter:
    return next(p for p in found.parameters if p.name == "added_mass_heave")


def test_thrust_that_is_off_moves_the_mass_as_far_as_the_interval_says(
    packed: PackedVehicle, sensors: Sensors, campaign: Campaign
) -> None:
    """Truth pushes 3 % harder than the bench says: M = tau / a, 32.2 kg, comes out too small."""
    vector = packed.vector.copy()
    read(vector, "thrust_gain")[:] *= 1.03
    runs = simulated_runs(replace(campaign, manoeuvres=("heave_steps",), run_s=24.0), vector, 4)
    believed = heave_mass(identified(packed, sensors, runs, HEAVE, doubt=0.0))
    assert 13.5 + believed.value < (13.5 + 18.68) / 1.02
    assert not believed.ci95[0] <= 18.68 <= believed.ci95[1]
    doubted = heave_mass(identified(packed, sensors, runs, HEAVE, doubt=0.03))
    assert doubted.ci95[0] <= 18.68 <= doubted.ci95[1]
    assert doubted.ci95[0] < doubted.ci95_thrust_known[0]
    assert doubted.ci95_thrust_known[1] < doubted.ci95[1]


def test_one_thruster_that_is_off_moves_nothing_out_of_its_interval(
    packed: PackedVehicle, sensors: Sensors, campaign: Campaign
) -> None:
    """A vertical thruster 6 % weak: no common factor, and no interval with one holds it."""
    vector = packed.vector.copy()
    vertical = np.argmax(np.abs(read(vector, "thruster_direction")[:, 2]))
    read(vector, "thrust_gain")[vertical] *= 0.94
    flown = replace(campaign, manoeuvres=("heave_steps",), run_s=24.0)
    found = identified(packed, sensors, simulated_runs(flown, vector, 4), HEAVE, doubt=0.03)
    heave = heave_mass(found)
    assert heave.ci95[0] <= 18.68 <= heave.ci95[1]
    factors = [one.value for one in found.thrust if one.unit == "1"]
    assert int(np.argmin(factors)) == vertical
    assert found.thrust[vertical].ci95[0] <= 0.94 <= found.thrust[vertical].ci95[1]


def test_damping_is_not_negative_and_its_interval_begins_at_zero(
    packed: PackedVehicle, sensors: Sensors, campaign: Campaign
) -> None:
    """Truth has no linear damping in heave; half the fits would find some that drives."""
    vector = packed.vector.copy()
    read(vector, "linear_damping")[2, 2] = 0.0
    found = identify_vehicle(
        packed,
        sensors,
        simulated_runs(campaign, vector, 5),
        only=(*FEW, "linear_damping_heave"),
        uncertainty=Uncertainty(damping=5.0),
        suggest=False,
    )
    assert found.converged
    linear = next(p for p in found.parameters if p.name == "linear_damping_heave")
    assert linear.value >= 0.0
    assert linear.ci95[0] == 0.0
    assert linear.value < linear.ci95[1] < 0.2 * linear.prior_value
    assert value(found, "added_mass_heave") == pytest.approx(18.68, rel=0.05)


def test_nothing_measured_is_refused(
    packed: PackedVehicle, sensors: Sensors, run_of_two: tuple[FloatArray, RunTable]
) -> None:
    _, run = run_of_two
    bare = replace(run, values={"command": run.values["command"]})
    with pytest.raises(CannotComputeError, match="nothing to identify from"):
        identified(packed, sensors, [bare])
    with pytest.raises(CannotComputeError, match="name none of the vehicle's"):
        identified(packed, sensors, [run], only=("added_mass_sideways",))


def test_fit_that_is_told_to_stop_says_so_and_has_intervals(
    packed: PackedVehicle, sensors: Sensors, run_of_two: tuple[FloatArray, RunTable]
) -> None:
    found = identify_vehicle(
        packed, sensors, [run_of_two[1]], only=FEW, suggest=False, most_steps=2
    )
    # two over short windows, and one over the long ones, without which there would be no result
    assert found.iterations == 3
    assert not found.converged
    assert any("stopped after 3 steps" in note for note in found.notes)
    assert all(one.ci95[0] < one.value < one.ci95[1] for one in found.parameters)


def test_after_a_gap_in_the_commands_windows_begin_anew(
    packed: PackedVehicle, sensors: Sensors, run_of_two: tuple[FloatArray, RunTable]
) -> None:
    _, run = run_of_two
    valid = {**run.valid, "command": (run.time_s < 20) | (run.time_s > 22)}
    channels = channel_noise(sensors, [run])
    windows = cut(packed, [replace(run, valid=valid)], channels)
    assert [round(w.begin_s) for w in windows] == [0, 8, 16, 22, 30]
    assert windows[2].duration_s == pytest.approx(4.0, abs=0.03)


def test_moved_starts_turn_in_body_axes() -> None:
    generator = np.random.default_rng(0)
    starts = np.zeros((5, STATE))
    turns = Rotation.random(5, rng=generator)
    starts[:, 3:7] = turns.as_quat()[:, [3, 0, 1, 2]]
    by = 0.3 * generator.standard_normal((5, 12))
    moved = moved_starts(starts, by)
    expected = (turns * Rotation.from_rotvec(by[:, 3:6])).as_matrix()
    found = Rotation.from_quat(moved[:, [4, 5, 6, 3]]).as_matrix()
    np.testing.assert_allclose(found, expected, atol=1e-12)
    np.testing.assert_allclose(moved[:, 7:13], by[:, 6:12])


def test_elimination_of_the_starts_is_the_full_solution(
    packed: PackedVehicle, sensors: Sensors, run_of_two: tuple[FloatArray, RunTable]
) -> None:
    """Step of the parameters from the reduced equations against all unknowns at once."""
    _, run = run_of_two
    channels = channel_noise(sensors, [run])
    windows = cut(packed, [run], channels)[:2]
    stack = stack_windows(packed, windows, channels)
    parameters = free_parameters(packed, Uncertainty(), only=FEW)
    problem = FitProblem(stack, parameters, packed.vector)
    shared = problem.shared
    point = problem.origin()
    found = derivatives(problem, point)
    reduced = reduce_windows(problem, found, point, np.ones(found.residual.size))
    size, count = len(reduced.information), len(parameters)
    step = np.linalg.solve(reduced.information + reduced.prior, reduced.gradient)

    begin, middle, end = stack.bounds
    starts = np.zeros((end, 24))
    starts[begin:middle, :12] = found.starts[begin:middle]
    starts[middle:end, 12:] = found.starts[middle:end]
    common = np.zeros((end, shared.size))
    for number, (low, high) in enumerate([(begin, middle), (middle, end)]):
        np.add.at(common[low:high].T, shared.index[number], shared.columns[low:high].T)
    full = np.concatenate([found.parameters, common, starts], axis=1)
    prior = np.eye(full.shape[1])
    prior[count:size, count:size] = shared.precision
    normal = full.T @ full + prior
    whole = np.linalg.solve(normal, full.T @ found.residual)
    np.testing.assert_allclose(step, whole[:size], rtol=1e-5, atol=1e-7)


def test_knots_and_bridges_are_the_covariance_of_the_whole_run() -> None:
    """Wander sigma^2 exp(-|t - s| / tau) over two windows, put together from its parts."""
    tau, edges = 7.0, np.array([0.0, 8.0, 16.0])
    inside = np.arange(0.5, 8.0, 1.5)
    time_s = np.concatenate([inside, 8.0 + inside])
    weights = np.zeros((time_s.size, 3))
    bridge = np.zeros((time_s.size, time_s.size))
    for number in (0, 1):
        own = slice(number * inside.size, (number + 1) * inside.size)
        weights[own, number], weights[own, number + 1] = bridge_weights(inside, 8.0, tau)
        channel = ChannelNoise("attitude", "rad", 1e-9, 1.0, tau)
        whiten = _whitener(channel, inside, 8.0)
        bridge[own, own] = np.linalg.inv(whiten.T @ whiten)  # type: ignore[union-attr]
    knots = np.linalg.inv(chain_precision(edges, tau))
    found = weights @ knots @ weights.T + bridge
    expected = np.exp(-np.abs(time_s[:, None] - time_s) / tau)
    np.testing.assert_allclose(found, expected, atol=1e-6)


def line(covered: Callable[[int], bool], seed: int) -> dict[str, object]:
    one = {
        "truth": 1.0,
        "value": 1.01,
        "std": 0.1,
        "prior_std": 1.0,
        "ci95": (0.8, 1.2) if covered(seed) else (1.1, 1.3),
        "identified": True,
    }
    return {"seed": seed, "parameters": {"good": one, "bad": one | {"ci95": (1.1, 1.2)}}}


def test_the_summary_rejects_what_does_not_cover() -> None:
    lines = [line(lambda seed: seed % 20 != 0, seed) for seed in range(300)]
    good, bad = summary(lines)
    assert (good["coverage"], good["rejected"]) == (0.95, False)
    assert good["low"] < 0.95 < good["high"]
    assert (bad["covered"], bad["rejected"]) == (0, True)
    wide = summary([line(lambda _: True, seed) for seed in range(300)])[0]
    assert wide["rejected"], "always inside is no 95 % interval either"


def test_a_wrong_model_is_said_and_its_intervals_widen(
    packed: PackedVehicle, sensors: Sensors, campaign: Campaign
) -> None:
    """Truth with a coupling that the model lacks: residuals no sensor noise explains."""
    vector = packed.vector.copy()
    read(vector, "crossflow_fraction")[...] = 1.0
    found = identified(packed, sensors, simulated_runs(replace(campaign, run_s=32.0), vector, 6))
    assert max(n.scale for n in found.noise) > 2.0
    assert any("the model lacks something" in note for note in found.notes)


def test_a_lag_three_times_the_stated_one_is_no_added_mass(
    packed: PackedVehicle, sensors: Sensors, campaign: Campaign
) -> None:
    vector = packed.vector.copy()
    read(vector, "lag")[:] *= 3.0
    runs = simulated_runs(replace(campaign, run_s=32.0), vector, 7)
    found = identified(packed, sensors, runs, (*FEW, "thruster_lag"))
    assert value(found, "thruster_lag") == pytest.approx(3 * 0.076, rel=0.03)
    assert value(found, "added_mass_surge") == pytest.approx(6.36, rel=0.05)
    without = identified(packed, sensors, runs)
    assert any("the model lacks something" in note for note in without.notes)


@pytest.mark.slow
def test_a_far_start_finds_its_way(
    packed: PackedVehicle, sensors: Sensors, campaign: Campaign
) -> None:
    """Everything off by two prior deviations at once: the model's error is no sensor noise."""
    parameters = free_parameters(packed, Uncertainty())
    drawn = np.array([p.nominal + 2.0 * p.prior_std for p in parameters])
    vector = vector_with(packed.vector, parameters, drawn)
    found = identify_vehicle(packed, sensors, simulated_runs(campaign, vector, 11), suggest=False)
    assert found.converged
    truth = dict(zip((p.name for p in parameters), drawn, strict=True))
    for one in found.parameters:
        if one.identified:
            assert abs(one.value - truth[one.name]) < 4.5 * one.std
