"""The severity search and the troubles: larger sizes open larger gaps."""

import numpy as np
import pytest

from pipeline.blind.flying import Patient, children, fault_of, fly_all, stage_of
from pipeline.blind.outside import TROUBLES
from pipeline.blind.severity import gap_ratio, ratios
from pipeline.blind.sizing import FloorKey, healthy_floors, trace_of_runs
from pipeline.blind.subject import Subject, possible_effects
from pipeline.blind.truth.craft import craft_of
from pipeline.blind.truth.nature import FURTHEST, Weather, drawn, wander


def gap_at(subject: Subject, what: str, size: float) -> float:
    stage = stage_of(subject, (), Weather())
    fault = fault_of(what, stage, (40.0, 40.0), np.random.default_rng(8))
    seeds = children(np.random.SeedSequence(3), 1)[0]
    patient = Patient(stage.stated, (fault,), (min(size, fault.most),))
    flown = fly_all(stage, patient, ("tasks", "dives"), 40.0, seeds)
    floors = healthy_floors(FloorKey(subject, "trial", ()))
    return gap_ratio(ratios(trace_of_runs(stage, stage.stated, flown), floors))


@pytest.mark.parametrize("what", ["tether", "dvl_scale", "current", "line_snag", "waves"])
def test_a_larger_fault_opens_a_larger_gap(rov8: Subject, what: str) -> None:
    small, large = (gap_at(rov8, what, size) for size in (0.05, 0.5))
    assert 1.0 <= small < large


@pytest.mark.parametrize("what", TROUBLES)
def test_every_trouble_can_be_flown(rov8: Subject, what: str) -> None:
    assert gap_at(rov8, what, 0.3) >= 1.0


def test_a_fault_of_size_nothing_leaves_no_trace(rov8: Subject) -> None:
    for effect in possible_effects(rov8):
        assert gap_at(rov8, effect, 0.0) == pytest.approx(1.0, abs=1e-9)


def test_healthy_vehicles_differ_as_the_vehicle_file_states(rov8: Subject) -> None:
    assert rov8.vehicle.model is not None
    known = rov8.vehicle.model.uncertainty
    stated = craft_of(rov8.vehicle)
    rng = np.random.default_rng(1)
    many = [drawn(stated, known, rng) for _ in range(400)]
    gains = np.array([one.gain for one in many])
    drags = np.array([one.quadratic / stated.quadratic for one in many])
    buoyancy = np.array([one.buoyancy_n - stated.buoyancy_n for one in many])
    assert gains.std() == pytest.approx(known.thrust, rel=0.1)
    assert drags.std() == pytest.approx(known.damping, rel=0.1)
    assert buoyancy.std() == pytest.approx(known.buoyancy_n, rel=0.15)
    assert np.abs(buoyancy).max() <= FURTHEST * known.buoyancy_n


def test_coloured_noise_has_its_deviation_and_colour() -> None:
    noise = wander(np.random.default_rng(2), 40_000, 2, 10.0)
    assert noise.std() == pytest.approx(1.0, abs=0.05)
    lag = np.corrcoef(noise[10:, 0], noise[:-10, 0])[0, 1]
    assert lag == pytest.approx(np.exp(-1.0), abs=0.05)
