"""The severity search and the troubles: larger sizes open larger gaps."""

import numpy as np
import pytest

from pipeline.blind import sizing
from pipeline.blind.flying import CaseWorld, Fault, Patient, children, fault_of, fly_all, stage_of
from pipeline.blind.outside import TROUBLES
from pipeline.blind.sizing import gap_ratio, healthy_floors, ratios, trace_of_runs
from pipeline.blind.subject import BlindSubject, possible_effects
from pipeline.blind.truth.craft import Craft, craft_of
from pipeline.blind.truth.sensors import FURTHEST, Weather, drawn, wander


def gap_at(subject: BlindSubject, what: str, size: float) -> float:
    stage = stage_of(subject, (), Weather())
    fault = fault_of(what, stage, (40.0, 40.0), np.random.default_rng(8))
    seeds = children(np.random.SeedSequence(3), 1)[0]
    patient = Patient(stage.stated, (fault,), (min(size, fault.most),))
    flown = fly_all(stage, patient, ("tasks", "dives"), 40.0, seeds)
    floors = healthy_floors(subject, "trial", ())
    return gap_ratio(ratios(trace_of_runs(stage, stage.stated, flown), floors))


@pytest.mark.parametrize("what", ["tether", "dvl_scale", "current", "line_snag", "waves"])
def test_a_larger_fault_opens_a_larger_gap(rov8: BlindSubject, what: str) -> None:
    small, large = (gap_at(rov8, what, size) for size in (0.05, 0.5))
    assert 1.0 <= small < large


@pytest.mark.parametrize("what", TROUBLES)
def test_every_trouble_can_be_flown(rov8: BlindSubject, what: str) -> None:
    assert gap_at(rov8, what, 0.3) >= 1.0


def test_a_fault_of_size_nothing_leaves_no_trace(rov8: BlindSubject) -> None:
    for effect in possible_effects(rov8):
        assert gap_at(rov8, effect, 0.0) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(("shows_from", "drawn_fault"), [(1.0, 0), (5.0, 2), (50.0, 1)])
def test_a_fault_that_cannot_be_seen_is_drawn_anew(
    rov8: BlindSubject, monkeypatch: pytest.MonkeyPatch, shows_from: float, drawn_fault: int
) -> None:
    """The first that shows is taken; where none does, the one that shows most."""
    stage = stage_of(rov8, (), Weather())
    shown = iter([1.2, 9.0, 6.0, 1.1] if shows_from > 5.0 else [1.2, 2.0, 6.0, 1.1])
    drawn_so_far: list[Fault] = []

    def sized(_stage: CaseWorld, _well: Craft, fault: Fault, **_: object) -> tuple[float, float]:
        drawn_so_far.append(fault)
        return 0.1 * len(drawn_so_far), next(shown)

    monkeypatch.setattr(sizing, "size_for", sized)
    monkeypatch.setattr(sizing, "_SHOWS", shows_from)
    fault, size = sizing.fault_that_shows(
        "thruster_degraded",
        stage,
        stage.stated,
        wanted=2.0,
        floors=healthy_floors(rov8, "trial", ()),
        kinds=("tasks", "dives"),
        durations_s=(40.0, 40.0),
        seeds=np.random.SeedSequence(3),
        rng=np.random.default_rng(8),
    )
    assert fault is drawn_so_far[drawn_fault]
    assert size == pytest.approx(0.1 * (drawn_fault + 1))
    assert len(drawn_so_far) == (4 if shows_from > 10.0 else drawn_fault + 1)


def test_healthy_vehicles_differ_as_the_vehicle_file_states(rov8: BlindSubject) -> None:
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
