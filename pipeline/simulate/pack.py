"""From the vehicle file to what the kernel takes: the parameter vector and the tables."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.effects.effect import EffectContext
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import neutral_vector, read
from pipeline.simulate.context import BenchModel, effect_context, model_of
from pipeline.simulate.kernel_alone import fill_mass
from pipeline.simulate.pack_hull import crossflow_strips, write_body, write_lift, write_surroundings
from pipeline.simulate.pack_thrusters import (
    balance_tables,
    shaft_tables,
    stacked,
    thrust_table,
    write_thrusters,
)
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle


def mass_of(vector: FloatArray, near_wall: float = 1.0) -> FloatArray:
    """Mass matrix (6, 6) about the body origin, with `near_wall` times the added mass."""
    matrix = np.empty((6, 6))
    fill_mass(vector, near_wall, matrix)
    return matrix


@dataclass(frozen=True)
class PackedVehicle:
    """Everything that the kernel needs of a vehicle.

    `vector` is the nominal parameter vector; `strips` (k, 3); `thrust_tables` (types, 2, speeds,
    codes) [N]; `screws` (types, 9); `torque_tables` (types, codes, shaft speeds) [N m]; `steps`
    (types, 2): speed [m/s] and code of the tables' grids.
    """

    name: str
    vector: FloatArray
    strips: FloatArray
    thrust_tables: FloatArray
    screws: FloatArray
    torque_tables: FloatArray
    steps: FloatArray
    context: EffectContext
    code_limits: FloatArray
    """(thrusters, 2): smallest and largest code."""
    shaft_tables: FloatArray | None = None
    """(types, speeds, codes) [rpm] on the grid of the thrust tables, where the bench knows it."""

    @property
    def thruster_names(self) -> tuple[str, ...]:
        """Names in the order of the commands' columns."""
        return self.context.thruster_names

    @property
    def tables(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """What every kernel takes in this order: strips, thrust, screws, torque, grids."""
        return self.strips, self.thrust_tables, self.screws, self.torque_tables, self.steps

    def fastest_shaft_rate(self, kind: int, density_kgpm3: float) -> float:
        """Largest (dM_propeller/dn - dM_drive/dn) / (2 pi) over a drive's table. [kg m^2/s].

        Over the inertia it is the rate at which a shaft settles.
        """
        known = self._shaft_rates.get((kind, density_kgpm3))
        if known is not None:
            return known
        torque, screw = self.torque_tables[kind], self.screws[kind]
        drive = -np.diff(torque, axis=1) / screw[7]
        shaft = screw[7] * np.arange(1, torque.shape[1])
        load = 2.0 * density_kgpm3 * screw[0] ** 5 * screw[4] * shaft
        # where the drive gives nothing the load alone slows the shaft
        slope = (drive + load)[torque[:, 1:] > 0.0]
        rate = float(slope.max(initial=0.0)) / (2.0 * np.pi)
        self._shaft_rates[kind, density_kgpm3] = rate
        return rate

    @cached_property
    def _shaft_rates(self) -> dict[tuple[int, float], float]:
        """Rates that were looked up; a control loop asks at every period."""
        return {}

    def shaft_speed(self, kind: int, code: FloatArray, along_mps: FloatArray) -> FloatArray:
        """Steady shaft speed (k,) of a type at positive codes (k,) and speeds (k,) [rpm].

        Beyond the last code along the slope there, as the thrust: a supply above that of the bench.
        """
        from scipy.interpolate import RegularGridInterpolator

        if self.shaft_tables is None:
            raise CannotComputeError(f"the shaft speeds of {self.name} are not known")
        table = self.shaft_tables[kind]
        speed = np.arange(table.shape[0]) * self.steps[kind, 0]
        codes = np.arange(table.shape[1]) * self.steps[kind, 1]
        look_up = RegularGridInterpolator(
            (speed, codes), table, bounds_error=False, fill_value=None
        )
        points = (np.clip(along_mps, 0, speed[-1]), np.maximum(code, 0))
        return np.asarray(look_up(np.stack(points, axis=-1)))


def shafts_turn(vector: FloatArray) -> bool:
    """Whether the torque balance of a shaft is solved in time: nothing else is as fast."""
    return bool((read(vector, "rotor_inertia") > 0.0).any())


def pack_vehicle(vehicle: Vehicle, bench: BenchModel | None = None) -> PackedVehicle:
    """Turn a vehicle file into the kernel's inputs; thrusters of the ``tables`` need the `bench`.

    Raises
    ------
    CannotComputeError
        Without a model, or without bench results where they are named.
    """
    model = model_of(vehicle)
    vector = neutral_vector()
    write_body(vector, model, vehicle.water.gravity_mps2, vehicle.water.density_kgpm3)
    write_lift(vector, vehicle, model)
    write_surroundings(vector, model)
    kinds = write_thrusters(vector, vehicle)
    tables = [thrust_table(vehicle, kind, bench) for kind in kinds]
    screws, torques = balance_tables(vehicle, kinds, bench)
    return PackedVehicle(
        name=vehicle.name,
        vector=vector,
        strips=crossflow_strips(model),
        thrust_tables=stacked([table for table, _, _ in tables]),
        screws=screws,
        torque_tables=torques,
        steps=np.array([[speed, code] for _, speed, code in tables]).reshape(-1, 2),
        context=effect_context(vehicle),
        code_limits=np.array(
            [
                [vehicle.drives[t.drive].code_min, vehicle.drives[t.drive].code_max]
                for t in vehicle.thrusters
            ],
            float,
        ).reshape(-1, 2),
        shaft_tables=shaft_tables(vehicle, kinds, bench),
    )
