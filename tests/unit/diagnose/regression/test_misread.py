"""Errors of the DVL: what they change in its readings, and in what follows from them."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.coordinates import Added
from pipeline.diagnose.regression.directions import directions_of
from pipeline.diagnose.regression.file_step import file_step
from pipeline.diagnose.regression.grid import all_at, on_grids
from pipeline.diagnose.regression.misread import misread
from pipeline.diagnose.regression.response import Response
from pipeline.diagnose.regression.ridge import BENT, STIFF
from pipeline.effects.library import apply_effects, candidates
from pipeline.effects.specification import EffectSpec
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.vehicle.load import load_vehicle

ERRORS = (
    EffectSpec("dvl_scale", {"scale": 1.2}),
    EffectSpec("dvl_misalignment", {"yaw_deg": -8.0, "pitch_deg": 3.0}),
    EffectSpec("dvl_lever_arm", {"x_m": 0.3, "y_m": -0.2}),
    EffectSpec("dvl_delay", {"delay_s": 0.05}),
)


@pytest.mark.parametrize("error", ERRORS[:3], ids=lambda one: one.id)
def test_readings_differ_as_the_sensors_make_them(error: EffectSpec) -> None:
    """By the simulated instrument, which has no noise here."""
    case = small_case(seconds=12.0, effects=(error.id,))
    sensors = case.vehicle.sensors
    assert sensors is not None
    assert sensors.dvl is not None
    quiet = sensors.model_copy(update={"dvl": sensors.dvl.model_copy(update={"noise_mps": 0.0})})
    flown = fly(case.packed, MANOEUVRES["zig_zag"].plan(case.packed, 1.0, 12.0))
    wrong = apply_effects(case.packed.vector, [error], case.packed.context)
    sound, other = (
        table_of_log(measure(flown, case.packed, quiet, vector=one), quiet)
        for one in (case.packed.vector, wrong)
    )
    time_s = sound.time_s
    both = np.stack(
        [np.interp(time_s, flown.time_s - flown.time_s[0], one) for one in flown.nu.T],
        axis=1,
    )
    good = sound.valid["velocity"] & other.valid["velocity"]
    more = (other.values["velocity"] - sound.values["velocity"])[good]
    expected = (both @ misread(sensors.dvl, wrong).T)[good]
    assert np.sqrt(np.mean((more - expected) ** 2)) < 0.2 * np.sqrt(np.mean(more**2))


@pytest.mark.parametrize("error", ERRORS[:3], ids=lambda one: one.id)
def test_what_follows_of_a_reading_is_told_of_its_error(error: EffectSpec) -> None:
    """Sound runs, their velocity then misread: the size is found, to the noise of the reading."""
    case = small_case(seconds=30.0, effects=(error.id,))
    sensors = case.vehicle.sensors
    directions = directions_of(case.vehicle, case.packed, case.candidates)
    grids = [on_grids(case.packed, run, sensors, directions, (0.25,))[0] for run in case.runs]
    file = file_step(case.packed)
    response = Response(grids, BENT[-1], file, file, stiff=STIFF)
    wrong = apply_effects(case.packed.vector, [error], case.packed.context)
    dvl = None if sensors is None else sensors.dvl
    matrix = misread(dvl, wrong)[:, :6]
    own = [k for k, one in enumerate(directions) if one.parameter.name in error.values]
    told = []
    for run in case.runs:
        nu = np.hstack([run.values["velocity"], run.values["angular_velocity"]])
        values = {**run.values, "velocity": run.values["velocity"] + nu @ matrix.T}
        misread_run = replace(run, values=values)
        (grid,) = on_grids(case.packed, misread_run, sensors, directions, (0.25,))
        told.append(response.told(grid))
    information = np.sum([one.information for one in told], axis=0)[np.ix_(own, own)]
    score = np.sum([one.score for one in told], axis=0)[own]
    found = np.linalg.solve(information, score)
    for k, size in zip(own, found, strict=True):
        one = directions[k]
        value = one.parameter.neutral + one.unit_size * size
        truth = error.values[one.parameter.name]
        assert value - one.parameter.neutral == pytest.approx(
            truth - one.parameter.neutral, rel=0.25
        )


def test_thrust_is_claimed_at_the_velocity_that_is_read() -> None:
    """A DVL that reads too much claims less thrust, of a thruster whose thrust falls with speed."""
    vehicle = load_vehicle(bundled_vehicle("remus100"))
    packed, sensors = pack_vehicle(vehicle), vehicle.sensors
    assert sensors is not None
    flown = fly(packed, MANOEUVRES["straight"].plan(packed, 1.0, 20.0))
    run = table_of_log(measure(flown, packed, sensors), sensors)
    found = directions_of(vehicle, packed, candidates(packed.context))
    scale = next(one for one in found if one.effect.id == "dvl_scale")
    (grid,) = on_grids(packed, run, sensors, (), [0.2])
    claimed = grid.claimed
    assert claimed is not None
    size = 0.2 / scale.unit_size
    wrench = size * claimed.departure(scale, size).wrench[:, 0]
    speed_mps, thrust_n = claimed.motion.nu[:, 0], claimed.wrench[:, 0]
    ahead = (speed_mps > 0.1) & (thrust_n > 0.5)
    assert ahead.sum() > 20
    assert np.all(wrench[ahead] > 0.0)
    assert np.all(wrench[ahead] < thrust_n[ahead])


def test_a_velocity_that_is_late_is_told_by_itself_and_by_the_rates() -> None:
    """A second late: what is read follows of what was, and rates of what is read a second later."""
    vehicle = load_vehicle(bundled_vehicle("cargo_carrier"))
    packed, sensors = pack_vehicle(vehicle), vehicle.sensors
    assert sensors is not None
    delay = EffectSpec("dvl_delay", {"delay_s": 1.0})
    late = apply_effects(packed.vector, [delay], packed.context)
    flown = fly(packed, MANOEUVRES["multisine"].plan(packed, 1.0, 40.0))
    sound, asked = (
        table_of_log(measure(flown, packed, sensors, vector=one), sensors)
        for one in (packed.vector, late)
    )
    directions = directions_of(
        vehicle, packed, {"dvl_delay": candidates(packed.context)["dvl_delay"]}
    )
    k = next(k for k, one in enumerate(directions) if one.effect.id == "dvl_delay")
    file = file_step(packed)
    grids = [on_grids(packed, run, sensors, directions, (0.2,))[0] for run in (sound, asked)]
    response = Response(grids[:1], BENT[-1], file, file, stiff=STIFF)
    size = 1.0 / directions[k].unit_size
    told = response.told(all_at(grids[1:], [Added(directions[k], size, k)])[0])
    for channels in (range(3), range(3, 6)):
        information = sum(told.by_channel[c, -1, -1] for c in channels)
        score = sum(told.score_by_channel[c, -1] for c in channels)
        assert score / information == pytest.approx(size, rel=0.1)
    # what was before the run, of which the first rows follow, nobody knows
    assert grids[1].first * 0.2 > 1.0 + 4 * 0.2 - 1e-9
