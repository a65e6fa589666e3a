"""What a simulation knows of a vehicle: its file's context for the effects, the bench's results."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.effects.effect import EffectContext
from pipeline.errors import CannotComputeError
from pipeline.physics.drive import TorqueSurface
from pipeline.physics.torque_balance import OpenWaterPropeller
from pipeline.records.fits import StaticCharacteristic, ThrustFamily
from pipeline.simulate.pack_hull import munk_held
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vehicle

SENSORS = ("imu", "dvl", "depth", "position", "shaft_speed", "voltage")


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


def model_of(vehicle: Vehicle) -> Model:
    """Return the model section.

    Raises
    ------
    CannotComputeError
        When the vehicle file has none.
    """
    if vehicle.model is None:
        raise CannotComputeError(
            f"{vehicle.name} has no model: section, so there is nothing to simulate; see "
            "docs/formats.md for what it holds"
        )
    return vehicle.model


def effect_context(vehicle: Vehicle) -> EffectContext:
    """Return what decides which effects of the library a vehicle can have.

    Raises
    ------
    CannotComputeError
        When the vehicle file has no model section.
    """
    model = model_of(vehicle)
    sensors = vehicle.sensors
    return EffectContext(
        thruster_names=tuple(thruster.name for thruster in vehicle.thrusters),
        thrust_falls_with_speed=model.terms.thrust_falls_with_speed,
        coriolis=model.terms.coriolis,
        strips=model.crossflow is not None,
        walls=model.pool is not None,
        gravity_mps2=vehicle.water.gravity_mps2,
        measured=frozenset(
            name for name in SENSORS if sensors is not None and getattr(sensors, name) is not None
        ),
        crossflow_in_nominal=model.crossflow is not None and model.crossflow.in_nominal,
        mass_kg=model.rigid_body.mass_kg,
        munk_held=munk_held(model),
        inflow_shares=tuple(1.0 - model.wake_fraction.of(one.name) for one in vehicle.thrusters),
        thrust_shares=tuple(1.0 - model.thrust_deduction.of(one.name) for one in vehicle.thrusters),
        wake_std=model.wake_fraction.sigma,
        deduction_std=model.thrust_deduction.sigma,
        lagged=not any(model.thrusters[one.drive].balance_in_time for one in vehicle.thrusters),
    )
