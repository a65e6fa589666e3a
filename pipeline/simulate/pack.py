"""From the vehicle file to what the kernel takes: the parameter vector and the tables."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.effects.effect import EffectContext
from pipeline.errors import CannotComputeError
from pipeline.physics.drive import TorqueSurface, drive_torque
from pipeline.physics.parameters import MOST_THRUSTERS, neutral_vector, read, write
from pipeline.physics.torque_balance import OpenWaterPropeller
from pipeline.records.fits import StaticCharacteristic
from pipeline.simulate.context import effect_context, model_of
from pipeline.simulate.kernel_thrusters import SCREW_COLUMNS
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import FromBollard, Lift, Model, ThrusterModel
from pipeline.vehicle.schema import Vehicle

#: Columns of a bollard characteristic's table, as many as codes from 0 to 128.
BOLLARD_CODES = 129
BOLLARD_SPEEDS = 41
#: Grid of the drive's torque for the balance in time.
TORQUE_CODES = 128
TORQUE_SPEEDS = 400


@dataclass(frozen=True)
class BenchModel:
    """What the bench says about a vehicle's thruster: the static family, and its ingredients.

    `propeller` and `surface` are needed where a thruster's balance is solved in time.
    """

    static: StaticCharacteristic
    propeller: OpenWaterPropeller | None = None
    surface: TorqueSurface | None = None


@dataclass(frozen=True)
class PackedVehicle:
    """Everything that the kernel needs of a vehicle.

    `vector` is the nominal parameter vector; `strips` (k, 3); `thrust_tables` (types, 2, speeds,
    codes) [N]; `screws` (types, 8); `torque_tables` (types, codes, shaft speeds) [N m]; `steps`
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
        """Steady shaft speed (k,) of a type at positive codes (k,) and speeds (k,) [rpm]."""
        from scipy.interpolate import RegularGridInterpolator

        if self.shaft_tables is None:
            raise CannotComputeError(f"the shaft speeds of {self.name} are not known")
        table = self.shaft_tables[kind]
        speed = np.arange(table.shape[0]) * self.steps[kind, 0]
        codes = np.arange(table.shape[1]) * self.steps[kind, 1]
        look_up = RegularGridInterpolator((speed, codes), table)
        points = (np.clip(along_mps, 0, speed[-1]), np.clip(code, 0, codes[-1]))
        return np.asarray(look_up(np.stack(points, axis=-1)))


def shafts_turn(vector: FloatArray) -> bool:
    """Whether the torque balance of a shaft is solved in time: nothing else is as fast."""
    return bool((read(vector, "rotor_inertia") > 0.0).any())


def pack_vehicle(vehicle: Vehicle, bench: BenchModel | None = None) -> PackedVehicle:
    """Turn a vehicle file into the kernel's inputs.

    Parameters
    ----------
    vehicle : Vehicle
        With a `model` section.
    bench : BenchModel, optional
        Needed for thrusters whose characteristic is ``tables``.

    Raises
    ------
    CannotComputeError
        Without a model, without bench results where they are named, or where the mass matrix is
        not positive definite.
    """
    model = model_of(vehicle)
    vector = neutral_vector()
    write_body(vector, model, vehicle.water.gravity_mps2, vehicle.water.density_kgpm3)
    _write_lift(vector, model)
    _write_surroundings(vector, model)
    kinds = _write_thrusters(vector, vehicle)
    tables = [_characteristic(vehicle, kind, bench) for kind in kinds]
    screws, torques = _balances(vehicle, kinds, bench)
    return PackedVehicle(
        name=vehicle.name,
        vector=vector,
        strips=_strips(model),
        thrust_tables=_stack([table for table, _, _ in tables]),
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
        shaft_tables=_shaft_tables(vehicle, kinds, bench),
    )


