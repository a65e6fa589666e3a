"""Wake fraction and thrust deduction of the vehicle file: read, flown, believed, written."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.effects.library import EffectSpec, apply_effects, candidates
from pipeline.errors import InputError
from pipeline.physics.parameters import read
from pipeline.simulate.applied_wrench import inflow_speed, settled_thrust, thruster_wrench
from pipeline.simulate.fly import general_allocator
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.validate.plan import calm_vehicle
from pipeline.vehicle.estimates import share_changes
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.model_schema import HullShare, ThrustDeduction, WakeFraction
from pipeline.vehicle.write_back import updated_vehicle_text

AHEAD = np.array([[0.6, 0.0, 0.0, 0.0, 0.0, 0.0]])
KEYS = {"model.wake_fraction.value": 0.2, "model.wake_fraction.sigma": 0.05}
KEYS |= {"model.thrust_deduction.thrusters.rear_left": 0.1}


def written(changes: dict[str, float | str | tuple[float, ...]], folder: Path) -> Path:
    """cargo_carrier, whose thrust falls with speed, with keys changed."""
    found = bundled_vehicle("cargo_carrier")
    original = found if found.is_file() else found / "vehicle.yaml"
    file = folder / "vehicle.yaml"
    text = original.read_text(encoding="utf-8")
    file.write_text(updated_vehicle_text(text, changes, "changed"), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def stated(tmp_path_factory: pytest.TempPathFactory) -> PackedVehicle:
    return pack_vehicle(load_vehicle(written({**KEYS}, tmp_path_factory.mktemp("stated"))))


@pytest.fixture(scope="module")
def plain(repository: Path) -> PackedVehicle:
    return pack_vehicle(bundled(repository, "cargo_carrier"))


def thrust_n(packed: PackedVehicle, speed: float, *effects: EffectSpec) -> float:
    """Thrust of a stern thruster at full code while the vehicle surges."""
    codes = np.full((1, len(packed.thruster_names)), 127.0)
    vector = apply_effects(packed.vector, effects, packed.context)
    found = thruster_wrench(packed, codes, speed / 0.6 * AHEAD, vector=vector)[1]
    return float(found[0, packed.thruster_names.index("rear_left")])


def test_the_stated_shares_are_flown(plain: PackedVehicle, stated: PackedVehicle) -> None:
    """0.8 of the inflow at 0.6 m/s is the inflow at 0.48 m/s; 0.9 of the thrust is left."""
    assert thrust_n(stated, 0.6) == pytest.approx(0.9 * thrust_n(plain, 0.48), rel=2e-3)
    assert thrust_n(stated, 0.0) == pytest.approx(0.9 * thrust_n(plain, 0.0), rel=1e-12)


def test_the_neutral_of_the_effects_is_what_the_file_states(stated: PackedVehicle) -> None:
    """The same id and parameter: a value of 0.7 is an inflow of 0.7, whatever is stated."""
    count = len(stated.thruster_names)
    (inflow,) = candidates(stated.context)["advance_speed_loss"].parameters
    (t,) = candidates(stated.context)["thrust_deduction"].parameters
    assert (inflow.neutral, inflow.ordinary) == (pytest.approx(0.8), 0.05)
    assert t.neutral == pytest.approx(0.1 / count)
    neutral = [
        EffectSpec("advance_speed_loss", {"inflow_fraction": inflow.neutral}),
        EffectSpec("thrust_deduction", {"t": t.neutral}),
    ]
    same = apply_effects(stated.vector, neutral, stated.context)
    assert same.tobytes() == stated.vector.tobytes()
    less = apply_effects(
        stated.vector, [EffectSpec("advance_speed_loss", {"inflow_fraction": 0.7})], stated.context
    )
    assert read(less, "inflow_fraction")[:count] == pytest.approx(np.full(count, 0.7))


def test_the_settled_thrust_of_the_validation_is_the_kernels(stated: PackedVehicle) -> None:
    codes = np.linspace(-127.0, 127.0, 13)[:, None] * np.ones(len(stated.thruster_names))
    nu = np.repeat(AHEAD, len(codes), axis=0)
    calm = calm_vehicle(stated)
    flown = thruster_wrench(calm, codes, nu)[1]
    assert settled_thrust(calm, codes, inflow_speed(calm, nu)) == pytest.approx(flown, abs=1e-9)


def test_the_allocator_of_the_file_believes_it(stated: PackedVehicle) -> None:
    """What it asks for is what it gets, under way and from a thruster that gives less."""
    allocator = general_allocator(stated)
    demand = np.array([60.0, 0.0, 20.0, 0.0, 0.0, 0.0])
    codes, wanted, cut = allocator.decide(demand, AHEAD[0])
    assert not cut
    _, given = thruster_wrench(stated, codes[None, :], AHEAD)
    assert given[0] == pytest.approx(wanted, abs=0.02 * np.abs(wanted).max())


def test_a_thruster_that_is_not_there_is_named(tmp_path: Path) -> None:
    file = written({"model.wake_fraction.thrusters.stern": 0.1}, tmp_path)
    with pytest.raises(InputError, match='there is no thruster "stern"'):
        load_vehicle(file)


@pytest.mark.parametrize(
    ("section", "left"),
    [
        (WakeFraction(), (0.7, 0.7)),
        (WakeFraction(thrusters={"b": 0.4}), (0.7, 0.7)),
        (ThrustDeduction(value=0.1, thrusters={"a": 0.2}), (0.6, 1.05)),
    ],
)
def test_what_is_written_gives_what_was_found(section: HullShare, left: tuple[float, ...]) -> None:
    changes = share_changes(section, ("a", "b"), left, 0.03)
    own = section.model_dump()
    for path, value in changes.items():
        key, *name = path.split(".")[2:]
        if name:
            own["thrusters"][name[0]] = value
        else:
            own[key] = value
    found = type(section).model_validate(own)
    assert [1.0 - found.of(name) for name in "ab"] == pytest.approx(left)
    assert found.sigma == 0.03
