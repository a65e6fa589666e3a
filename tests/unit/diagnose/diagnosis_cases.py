"""Small cases for the diagnosis: a few effects, short runs, everything from one seed."""

from collections.abc import Sequence

import numpy as np

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.case import Case
from pipeline.diagnose.coordinates import Coordinate, coordinates, specs_at
from pipeline.effects.library import apply_effects, candidates, parse_effect
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.vehicle.load import load_vehicle

EFFECTS = ("residual_buoyancy", "thruster_degraded", "dvl_scale", "quadratic_damping")


def small_case(
    faults: Sequence[str] = (),
    *,
    manoeuvres: Sequence[str] = ("prbs", "surge_steps"),
    seconds: float = 16.0,
    seed: int = 1,
    effects: Sequence[str] = EFFECTS,
) -> Case:
    """Runs of rov8 with faults; its ordinary parameters are drawn from the stated uncertainty."""
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    packed = pack_vehicle(vehicle)
    assert vehicle.model is not None
    assert vehicle.sensors is not None
    library = {id_: one for id_, one in candidates(packed.context).items() if id_ in effects}
    every = coordinates(packed, library, vehicle.model.uncertainty)
    drawn = np.random.default_rng(seed).standard_normal(len(every))
    ordinary = specs_at(every, drawn * np.array([one.ordinary for one in every]))
    true = apply_effects(packed.vector, ordinary, packed.context)
    true = apply_effects(true, [parse_effect(text) for text in faults], packed.context)
    runs = []
    for number, name in enumerate(manoeuvres):
        flown = fly(packed, MANOEUVRES[name].plan(packed, 1.0, seconds), vector=true)
        log = measure(flown, packed, vehicle.sensors, vector=true, seed=100 * seed + number)
        runs.append(table_of_log(log, vehicle.sensors, name=name))
    return Case("rov8", vehicle, packed, tuple(runs), effects=library)


def small_coordinates(effects: Sequence[str] = EFFECTS) -> tuple[Coordinate, ...]:
    """Departures of the small case, without runs worth the name."""
    case = small_case(seconds=1.0, manoeuvres=("hover",), effects=effects)
    assert case.vehicle.model is not None
    return coordinates(case.packed, case.candidates, case.vehicle.model.uncertainty)


def index_of(every: Sequence[Coordinate], name: str) -> int:
    """Place of a departure by its name."""
    return [one.name for one in every].index(name)
