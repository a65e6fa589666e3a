"""What is to be diagnosed."""

from collections.abc import Mapping
from dataclasses import dataclass

from pipeline.effects.effect import Effect
from pipeline.effects.library import candidates
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.vehicle.schema import Vehicle


@dataclass(frozen=True)
class Case:
    """A diagnosis to be made; tables at a period of 0.02 s or less.

    `healthy` are runs that are known to be sound; `effects` are the candidates, the whole library
    that fits the vehicle otherwise.
    """

    name: str
    vehicle: Vehicle
    packed: PackedVehicle
    runs: tuple[RunTable, ...]
    holdout: tuple[RunTable, ...] = ()
    healthy: tuple[RunTable, ...] = ()
    effects: Mapping[str, Effect] | None = None

    @property
    def candidates(self) -> Mapping[str, Effect]:
        """Effects to be tried, by id."""
        return candidates(self.packed.context) if self.effects is None else self.effects