def write_body(vector: FloatArray, model: Model, gravity: float, density: float) -> None:
    """Write body, attached payloads, added mass and damping into a vector, in place."""
    body = model.rigid_body
    parts = [(body.mass_kg, np.array(body.centre_of_mass_m), inertia_tensor(body.inertia_kgm2))]
    volumes = [(body.displaced_volume_m3, np.array(body.centre_of_buoyancy_m))]
    for payload in model.payloads:
        if payload.attached:
            place = np.array(payload.position_m)
            parts.append((payload.mass_kg, place, np.diag(payload.inertia_kgm2)))
            volumes.append((payload.volume_m3, place))
    mass = sum(m for m, _, _ in parts)
    volume = sum(v for v, _ in volumes)
    inertia = sum((tensor + point_inertia(m, r) for m, r, tensor in parts), np.zeros((3, 3)))
    write(vector, "mass", mass)
    write(vector, "centre_of_mass", sum((m * r for m, r, _ in parts), np.zeros(3)) / mass)
    write(vector, "inertia", inertia)
    write(vector, "weight", mass * gravity)
    write(vector, "buoyancy", density * gravity * volume)
    write(vector, "centre_of_buoyancy", sum((v * r for v, r in volumes), np.zeros(3)) / volume)
    write(vector, "density", density)
    write(vector, "added_mass", added_mass_matrix(model))
    write(vector, "coriolis_fraction", 1.0 if model.terms.coriolis else 0.0)
    write(vector, "linear_damping", np.diag(model.damping.linear))
    write(vector, "quadratic_damping", np.array(model.damping.quadratic))


def added_mass_matrix(model: Model) -> FloatArray:
    """Added-mass matrix (6, 6) of the model, positive."""
    if model.added_mass.diagonal is not None:
        return np.diag(model.added_mass.diagonal)
    return np.array(model.added_mass.matrix)


def point_inertia(mass_kg: float, place_m: FloatArray) -> FloatArray:
    """Inertia (3, 3) about the origin of a mass at a place (3,), the parallel-axis theorem's."""
    r = place_m
    return np.asarray(mass_kg * (r @ r * np.eye(3) - np.outer(r, r)))


