"""What the simulation takes from the bench's results."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.physics.drive import TorqueSurface
from pipeline.physics.torque_balance import OpenWaterPropeller
from pipeline.records.fits import StaticCharacteristic, ThrustFamily


@dataclass(frozen=True)
class BenchModel:
    """What the bench says about a type of thruster: the static family, and its ingredients.

    `propeller` and `surface` are needed where a thruster's balance is solved in time. With `family`
    a thruster of the tables, too, has the thrust that was measured in place of the calculated.
    """

    static: StaticCharacteristic | None
    propeller: OpenWaterPropeller | None = None
    surface: TorqueSurface | None = None
    family: ThrustFamily | None = None
    others: Mapping[tuple[str, str], "BenchModel"] = field(default_factory=dict)
    """Further types of the vehicle, by drive and propeller."""

    def of(self, kind: tuple[str, str]) -> "BenchModel":
        """Return what holds for thrusters of a drive and a propeller."""
        return self.others.get(kind, self)
