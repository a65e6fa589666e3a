"""A case: its size, its repeatability, what is in it and what is not."""

from collections.abc import Sequence

import numpy as np
import pytest

from pipeline.blind import generate as generate_module
from pipeline.blind.flying import CaseWorld, FlownCase, Patient, VehicleLost
from pipeline.blind.generate import CaseSpec, GeneratedCase, generate
from pipeline.blind.sizing import CHANNELS
from pipeline.blind.subject import BlindSubject, possible_effects, variant_for
from pipeline.errors import CannotComputeError


def test_the_gap_is_near_the_one_that_was_asked_for(sagging: GeneratedCase) -> None:
    label = sagging.label
    assert label.wanted_ratio == 3.0
    # the search flies two other runs than those of the case
    assert 1.8 < label.gap_ratio < 5.0
    assert label.gap_ratio == pytest.approx(max(label.channel_ratios.values()))
    assert label.truth == ("voltage_sag",)
    assert set(label.effects[0].parameters) <= {"drop", "load_drop"}


def test_runs_hold_what_the_vehicle_measures(sagging: GeneratedCase) -> None:
    assert [len(part) for part in (sagging.runs, sagging.holdout, sagging.healthy)] == [4, 2, 1]
    run = sagging.runs[0]
    assert run.thrusters == tuple(one.name for one in sagging.subject.vehicle.thrusters)
    assert set(run.values) == {
        *("command", "angular_velocity", "specific_force", "attitude", "velocity", "depth"),
        *("position", "voltage"),
    }
    for quantity, values in run.values.items():
        valid = run.valid[quantity]
        assert valid.mean() > 0.9
        assert np.isfinite(values[valid]).all()
        assert np.isnan(values[~valid]).all()
    np.testing.assert_allclose(np.linalg.norm(run.values["attitude"], axis=1), 1.0, atol=1e-9)


def test_a_healthy_vehicle_that_is_lost_makes_no_case(
    rov8: BlindSubject, sagging: GeneratedCase, monkeypatch: pytest.MonkeyPatch
) -> None:
    """rov8 in a transit that tips it over: the campaign is told, and goes on."""
    fly = generate_module.fly_all

    def lost(
        stage: CaseWorld,
        patient: Patient,
        *how: *tuple[Sequence[str], float, np.random.SeedSequence],
    ) -> list[FlownCase]:
        if not patient.faults:
            raise VehicleLost
        return fly(stage, patient, *how)

    monkeypatch.setattr(generate_module, "fly_all", lost)
    with pytest.raises(CannotComputeError, match="cannot be flown with no fault"):
        generate(rov8, sagging.spec)


def test_a_sagging_supply_is_measured_lower_than_a_healthy_one(sagging: GeneratedCase) -> None:
    sick, well = (np.nanmean(r.values["voltage"]) for r in (sagging.runs[0], sagging.healthy[0]))
    assert sick < well - 0.3


def test_the_same_seed_gives_the_same_case(rov8: BlindSubject, sagging: GeneratedCase) -> None:
    again = generate(rov8, sagging.spec)
    assert again.label == sagging.label
    for one, other in zip(sagging.runs, again.runs, strict=True):
        for quantity, values in one.values.items():
            np.testing.assert_array_equal(values, other.values[quantity])


def test_missing_instruments_are_not_logged(rov8: BlindSubject) -> None:
    spec = CaseSpec("none", healthy=0, missing=("dvl", "position"), duration_s=20.0, seed=9)
    case = generate(rov8, spec)
    assert not {"velocity", "position"} & set(case.runs[0].values)
    assert case.label.truth == ("none",)
    assert case.label.gap_ratio == 1.0
    assert set(case.label.channel_ratios) == set(CHANNELS) - {"u", "v", "w", "x", "y"}


def test_trouble_outside_the_library_is_labelled_unknown_with_its_times(rov8: BlindSubject) -> None:
    spec = CaseSpec("outside", ("intermittent_thruster",), healthy=0, duration_s=40.0, seed=3)
    case = generate(rov8, spec)
    assert case.label.truth == ("unknown",)
    assert case.label.overlaps == ("thruster_degraded",)
    assert set(case.label.times_s) == {"run_1", "run_2", "run_3", "run_4"}
    assert case.label.gap_ratio > 1.1


def test_each_effect_of_a_pair_has_a_gap_of_its_own(rov8: BlindSubject) -> None:
    spec = CaseSpec("pair", ("current", "payload"), healthy=0, duration_s=40.0, seed=5)
    label = generate(rov8, spec).label
    assert set(label.own_ratios) == {"current", "payload"}
    # root mean squares of two traces: that of their sum lies between their difference and sum
    one, other = (np.sqrt(ratio**2 - 1.0) for ratio in label.own_ratios.values())
    both = np.sqrt(label.gap_ratio**2 - 1.0)
    assert 0.9 * abs(one - other) < both < 1.1 * (one + other)
    assert min(one, other) > 1.0


def test_an_effect_that_the_nominal_has_gets_a_vehicle_without_it(carrier: BlindSubject) -> None:
    variant = variant_for(carrier, "coriolis_omitted")
    assert carrier.vehicle.model is not None
    assert variant.vehicle.model is not None
    assert carrier.vehicle.model.terms.coriolis
    assert not variant.vehicle.model.terms.coriolis
    assert variant.text != carrier.text
    assert variant_for(carrier, "payload") is carrier
    # the tether of the nominal model is in no simulation of the package
    assert carrier.vehicle.model.tether is not None
    assert not carrier.vehicle.model.tether.in_nominal


def test_effects_that_cannot_be_are_not_asked_for(
    carrier: BlindSubject, rov8: BlindSubject
) -> None:
    assert "wall_effect" in possible_effects(rov8)
    assert "wall_effect" not in possible_effects(carrier)