def inertia_tensor(inertia_kgm2: tuple[float, ...]) -> FloatArray:
    """Tensor (3, 3) of I_xx, I_yy, I_zz and the integrals of xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = inertia_kgm2
    return np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])


def _write_lift(vector: FloatArray, model: Model) -> None:
    """Lift slopes per speed squared; the Munk moment is counted once.

    C(nu) nu holds the Munk moments (A_33 - A_11) u w in pitch and (A_11 - A_22) u v in yaw. A
    measured or computed moment against the angle of attack holds them too, so they are taken off.
    """
    lift = model.lift if model.lift is not None else Lift(speed_mps=1.0, includes_munk=False)
    per_speed = 1.0 / lift.speed_mps**2
    a = added_mass_matrix(model)
    munk = 1.0 if lift.includes_munk and model.terms.coriolis else 0.0
    write(vector, "heave_lift_slope", lift.heave_n_per_rad * per_speed)
    write(vector, "sway_lift_slope", lift.sway_n_per_rad * per_speed)
    write(
        vector,
        "pitch_lift_slope",
        -lift.pitch_nm_per_rad * per_speed - munk * (a[2, 2] - a[0, 0]),
    )
    write(vector, "yaw_lift_slope", lift.yaw_nm_per_rad * per_speed - munk * (a[0, 0] - a[1, 1]))


def _write_surroundings(vector: FloatArray, model: Model) -> None:
    if model.crossflow is not None and model.crossflow.in_nominal:
        write(vector, "crossflow_fraction", 1.0)
    if model.pool is not None:
        walls = model.pool.walls
        write(vector, "wall_count", float(len(walls)))
        write(vector, "wall_radius", model.pool.vehicle_radius_m)
        points = np.zeros((5, 3))
        normals = np.zeros((5, 3))
        points[: len(walls)] = [wall.point_ned_m for wall in walls]
        normals[: len(walls)] = [wall.normal_ned for wall in walls]
        write(vector, "wall_point", points)
        write(vector, "wall_normal", normals)
    if model.tether is not None:
        write(vector, "tether_point", np.array(model.tether.attachment_m))
        write(vector, "tether_anchor", np.array(model.tether.anchor_ned_m))


def _write_thrusters(vector: FloatArray, vehicle: Vehicle) -> tuple[tuple[str, str], ...]:
    """Write the thrusters; returns the kinds (drive, propeller) in the order of their index."""
    kinds: list[tuple[str, str]] = []
    rows = {
        name: np.zeros(MOST_THRUSTERS)
        for name in ("thruster_type", "lag", "rotor_inertia", "inflow_fraction", "code_max")
    }
    rows["code_max"][:] = 1.0
    position, direction = np.zeros((MOST_THRUSTERS, 3)), np.zeros((MOST_THRUSTERS, 3))
    for i, thruster in enumerate(vehicle.thrusters):
        kind = (thruster.drive, thruster.propeller)
        if kind not in kinds:
            kinds.append(kind)
        drive = model_of(vehicle).thrusters[thruster.drive]
        rows["thruster_type"][i] = kinds.index(kind)
        rows["lag"][i] = drive.lag_s
        rows["rotor_inertia"][i] = _inertia(drive)
        rows["inflow_fraction"][i] = 1.0 if model_of(vehicle).terms.thrust_falls_with_speed else 0.0
        rows["code_max"][i] = vehicle.drives[thruster.drive].code_max
        position[i] = thruster.position_m
        direction[i] = np.array(thruster.direction) / np.linalg.norm(thruster.direction)
    write(vector, "thruster_count", float(len(vehicle.thrusters)))
    write(vector, "thruster_position", position)
    write(vector, "thruster_direction", direction)
    for name, row in rows.items():
        write(vector, name, row)
    return tuple(kinds) or (("", ""),)


def _characteristic(
    vehicle: Vehicle, kind: tuple[str, str], bench: BenchModel | None
) -> tuple[FloatArray, float, float]:
    """Table (2, speeds, codes) of thrust with its steps in speed and code."""
    if kind[0] == "":
        return np.zeros((2, 1, 2)), 1.0, 1.0
    characteristic = model_of(vehicle).thrusters[kind[0]].characteristic
    if isinstance(characteristic, FromBollard):
        return bollard_table(characteristic, vehicle.drives[kind[0]].code_max)
    if bench is None:
        raise CannotComputeError(
            f"drive {kind[0]} of {vehicle.name} takes its thrust from the bench tables, and there "
            f"are none; run `rig2sea run {vehicle.name}` first"
        )
    static = bench.static
    rows = _regular_rows(static)
    thrust = np.array(static.thrust_n)[rows]
    table = np.concatenate([np.zeros((len(rows), 1)), thrust], axis=1)
    return np.stack([table, table]), 0.1, float(static.code[1] - static.code[0])


def _shaft_tables(
    vehicle: Vehicle, kinds: tuple[tuple[str, str], ...], bench: BenchModel | None
) -> FloatArray | None:
    """Shaft speeds of the bench's family, where every thruster takes its thrust from it."""
    if bench is None or any(
        kind[0] == ""
        or isinstance(model_of(vehicle).thrusters[kind[0]].characteristic, FromBollard)
        for kind in kinds
    ):
        return None
    rows = _regular_rows(bench.static)
    rpm = np.array(bench.static.shaft_speed_rpm)[rows]
    return np.stack([np.concatenate([np.zeros((len(rows), 1)), rpm], axis=1)] * len(kinds))


def _regular_rows(static: StaticCharacteristic) -> list[int]:
    """Rows of the family at multiples of 0.1 m/s."""
    return [i for i, v in enumerate(static.speed_mps) if abs(v / 0.1 - round(v / 0.1)) < 1e-6]


def bollard_table(characteristic: FromBollard, code_max: int) -> tuple[FloatArray, float, float]:
    """Thrust T_max q (q - V / V_0) of both signs on a regular grid, (2, speeds, codes) [N]."""
    code = np.linspace(0.0, code_max, BOLLARD_CODES)
    speed = np.linspace(0.0, characteristic.zero_thrust_speed_mps, BOLLARD_SPEEDS)
    dead = characteristic.dead_zone_code
    s = np.maximum(code - dead, 0.0) / (code_max - dead)
    q = s ** (characteristic.exponent / 2.0)
    shape = np.maximum(q * (q - speed[:, None] / characteristic.zero_thrust_speed_mps), 0.0)
    table = np.stack([characteristic.thrust_max_n * shape, -characteristic.thrust_min_n * shape])
    return table, float(speed[1]), float(code[1])


