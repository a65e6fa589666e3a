"""What is written back gives the very model that was fitted."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled, mmt300_bench

from pipeline.identify.corrected_file import file_changes
from pipeline.identify.vehicle_parameters import (
    free_parameters,
    values_from_steps,
    vector_with,
)
from pipeline.physics.parameters import SLOTS, read
from pipeline.records.identification import IdentifiedParameter
from pipeline.simulate.context import model_of
from pipeline.simulate.pack import pack_vehicle
from pipeline.vehicle.load import VEHICLE_FILE, load_vehicle
from pipeline.vehicle.write_back import updated_vehicle_text


def found(name: str, value: float) -> IdentifiedParameter:
    return IdentifiedParameter(
        name=name,
        unit="1",
        meaning="",
        value=value,
        std=1.0,
        ci95=(0.0, 1.0),
        ci95_thrust_known=(0.0, 1.0),
        prior_value=0.0,
        prior_std=1.0,
        posterior_over_prior=0.1,
        inflation=1.0,
        identified=True,
        reason="",
    )


@pytest.mark.parametrize("name", ["rov8", "cargo_carrier", "mmt300"])
def test_the_written_file_gives_the_fitted_vector(
    name: str, repository: Path, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Payloads, couplings of the added mass, Munk moments inside the lift: all of it."""
    bench = mmt300_bench(repository, tmp_path_factory) if name == "mmt300" else None
    vehicle = bundled(repository, name)
    packed = pack_vehicle(vehicle, bench)
    model = model_of(vehicle)
    parameters = free_parameters(packed, model.uncertainty)
    steps = np.abs(np.random.default_rng(3).standard_normal(len(parameters)))
    values = values_from_steps(parameters, steps)
    wanted = vector_with(packed.vector, parameters, values)
    changes = file_changes(
        vehicle,
        model,
        packed,
        tuple(found(p.name, float(v)) for p, v in zip(parameters, values, strict=True)),
    )
    original = packed_file(repository, name).read_text(encoding="utf-8")
    path = tmp_path / VEHICLE_FILE
    path.write_text(updated_vehicle_text(original, changes, "test"), encoding="utf-8")
    again = pack_vehicle(load_vehicle(path), bench).vector
    for slot in SLOTS:
        np.testing.assert_allclose(
            read(again, slot.name), read(wanted, slot.name), rtol=2e-6, atol=2e-7, err_msg=slot.name
        )


def packed_file(repository: Path, name: str) -> Path:
    folder = "raw/mmt300" if name == "mmt300" else f"pipeline/bundled/vehicles/{name}"
    return repository / folder / VEHICLE_FILE


def test_damping_that_drives_is_not_written(repository: Path) -> None:
    vehicle = bundled(repository, "rov8")
    changes = file_changes(
        vehicle, model_of(vehicle), pack_vehicle(vehicle), (found("linear_damping_surge", -0.01),)
    )
    assert changes == {"model.damping.linear.0": 0.0}
