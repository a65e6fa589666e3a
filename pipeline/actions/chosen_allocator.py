"""The allocator that a simulation was asked for."""

from pathlib import Path
from typing import Literal

from pipeline.control.inverse import Inverse, firmware_grid
from pipeline.control.paper_allocator import (
    PaperAllocator,
    corrections_of,
    inflow_of_velocity,
    other_inverses,
    rest_inverse,
)
from pipeline.errors import CannotComputeError
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_inverses
from pipeline.records.fits import InverseCharacteristic
from pipeline.simulate.fly import CodeAllocator, general_allocator
from pipeline.vehicle.schema import Vehicle

AllocatorName = Literal["general", "paper", "paper-mooring"]


def allocator_of(one: SimulatedVehicle, name: AllocatorName, out: Path) -> CodeAllocator:
    """Return an allocator that believes the vehicle file and its bench.

    ``general`` is for any arrangement; ``paper`` eq. (6) of Kostenko 2023 with N(T, V);
    ``paper-mooring`` the same with the mooring inverse N(T).

    Raises
    ------
    CannotComputeError
        For eq. (6) without the geometry, or without an inverse from the bench.
    """
    if name == "general":
        return general_allocator(one.packed)
    geometry = one.vehicle.allocator
    if geometry is None:
        raise CannotComputeError(
            f"{one.name} has no allocator: section, which --allocator {name} takes its geometry "
            "from.\nLeave the option out: the general allocator flies any arrangement."
        )
    records = load_inverses(one.vehicle, one.name, out)

    def form(record: InverseCharacteristic, vehicle: Vehicle) -> Inverse:
        return firmware_grid(record) if name == "paper" else rest_inverse(record, vehicle)

    return PaperAllocator(
        geometry,
        form(records[""], one.vehicle),
        one.packed.thruster_names,
        direction=inflow_of_velocity(one.vehicle),
        corrections=corrections_of(one.vehicle),
        others=other_inverses(one.vehicle, records, form),
    )
