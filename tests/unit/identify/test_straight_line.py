"""The slope of acceleration against thrust: right where its assumptions hold, biased where not."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.errors import CannotComputeError
from pipeline.identify.straight_line import (
    blocks_of,
    estimate,
    least_squares,
    plain_slope,
    reliability,
    straight_line,
)
from pipeline.physics.parameters import read
from pipeline.records.identification import RegressionTerm, StraightLineIdentification
from pipeline.records.run_table import RunTable
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

ADDED_KG = 6.36


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle(bundled_vehicle("rov8"))


@pytest.fixture(scope="module")
def packed(vehicle: Vehicle) -> PackedVehicle:
    return pack_vehicle(vehicle)


def flown(
    vehicle: Vehicle,
    packed: PackedVehicle,
    vector: FloatArray | None = None,
    manoeuvre: str = "surge_steps",
) -> RunTable:
    assert vehicle.sensors is not None
    trajectory = fly(packed, MANOEUVRES[manoeuvre].plan(packed, 1.0, 60.0), vector=vector)
    log = measure(trajectory, packed, vehicle.sensors, vector=vector, seed=3)
    return table_of_log(log, vehicle.sensors, name=manoeuvre)


def identified(
    vehicle: Vehicle, packed: PackedVehicle, run: RunTable
) -> StraightLineIdentification:
    assert vehicle.sensors is not None
    return straight_line(packed, vehicle.sensors, [run], bandwidth_hz=0.6)


def test_without_drag_the_plain_slope_finds_the_added_mass(
    vehicle: Vehicle, packed: PackedVehicle
) -> None:
    """The assumptions hold: nothing acts but thrust and inertia."""
    vector = packed.vector.copy()
    read(vector, "linear_damping")[0, 0] = 0.0
    read(vector, "quadratic_damping")[0] = 0.0
    found = identified(vehicle, packed, flown(vehicle, packed, vector))
    for one in found.plain:
        assert one.ci95_kg is not None
        assert one.ci95_kg[0] < ADDED_KG < one.ci95_kg[1]
        assert one.added_mass_kg == pytest.approx(ADDED_KG, abs=1.0)


def test_with_drag_the_plain_slope_is_biased_and_the_terms_mend_it(
    vehicle: Vehicle, packed: PackedVehicle
) -> None:
    found = identified(vehicle, packed, flown(vehicle, packed))
    assert found.with_terms is not None
    assert found.plain[0].added_mass_kg > 3 * ADDED_KG
    assert found.with_terms.ci95_kg is not None
    assert found.with_terms.ci95_kg[0] < ADDED_KG < found.with_terms.ci95_kg[1]
    assert found.with_terms.added_mass_kg == pytest.approx(ADDED_KG, abs=1.0)
    assert "quadratic drag" in {term.name for term in found.terms}
    assert any("plain method's assumptions" in text for text in found.warnings)


def test_a_slope_that_may_be_zero_bounds_no_mass() -> None:
    """1 / slope has no bound where the interval holds zero; else its ends carry over."""
    ends = 1.959964 * np.array([-1.0, 1.0])
    assert estimate("", 0.01, 0.01 + 0.02 * ends, 10.0, "").ci95_kg is None
    found = estimate("", 0.05, 0.05 + 0.005 * ends, 10.0, "")
    assert found.added_mass_kg == pytest.approx(10.0)
    half = 1.959964 * 0.005
    assert found.ci95_kg == pytest.approx((1 / (0.05 + half) - 10, 1 / (0.05 - half) - 10))


def test_a_run_without_velocity_is_refused(vehicle: Vehicle, packed: PackedVehicle) -> None:
    run = flown(vehicle, packed)
    blind = {name: values for name, values in run.values.items() if name != "velocity"}
    with pytest.raises(CannotComputeError, match="no velocity was measured"):
        identified(vehicle, packed, replace(run, values=blind))


@pytest.fixture(scope="module")
def zig_zag(vehicle: Vehicle, packed: PackedVehicle) -> RunTable:
    return flown(vehicle, packed, manoeuvre="zig_zag")


@pytest.mark.parametrize("quantity", ["angular_velocity", "attitude", "position"])
def test_a_gap_enters_no_term(
    vehicle: Vehicle, packed: PackedVehicle, zig_zag: RunTable, quantity: str
) -> None:
    """Half a minute of a turning run without a channel: as if the rest were all there is."""
    gap = (zig_zag.time_s > 15.0) & (zig_zag.time_s < 45.0)

    def terms(filling: float) -> dict[str, RegressionTerm]:
        values = zig_zag.values[quantity].copy()
        values[gap] = filling * np.arange(1.0, values.shape[1] + 1.0)
        run = replace(
            zig_zag,
            values={**zig_zag.values, quantity: values},
            valid={**zig_zag.valid, quantity: zig_zag.valid[quantity] & ~gap},
        )
        return {term.name: term for term in identified(vehicle, packed, run).terms}

    whole = {term.name: term for term in identified(vehicle, packed, zig_zag).terms}
    left, filled = terms(np.nan), terms(0.3)
    assert left.keys() == filled.keys() == whole.keys()
    for name, term in left.items():
        # what stands in the gap is not looked at
        assert term.coefficient == pytest.approx(filled[name].coefficient, rel=1e-6, abs=1e-6)
        assert term.ci95[0] < whole[name].ci95[1]
        assert whole[name].ci95[0] < term.ci95[1]


def test_where_no_sample_has_all_terms_the_plain_slope_is_left(
    vehicle: Vehicle, packed: PackedVehicle
) -> None:
    run = flown(vehicle, packed)
    seen = run.valid["position"] & (np.arange(run.time_s.size) % 50 == 7)
    found = identified(vehicle, packed, replace(run, valid={**run.valid, "position": seen}))
    assert found.with_terms is None
    assert found.terms == ()
    assert len(found.plain) == 2


def test_noise_of_the_thrust_is_taken_off_by_its_reliability() -> None:
    """Noise of half the signal in x: least squares loses a fifth."""
    generator = np.random.default_rng(2)
    x = generator.standard_normal(20_000)
    noisy = x + 0.5 * generator.standard_normal(x.size)
    y = 3.0 * x + 0.2 * generator.standard_normal(x.size)
    plain = plain_slope(noisy, y, np.zeros(x.size, int), 1).coefficients[0]
    assert plain == pytest.approx(3.0 / 1.25, rel=0.02)
    assert plain / reliability(noisy, 0.5) == pytest.approx(3.0, rel=0.02)


@pytest.mark.parametrize(("stretches", "length"), [(6, 700), (8, 12)])
def test_intervals_honour_autocorrelation(stretches: int, length: int) -> None:
    """A mean over 20 samples of both sides: the scatter of slopes over seeds is what is claimed.

    With stretches shorter than the smoother, too.
    """
    kernel = np.ones(20) / 20
    stretch = np.repeat(np.arange(stretches), length)
    slopes, claimed, inside = [], [], []
    for seed in range(100):
        generator = np.random.default_rng(seed)
        x, noise = (
            np.concatenate(
                [
                    np.convolve(generator.standard_normal(length + 19), kernel, "valid")
                    for _ in range(stretches)
                ]
            )
            for _ in range(2)
        )
        found = plain_slope(x, 2.0 * x + noise, stretch, 30)
        slopes.append(found.coefficients[0])
        claimed.append(np.sqrt(found.covariance[0, 0]))
        inside.append(found.ci95[0, 0] < 2.0 < found.ci95[0, 1])
    assert np.median(claimed) == pytest.approx(np.std(slopes), rel=0.25)
    assert np.mean(inside) > 0.85


@pytest.mark.parametrize(("stretches", "length"), [(1, 600), (2, 100), (4, 100)])
def test_intervals_of_few_short_stretches_hold_the_truth(stretches: int, length: int) -> None:
    """A mean over 40 samples of both sides; Newey and West hold it 65 to 85 times of 100."""
    kernel = np.ones(40) / 40
    stretch = np.repeat(np.arange(stretches), length)
    inside = []
    for seed in range(150):
        generator = np.random.default_rng(seed)
        x, noise = (
            np.concatenate(
                [
                    np.convolve(generator.standard_normal(length + 39), kernel, "valid")
                    for _ in range(stretches)
                ]
            )
            for _ in range(2)
        )
        one = plain_slope(x, 2.0 * x + noise, stretch, 40)
        inside.append(one.ci95[0, 0] < 2.0 < one.ci95[0, 1])
    assert np.mean(inside) > 0.9


def test_a_stretch_that_alone_has_thrust_is_never_left_out() -> None:
    """Without it there is no slope; parts of it are left out instead."""
    generator = np.random.default_rng(4)
    x = np.concatenate([generator.standard_normal(100), np.zeros(100)])
    noise = 0.1 * generator.standard_normal(200)
    stretch = np.repeat([0, 1], 100)
    found = plain_slope(x, 2.0 * x + noise, stretch, 10)
    low, high = found.ci95[0]
    assert low < 2.0 < high < low + 0.6


def test_no_block_spans_two_stretches() -> None:
    lengths = [12, 400, 60, 61, 1]
    stretch = np.repeat(np.arange(5), lengths)
    block = blocks_of(stretch, 60)
    sizes = np.bincount(block)
    assert sizes.size == 1 + 7 + 1 + 1 + 1
    assert all(np.unique(stretch[block == number]).size == 1 for number in range(sizes.size))
    assert sizes.max() <= 61


def test_a_constant_thrust_is_refused() -> None:
    design = np.column_stack([np.full(100, 4.0), np.ones(100)])
    with pytest.raises(CannotComputeError, match="against thrust: the 100 points do not determine"):
        least_squares(design, np.zeros(100), np.zeros(100, int), 3)