def _balances(
    vehicle: Vehicle, kinds: tuple[tuple[str, str], ...], bench: BenchModel | None
) -> tuple[FloatArray, FloatArray]:
    """Propeller and drive of each kind for the balance in time; zeros where it is not used."""
    screws = np.zeros((len(kinds), SCREW_COLUMNS))
    torques = np.zeros((len(kinds), TORQUE_CODES, TORQUE_SPEEDS))
    screws[:, 0], screws[:, 7] = 1.0, 1.0
    for k, (drive, _) in enumerate(kinds):
        model = model_of(vehicle).thrusters.get(drive)
        if model is None or _inertia(model) == 0.0:
            continue
        if bench is None or bench.propeller is None or bench.surface is None:
            raise CannotComputeError(
                f"the torque balance of drive {drive} of {vehicle.name} is to be solved in time; "
                "that needs the fitted propeller and drive of the bench"
            )
        fastest = 1.5 * float(bench.surface.fastest_rps.max())
        shaft = np.linspace(0.0, fastest, TORQUE_SPEEDS)
        code_step = vehicle.drives[drive].code_max / (TORQUE_CODES - 1)
        codes = code_step * np.arange(TORQUE_CODES)
        # a drive under torque control gives no negative torque: it coasts
        torques[k] = np.maximum(drive_torque(shaft[None, :], codes[:, None], bench.surface), 0.0)
        screws[k] = [
            bench.propeller.diameter_m,
            *_three(bench.propeller.thrust_coefficients),
            *_three(bench.propeller.torque_coefficients),
            shaft[1],
        ]
    return screws, torques


def _inertia(model: ThrusterModel) -> float:
    """Rotor inertia where the balance is solved in time, else 0: the kernel's sign of a lag."""
    if not model.balance_in_time:
        return 0.0
    if model.rotor_inertia_kgm2 is None:
        raise CannotComputeError(
            "balance_in_time needs rotor_inertia_kgm2 of the same thruster model"
        )
    return model.rotor_inertia_kgm2


def _three(coefficients: FloatArray) -> tuple[float, float, float]:
    if len(coefficients) > 3:
        raise CannotComputeError("the balance in time takes quadratic K_T and K_M")
    padded = [*coefficients.tolist(), 0.0, 0.0, 0.0]
    return padded[0], padded[1], padded[2]


def _strips(model: Model) -> FloatArray:
    """Cross-flow strips (k, 3): place, C_d H dx, C_d B dx, by the trapezoid's Gauss points.

    Two Gauss points an interval integrate a linear section times a quadratic velocity exactly, and
    no interval is counted twice.
    """
    if model.crossflow is None:
        return np.zeros((0, 3))
    sections = sorted(model.crossflow.sections, key=lambda section: section.x_m)
    x = np.array([section.x_m for section in sections])
    size = np.array([(section.height_m, section.breadth_m) for section in sections])
    rows = []
    for low, high, start, end in zip(x[:-1], x[1:], size[:-1], size[1:], strict=True):
        for share in (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)):
            area = model.crossflow.drag_coefficient * (start + share * (end - start))
            rows.append([low + share * (high - low), *(area * (high - low) / 2.0)])
    return np.array(rows).reshape(-1, 3)


def _stack(tables: list[FloatArray]) -> FloatArray:
    """Stack tables of unequal size: the last row and column are repeated along their slope."""
    rows = max(table.shape[1] for table in tables)
    columns = max(table.shape[2] for table in tables)
    padded = []
    for table in tables:
        extra_rows, extra_columns = rows - table.shape[1], columns - table.shape[2]
        wide = np.pad(table, ((0, 0), (0, 0), (0, extra_columns)), mode="edge")
        if extra_rows:
            slope = wide[:, -1] - wide[:, -2] if wide.shape[1] > 1 else np.zeros_like(wide[:, -1])
            steps = np.arange(1, extra_rows + 1)[None, :, None]
            wide = np.concatenate([wide, wide[:, -1:] + slope[:, None] * steps], axis=1)
        padded.append(wide)
    return np.stack(padded)
