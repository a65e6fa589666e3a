"""The model where everything is most probable: the same from wherever it is sought."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import index_of, small_case

from pipeline.diagnose.case import channels_of, led_by, setting_of
from pipeline.diagnose.judging.search import force_prior, ordinary_prior
from pipeline.diagnose.linear import most_probable as most_probable_module
from pipeline.diagnose.linear.elimination import ForcePrior, Grams, grams, marginal
from pipeline.diagnose.linear.evidence import fit
from pipeline.diagnose.linear.linear_model import (
    LinearModel,
    Point,
    Setting,
    motion_at,
    realisable,
    residual_of,
    vector_of,
)
from pipeline.diagnose.linear.most_probable import (
    linear_near,
    most_probable,
    moved_to,
    readings_there,
)
from pipeline.diagnose.linear.predictions import Motion
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.types import FloatArray

LEVEL = Level(np.ones(6), 1.0, True)


def evidence(model: LinearModel) -> tuple[float, FloatArray]:
    """Log evidence of nothing beyond what is stated, and the departures that go with it."""
    found = fit(
        marginal(grams(model), force_prior(model.setting, LEVEL)), ordinary_prior(model.setting)
    )
    return found.log_evidence, realisable(model.setting.coordinates, found.mean)


def test_the_evidence_is_the_same_from_wherever_the_point_is_sought() -> None:
    case = small_case(effects=("quadratic_damping",), seed=3)
    channels = channels_of(case.vehicle, case.runs)
    setting = setting_of(case, case.runs, channels, threads=1)
    led, sought = [], []
    for off in (0.0, 0.5):
        departures = np.full(len(setting.coordinates), 0.0)
        departures[index_of(setting.coordinates, "quadratic_damping:yaw")] = off
        vector = vector_of(setting, departures)
        here = led_by(setting, case.packed, case.runs, channels, vector)
        led.append(evidence(linear_model(here, replace(here.origin(), departures=departures)))[0])
        for _ in range(2):
            model = linear_near(here, force_prior(here, LEVEL), departures)
            departures = evidence(model)[1]
        sought.append(evidence(model)[0])
        # led by nothing, and yet it stays with the readings
        assert model.point.pull == 0.0
        assert np.sqrt(np.mean(model.residual**2)) < 1.3
    assert sought[0] == pytest.approx(sought[1], abs=1.0)
    assert abs(led[0] - led[1]) > 10.0 * abs(sought[0] - sought[1])


def test_readings_at_the_point_itself_are_those_of_the_model() -> None:
    case = small_case(manoeuvres=("prbs",), seconds=12.5)
    setting = setting_of(case, case.runs, channels_of(case.vehicle, case.runs), threads=1)
    model = linear_model(setting, setting.origin())
    point = most_probable(grams(model), force_prior(setting, LEVEL), model.point.departures)
    there = linear_model(setting, point)
    seen, elsewhere = readings_there(there, point), readings_there(model, point)
    assert seen is not None
    assert elsewhere is not None
    np.testing.assert_allclose(seen, there.readings, atol=1e-6)
    # where the model is bent the readings differ from those that it has elsewhere
    assert np.abs(elsewhere - model.readings).max() > 1e-3


def test_where_no_vehicle_can_be_there_are_no_readings() -> None:
    case = small_case(manoeuvres=("prbs",), seconds=12.5, effects=("payload",))
    setting = setting_of(case, case.runs, channels_of(case.vehicle, case.runs), threads=1)
    model = linear_model(setting, setting.origin())
    far = np.zeros(len(setting.coordinates))
    far[index_of(setting.coordinates, "payload:mass_kg")] = -50.0
    forces = force_prior(setting, LEVEL)
    assert readings_there(model, replace(model.point, departures=far)) is None
    assert moved_to(model, grams(model), forces, far) is None


def test_an_outside_force_gives_a_heavier_vehicle_the_same_acceleration() -> None:
    """A force that is there is simulated as it is counted: by what it does to the nominal mass."""
    case = small_case(manoeuvres=("prbs",), seconds=12.5, effects=("added_mass",))
    setting = setting_of(case, case.runs, channels_of(case.vehicle, case.runs), threads=1)
    departures = np.zeros(len(setting.coordinates))
    departures[index_of(setting.coordinates, "added_mass:heave")] = 1.0
    origin = setting.origin()
    heave = 4 * 6 + 2

    def pushed(by: float) -> Point:
        forces = origin.forces.copy()
        forces[:, heave] += 20.0 + by
        return replace(origin, forces=forces, departures=departures)

    def residual(point: Point) -> FloatArray:
        vector = vector_of(setting, departures)
        return residual_of(setting, point, vector, motion_at(setting, point, vector))

    linear = linear_model(setting, pushed(0.0))
    column = linear.local[:, 12 + heave]
    expected = (residual(pushed(-0.1)) - residual(pushed(0.1))) / 0.2
    np.testing.assert_allclose(column, expected, atol=5e-3 * np.abs(expected).max())


def test_a_way_that_leads_astray_is_gone_step_by_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """As without a measured velocity; where that leads nowhere the model stays along what was."""
    case = small_case(manoeuvres=("prbs",), seconds=12.5)
    setting = setting_of(case, case.runs, channels_of(case.vehicle, case.runs), threads=1)
    forces, departures = force_prior(setting, LEVEL), np.zeros(len(setting.coordinates))
    straight = linear_near(setting, forces, departures)
    assert straight.point.pull == 0.0
    go = most_probable_module.moved_to

    def far_off(
        model: LinearModel, normal: Grams, forces: ForcePrior, departures: FloatArray
    ) -> Point:
        point = go(model, normal, forces, departures)
        assert point is not None
        starts = point.starts.copy()
        starts[-1, 6:9] += 20.0
        return replace(point, starts=starts)

    monkeypatch.setattr(most_probable_module, "moved_to", far_off)
    stepped = linear_near(setting, forces, departures)
    assert stepped.point.pull == 0.0
    assert evidence(stepped)[0] == pytest.approx(evidence(straight)[0], abs=1.0)
    monkeypatch.setattr(most_probable_module, "motion_at", lambda *_: motion_far_off(setting))
    assert linear_near(setting, forces, departures).point.pull == 1.0


def motion_far_off(setting: Setting) -> Motion:
    """Simulate what no reading shows: every window begins at a speed of its own."""
    origin = setting.origin()
    starts = origin.starts.copy()
    starts[:, 6:9] += 20.0
    return motion_at(setting, replace(origin, starts=starts))
