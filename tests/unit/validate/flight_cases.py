"""mmt300 with the static family of its bench, and a vehicle whose thrust does not fall."""

from dataclasses import dataclass
from pathlib import Path

from bundled_models import bundled

from pipeline.records.fits import InverseCharacteristic
from pipeline.simulate.context import BenchModel
from pipeline.simulate.pack import PackedVehicle
from pipeline.vehicle.schema import Vehicle


@dataclass(frozen=True)
class Bench:
    """mmt300, what its bench gives, and its inverse without a mooring test."""

    vehicle: Vehicle
    model: BenchModel
    packed: PackedVehicle
    inverse: InverseCharacteristic


def bollard_vehicle(repository: Path, zero_thrust_speed_mps: float) -> Vehicle:
    """rov8 whose thrust is gone at a given inflow speed."""
    text = bundled(repository, "rov8").model_dump()
    drive = text["model"]["thrusters"]["t200_esc"]
    drive["characteristic"]["zero_thrust_speed_mps"] = zero_thrust_speed_mps
    return Vehicle.model_validate(text)


def one_way_horizontals(repository: Path) -> Vehicle:
    """rov8 whose four horizontal thrusters turn one way and whose verticals turn both."""
    text = bundled(repository, "rov8").model_dump()
    text["drives"]["one_way"] = text["drives"]["t200_esc"] | {"code_min": 0}
    text["model"]["thrusters"]["one_way"] = text["model"]["thrusters"]["t200_esc"]
    for thruster in text["thrusters"][:4]:
        thruster["drive"] = "one_way"
    return Vehicle.model_validate(text)
