"""What the simulation takes from the bench's results."""

from dataclasses import dataclass

from pipeline.physics.drive import TorqueSurface
from pipeline.physics.torque_balance import OpenWaterPropeller
from pipeline.records.fits import StaticCharacteristic


@dataclass(frozen=True)
class BenchModel:
    """What the bench says about a vehicle's thruster: the static family, and its ingredients.

    `propeller` and `surface` are needed where a thruster's balance is solved in time.
    """

    static: StaticCharacteristic
    propeller: OpenWaterPropeller | None = None
    surface: TorqueSurface | None = None
