"""A change that is not in proportion to its size is taken at the one with which runs are likely."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import index_of, small_case, small_coordinates

from pipeline.diagnose.coordinates import Added, coordinates, partners, scaled_by
from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.regression.grid import all_at, on_grids
from pipeline.diagnose.regression.held_out import FileModel
from pipeline.diagnose.regression.known import by_file, learned
from pipeline.diagnose.regression.ordinary import INEXACT
from pipeline.diagnose.regression.sizes import sizes
from pipeline.diagnose.regression.taken import with_sizes
from pipeline.diagnose.regression.weigh import weighed
from pipeline.effects.effect import AXES
from pipeline.effects.library import apply_effects, effects
from pipeline.effects.specification import EffectSpec
from pipeline.measured.demand import demanded, settled
from pipeline.physics.parameters import write
from pipeline.simulate.pack import mass_of
from pipeline.types import FloatArray

LAG_S = 0.9
EFFECTS = ("thruster_lag", "thruster_degraded", "quadratic_damping")


def test_a_long_lag_is_taken_as_one_though_a_short_one_finds_itself() -> None:
    sound = small_case(manoeuvres=("prbs", "surge_steps", "zig_zag"), seconds=24.0, effects=EFFECTS)
    asked = small_case((f"thruster_lag:lag_s={LAG_S}",), seconds=24.0, effects=EFFECTS)
    case = replace(asked, healthy=sound.runs)
    known = learned(case, {"vehicle file": FileModel(case.packed)})
    periods = [one.response.period_s for one in known.grids]
    grids = [
        on_grids(case.packed, run, case.vehicle.sensors, known.directions, periods)
        for run in case.runs
    ]
    more, added, _ = with_sizes(known, grids, ())
    at = {one.direction.name: one.direction.unit_size * one.size for one in added}
    assert at["thruster_lag:lag_s"] == pytest.approx(LAG_S, rel=0.35)
    runs = all_at(grids[0], added)
    assert runs[0].more.shape[1] == len(more.directions) == len(known.directions) + len(added)
    told = more.best.told(runs[:1])[0]
    assert told.information.shape == 2 * (len(more.directions),)
    assert more.best.ordinary.width[-1] < 0.01


MODULE = {"mass_kg": 3.0, "volume_m3": 0.001, "x_m": 0.3, "y_m": 0.0, "z_m": 0.1}
OF_PAYLOAD = ("payload", "residual_buoyancy", "cg_shift", "added_mass")


def test_mass_volume_and_place_of_a_module_make_the_whole_of_it() -> None:
    case = small_case(seconds=4.0, manoeuvres=("prbs",))
    every = small_coordinates(OF_PAYLOAD)
    mass = every[index_of(every, "payload:mass_kg")]
    own = [one for one in every if one.name != "payload:volume_m3"]
    found = partners(case.packed, mass, MODULE, own)
    assert [one.direction.parameter.name for one in found] == ["volume_m3", "x_m", "y_m", "z_m"]
    assert dict(found[2].direction.beside) == {"mass_kg": 3.0, "volume_m3": 0.001, "x_m": 0.3}
    assert partners(case.packed, mass, {}, own) == ()

    def at(direction: Added) -> float:
        one = direction.direction
        return (MODULE[one.parameter.name] - one.parameter.neutral) / one.unit_size

    added = [replace(one, size=at(one)) for one in (Added(mass, 0.0), *found)]
    added = [one for one in added if one.size != 0.0]
    (grid,) = on_grids(case.packed, case.runs[0], case.vehicle.sensors, (), [0.1])
    claimed = grid.claimed
    assert claimed is not None
    changed = settled(
        apply_effects(case.packed.vector, [EffectSpec("payload", MODULE)], case.packed.context)
    )
    force = -demanded(case.packed, changed, claimed.motion, still=True)
    force += demanded(case.packed, settled(case.packed.vector), claimed.motion, still=True)
    parts = [claimed.departure(one.direction, one.size) for one in added]
    sizes = [one.size for one in added]
    total = sum(size * one.wrench for size, one in zip(sizes, parts, strict=True))
    assert total == pytest.approx(force, abs=1e-6)
    more = sum(size * one.mass for size, one in zip(sizes, parts, strict=True))
    assert more == pytest.approx(mass_of(changed) - mass_of(case.packed.vector), abs=1e-6)
    (whole,) = all_at([grid], added)
    assert whole.added.more.shape[1] == len(added)


def test_an_added_mass_that_is_off_changes_what_turning_does() -> None:
    case = small_case(seconds=8.0, manoeuvres=("zig_zag",))
    uncertainty = case.vehicle.model and case.vehicle.model.uncertainty
    assert uncertainty
    vector = case.packed.vector.copy()
    write(vector, "coriolis_fraction", 0.0)
    packed = replace(
        case.packed, vector=vector, context=replace(case.packed.context, coriolis=False)
    )
    library = {name: effects()[name] for name in ("added_mass", "coriolis_omitted")}
    every = coordinates(packed, library, uncertainty)
    turning = every[index_of(every, "coriolis_omitted:fraction")]
    found = scaled_by(turning, {"fraction": 0.5}, every, 4)
    assert [one.direction.parameter.name for one in found] == list(AXES)
    sway, sized = found[1], every[index_of(every, "added_mass:sway")]
    assert sway.direction.ordinary == pytest.approx(2.0 * sized.ordinary)
    (grid,) = on_grids(packed, case.runs[0], case.vehicle.sensors, (), [0.1])
    claimed = grid.claimed
    assert claimed is not None
    heavier = EffectSpec("added_mass", {"sway": sized.value(sway.size)})
    turned = EffectSpec("coriolis_omitted", {"fraction": 0.5})

    def moved(*specs: EffectSpec) -> FloatArray:
        changed = settled(apply_effects(packed.vector, specs, packed.context))
        force = -demanded(packed, changed, claimed.motion, still=True)
        return np.asarray(force @ np.linalg.inv(mass_of(changed)))

    change = moved(heavier, turned) - moved(heavier) - moved(turned) + moved()
    departure = claimed.departure(sway.direction, sway.size)
    predicted = sway.size * departure.wrench @ np.linalg.inv(mass_of(packed.vector))
    # to the first order in the departure: the vehicle is a few per cent heavier
    assert predicted == pytest.approx(change, abs=0.05 * np.abs(change).max())
    assert np.abs(change[:, [0, 1, 5]]).max() > 1e-4
    assert not departure.mass.any()


def test_a_current_to_the_north_and_the_east_is_taken_as_one() -> None:
    """Drag goes with the square of the speed: the whole is not the sum of both."""
    current = {"north_mps": 0.35, "east_mps": -0.25}
    case = small_case(
        (f"current:{','.join(f'{name}={value}' for name, value in current.items())}",),
        manoeuvres=("prbs", "surge_steps"),
        seconds=24.0,
        effects=("current", "quadratic_damping"),
    )
    known = by_file(case)
    periods = [one.response.period_s for one in known.grids]
    grids = [
        on_grids(case.packed, run, case.vehicle.sensors, known.directions, periods)
        for run in case.runs
    ]
    _, added, _ = with_sizes(known, grids, ())
    plain = [one for one in added if one.direction.within is None]
    taken = {one.direction.parameter.name: one for one in plain}
    assert set(taken) >= set(current)
    (name, beside), *_ = taken["east_mps"].direction.beside or taken["north_mps"].direction.beside
    assert beside == pytest.approx(current[name], rel=0.3)
    changed = settled(
        apply_effects(case.packed.vector, [EffectSpec("current", current)], case.packed.context)
    )
    claimed = grids[0][0].claimed
    assert claimed is not None
    whole = -demanded(case.packed, changed, claimed.motion, still=True)
    whole += demanded(case.packed, settled(case.packed.vector), claimed.motion, still=True)
    sizes = {name: current[name] / one.direction.unit_size for name, one in taken.items()}
    first = next(one for one in taken.values() if not one.direction.beside)
    other = next(one for one in taken.values() if one is not first)
    own = (first.direction.parameter.name, current[first.direction.parameter.name])
    parts = [
        (one.direction, sizes[one.direction.parameter.name])
        for one in (first, replace(other, direction=replace(other.direction, beside=(own,))))
    ]
    total = sum(size * claimed.departure(one, size).wrench for one, size in parts)
    assert total == pytest.approx(whole, abs=1e-6)
    apart = [(replace(one, beside=()), size) for one, size in parts]
    total = sum(size * claimed.departure(one, size).wrench for one, size in apart)
    assert total != pytest.approx(whole, rel=0.05)


def test_a_slow_current_is_taken_at_its_size() -> None:
    """A vehicle at rest has far less drag in it than the secant to a fast one says."""
    case = small_case(
        ("current:north_mps=0.04",),
        manoeuvres=("heave_steps", "heave_steps"),
        seconds=24.0,
        effects=("current",),
    )
    known = by_file(case)
    periods = [one.response.period_s for one in known.grids]
    grids = [
        on_grids(case.packed, run, case.vehicle.sensors, known.directions, periods)
        for run in case.runs
    ]
    more, added, _ = with_sizes(known, grids, ())
    told = more.best.told([all_at(grid, added)[0] for grid in grids])
    found = weighed(told, more.directions, more.best.ordinary)[0]
    (north,) = sizes(found, more.directions, INEXACT).values()
    secant = weighed(
        known.best.told([grid[0] for grid in grids]), known.directions, known.best.ordinary
    )[0]
    (fast,) = sizes(secant, known.directions, INEXACT).values()
    # the damping of this vehicle is off, too
    assert fast[0] < 0.4 * 0.04 < 0.6 * 0.04 < north[0] < 1.2 * 0.04


@pytest.mark.slow
def test_a_module_off_the_middle_is_named_with_its_place() -> None:
    module = {"mass_kg": 1.5, "volume_m3": 0.0005, "x_m": 0.2}
    fault = ",".join(f"{name}={value}" for name, value in module.items())
    found = diagnose(small_case((f"payload:{fault}",), effects=OF_PAYLOAD))
    assert found.verdict.effects == ("payload",)
    low, high = found.ranking[0].parameters["x_m"].ci95
    assert low < module["x_m"] < high
