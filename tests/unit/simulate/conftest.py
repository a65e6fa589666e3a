"""A plain vehicle with every term of the model in it, built without a vehicle file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from bundled_models import NAMES, bundled, mmt300_bench

from pipeline.effects.effect import EffectContext
from pipeline.physics.parameters import neutral_vector, write
from pipeline.simulate.context import BenchModel
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.vehicle.schema import Vehicle

MASS, GRAVITY, DENSITY = 60.0, 9.81, 1000.0


def full_symmetric(diagonal: list[float], seed: int, share: float) -> np.ndarray:
    """Random symmetric positive definite matrix with a given diagonal."""
    generator = np.random.default_rng(seed)
    root = np.diag(np.sqrt(diagonal))
    mixed = generator.uniform(-share, share, (6, 6))
    correlation = (mixed + mixed.T) / 2
    np.fill_diagonal(correlation, 1.0)
    return np.asarray(root @ correlation @ root)


@pytest.fixture
def make_packed() -> Callable[..., PackedVehicle]:
    """Return a factory; keyword arguments overwrite slots of the vector."""

    def make(**slots: object) -> PackedVehicle:
        vector = neutral_vector()
        centre = np.array([0.03, -0.02, 0.05])
        inertia = np.diag([1.0, 9.0, 9.5]) + MASS * (
            centre @ centre * np.eye(3) - np.outer(centre, centre)
        )
        defaults: dict[str, object] = {
            "mass": MASS,
            "centre_of_mass": centre,
            "inertia": inertia,
            "weight": MASS * GRAVITY,
            "buoyancy": MASS * GRAVITY + 2.0,
            "centre_of_buoyancy": np.array([0.0, 0.0, -0.01]),
            "added_mass": full_symmetric([5.0, 50.0, 55.0, 0.5, 9.0, 8.0], 1, 0.2),
            "linear_damping": np.diag([3.0, 20.0, 20.0, 0.5, 6.0, 6.0]),
            "quadratic_damping": np.array([20.0, 150.0, 160.0, 1.0, 60.0, 50.0]),
            "density": DENSITY,
            "thruster_count": 5.0,
            "code_max": 127.0,
        }
        direction, position = np.zeros((12, 3)), np.zeros((12, 3))
        c, s = np.cos(np.radians(22.5)), np.sin(np.radians(22.5))
        direction[:5] = [(c, 0, -s), (c, 0, s), (c, -s, 0), (c, s, 0), (0, 0, -1)]
        position[:5] = [(-0.9, 0, 0)] * 4 + [(0.8, 0, 0)]
        defaults |= {"thruster_direction": direction, "thruster_position": position}
        for name, value in (defaults | slots).items():
            write(vector, name, np.asarray(value, float))
        code, speed = np.arange(128.0), np.arange(0.0, 2.1, 0.1)
        share = code / 127
        table = np.maximum(42 * share * (share - speed[:, None] / 5.0), 0.0)
        strips = np.array([[x, 0.25 * 0.2, 0.25 * 0.2] for x in np.linspace(-0.9, 0.9, 10)])
        return PackedVehicle(
            name="plain",
            vector=vector,
            strips=strips,
            thrust_tables=np.stack([table, table])[None],
            screws=np.array([[1.0, 0, 0, 0, 0, 0, 0, 1.0, 1.0]]),
            torque_tables=np.zeros((1, 2, 2)),
            steps=np.array([[0.1, 1.0]]),
            context=EffectContext(
                thruster_names=("upper", "lower", "left", "right", "bow"),
                thrust_falls_with_speed=True,
                coriolis=True,
                strips=True,
                walls=False,
                gravity_mps2=GRAVITY,
            ),
            code_limits=np.array([[-127.0, 127.0]] * 5),
        )

    return make


@pytest.fixture(scope="session")
def bench(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> BenchModel:
    """What the bench of mmt300 gives."""
    return mmt300_bench(repository, tmp_path_factory)


@pytest.fixture(scope="session")
def vehicles(repository: Path) -> dict[str, Vehicle]:
    """The three bundled vehicles."""
    return {name: bundled(repository, name) for name in NAMES}


@pytest.fixture(scope="session")
def packed_vehicles(vehicles: dict[str, Vehicle], bench: BenchModel) -> dict[str, PackedVehicle]:
    """The three bundled vehicles as the kernel takes them."""
    return {
        name: pack_vehicle(vehicle, bench if name == "mmt300" else None)
        for name, vehicle in vehicles.items()
    }
