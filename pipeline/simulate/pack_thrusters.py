"""A vehicle's thrusters: their entries of the parameter vector, and the tables beside it."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.drive import drive_torque
from pipeline.physics.parameters import MOST_THRUSTERS, write
from pipeline.physics.propeller import polynomial
from pipeline.physics.torque_balance import OpenWaterPropeller, first_zero
from pipeline.records.fits import SignedFamily, StaticCharacteristic, ThrustFamily
from pipeline.simulate.context import BenchModel, model_of
from pipeline.simulate.kernel_thrusters import SCREW_COLUMNS
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import FromBollard, FromMooring, FromTables, ThrusterModel
from pipeline.vehicle.schema import Vehicle

#: Columns of a bollard characteristic's table, as many as codes from 0 to 128.
BOLLARD_CODES = 129
BOLLARD_SPEEDS = 41
#: Rows of a table from the bench. [m/s]
SPEED_STEP_MPS = 0.1
#: Grid of the drive's torque for the balance in time.
TORQUE_CODES = 128
TORQUE_SPEEDS = 400


def write_thrusters(vector: FloatArray, vehicle: Vehicle) -> tuple[tuple[str, str], ...]:
    """Write the thrusters; returns the kinds (drive, propeller) in the order of their index."""
    kinds: list[tuple[str, str]] = []
    rows = {
        name: np.zeros(MOST_THRUSTERS)
        for name in (
            "thruster_type",
            "drive_dead",
            "dead_zone",
            "lag",
            "rotor_inertia",
            "inflow_fraction",
            "thrust_gain",
            "code_max",
            "code_min",
        )
    }
    rows["code_max"][:], rows["code_min"][:] = 1.0, -1.0
    rows["thrust_gain"][:], rows["reverse_gain"] = 1.0, np.ones(MOST_THRUSTERS)
    model = model_of(vehicle)
    falls = model.terms.thrust_falls_with_speed
    position, direction = np.zeros((MOST_THRUSTERS, 3)), np.zeros((MOST_THRUSTERS, 3))
    for i, thruster in enumerate(vehicle.thrusters):
        kind = (thruster.drive, thruster.propeller)
        if kind not in kinds:
            kinds.append(kind)
        drive = model.thrusters[thruster.drive]
        rows["thruster_type"][i] = kinds.index(kind)
        if isinstance(drive.characteristic, FromBollard):
            rows["drive_dead"][i] = drive.characteristic.dead_zone_code
        rows["dead_zone"][i] = thruster.dead_zone_code
        rows["lag"][i] = drive.lag_s if thruster.lag_s is None else thruster.lag_s
        rows["rotor_inertia"][i] = _inertia(drive)
        rows["inflow_fraction"][i] = 1.0 - model.wake_fraction.of(thruster.name) if falls else 0.0
        deduction = model.thrust_deduction.of(thruster.name)
        # a thruster that is dead ahead alone has its thrust in the other factor
        ahead = thruster.gain_ahead or (1e-9 if thruster.gain_reverse else 0.0)
        rows["thrust_gain"][i] = ahead * (1.0 - deduction)
        rows["code_max"][i] = vehicle.drives[thruster.drive].code_max
        rows["code_min"][i] = vehicle.drives[thruster.drive].code_min
        rows["reverse_gain"][i] = thruster.gain_reverse / ahead if ahead else 1.0
        position[i] = thruster.position_m
        direction[i] = np.array(thruster.direction) / np.linalg.norm(thruster.direction)
    write(vector, "thruster_count", float(len(vehicle.thrusters)))
    write(vector, "thruster_position", position)
    write(vector, "thruster_direction", direction)
    write(vector, "supply_drop", model.supply.drop)
    write(vector, "load_drop", model.supply.load_drop)
    for name, row in rows.items():
        write(vector, name, row)
    return tuple(kinds) or (("", ""),)


def thrust_table(
    vehicle: Vehicle, kind: tuple[str, str], bench: BenchModel | None
) -> tuple[FloatArray, float, float]:
    """Table (2, speeds, codes) of thrust with its steps in speed and code."""
    if kind[0] == "":
        return np.zeros((2, 1, 2)), 1.0, 1.0
    characteristic = model_of(vehicle).thrusters[kind[0]].characteristic
    if isinstance(characteristic, FromBollard):
        table, *steps = bollard_table(characteristic, vehicle.drives[kind[0]].code_max)
        return with_drag(table, characteristic.free_drag_ns2pm2, steps[0]), steps[0], steps[1]
    bench = bench if bench is None else bench.of(kind)
    if bench is not None and bench.family is not None:
        falls = characteristic if isinstance(characteristic, FromMooring) else None
        stops = None if falls is None else falls.zero_thrust_speed_mps
        table, *steps = family_table(bench.family, stops)
        return with_drag(table, bench.family.free_drag_ns2pm2, steps[0]), steps[0], steps[1]
    if bench is None or bench.static is None:
        raise CannotComputeError(
            f"drive {kind[0]} of {vehicle.name} takes its thrust from the bench tables, and there "
            f"are none; run `rig2sea run {vehicle.name}` first"
        )
    static = bench.static
    rows = _regular_rows(static)
    thrust = np.array(static.thrust_n)[rows]
    table = np.concatenate([np.zeros((len(rows), 1)), thrust], axis=1)
    both = with_drag(np.stack([table, table]), static.free_drag_ns2pm2, SPEED_STEP_MPS)
    return both, SPEED_STEP_MPS, float(static.code[1] - static.code[0])


def with_drag(table: FloatArray, drag_ns2pm2: float, speed_step_mps: float) -> FloatArray:
    """Put into the dead zone of a table (2, speeds, codes) the drag of the undriven propeller. [N].

    From that of a free one at code 0 straight to nothing at the edge, as the firmware has it.
    """
    if drag_ns2pm2 == 0.0:
        return table
    out, code = table.copy(), np.arange(table.shape[2])
    for row in range(table.shape[1]):
        drag = drag_ns2pm2 * (row * speed_step_mps) ** 2
        for side in range(len(table)):
            live = np.flatnonzero(table[side, row] > 0.0)
            edge = max(int(live[0]) - 1 if live.size else len(code) - 1, 1)
            out[side, row, :edge] = -drag * (1.0 - code[:edge] / edge)
    return out


def shaft_tables(
    vehicle: Vehicle, kinds: tuple[tuple[str, str], ...], bench: BenchModel | None
) -> FloatArray | None:
    """Shaft speeds of the bench's family, where every thruster takes its thrust from it."""
    tables = []
    for kind in kinds:
        static = None if bench is None else bench.of(kind).static
        if (
            static is None
            or kind[0] == ""
            or not isinstance(model_of(vehicle).thrusters[kind[0]].characteristic, FromTables)
        ):
            return None
        rows = _regular_rows(static)
        rpm = np.array(static.shaft_speed_rpm)[rows]
        tables.append(np.concatenate([np.zeros((len(rows), 1)), rpm], axis=1)[None])
    return stacked(tables)[:, 0]


def _regular_rows(static: StaticCharacteristic) -> list[int]:
    """Rows of the family at multiples of 0.1 m/s."""
    return [i for i, v in enumerate(static.speed_mps) if abs(v / 0.1 - round(v / 0.1)) < 1e-6]


def family_table(
    family: ThrustFamily, zero_thrust_speed_mps: float | None
) -> tuple[FloatArray, float, float]:
    """Measured thrust of both signs on a regular grid, (2, speeds, codes) [N]."""
    sides = (family.positive, family.negative)
    code = np.array(family.positive.code)
    last = min(side.speed_mps[-1] for side in sides)
    if last > 0.0:
        rows = int(last / SPEED_STEP_MPS + 1e-6) + 1
        speed = np.linspace(0.0, SPEED_STEP_MPS * (rows - 1), rows)
        table = [_rows_at(side, speed) for side in sides]
        return np.stack(table), SPEED_STEP_MPS, float(code[1] - code[0])
    rest = np.array([side.thrust_n[0] for side in sides])[:, None, :]
    if zero_thrust_speed_mps is None:
        return rest, 1.0, float(code[1] - code[0])
    speed = np.linspace(0.0, zero_thrust_speed_mps, BOLLARD_SPEEDS)
    slope = np.sqrt(rest * rest.max(axis=2, keepdims=True)) / zero_thrust_speed_mps
    falling = np.maximum(rest - slope * speed[None, :, None], 0.0)
    return falling, float(speed[1]), float(code[1] - code[0])


def _rows_at(side: SignedFamily, speed_mps: FloatArray) -> FloatArray:
    columns = np.array(side.thrust_n).T
    return np.stack([np.interp(speed_mps, side.speed_mps, column) for column in columns], axis=1)


def bollard_table(characteristic: FromBollard, code_max: int) -> tuple[FloatArray, float, float]:
    """Thrust T_max q (q - V / V_0) of both signs on a regular grid, (2, speeds, codes) [N].

    Both sides end at `code_max`: `thrust_min_n` is the thrust at -code_max, which a drive whose
    codes end before does not reach.
    """
    code = np.linspace(0.0, code_max, BOLLARD_CODES)
    speed = np.linspace(0.0, characteristic.zero_thrust_speed_mps, BOLLARD_SPEEDS)
    dead = characteristic.dead_zone_code
    s = np.maximum(code - dead, 0.0) / (code_max - dead)
    q = s ** (characteristic.exponent / 2.0)
    shape = np.maximum(q * (q - speed[:, None] / characteristic.zero_thrust_speed_mps), 0.0)
    table = np.stack([characteristic.thrust_max_n * shape, -characteristic.thrust_min_n * shape])
    return table, float(speed[1]), float(code[1])


def balance_tables(
    vehicle: Vehicle, kinds: tuple[tuple[str, str], ...], bench: BenchModel | None
) -> tuple[FloatArray, FloatArray]:
    """Propeller and drive of each kind for the balance in time; zeros where it is not used."""
    screws = np.zeros((len(kinds), SCREW_COLUMNS))
    torques = np.zeros((len(kinds), TORQUE_CODES, TORQUE_SPEEDS))
    screws[:, 0], screws[:, 7], screws[:, 8] = 1.0, 1.0, 1.0
    for k, kind in enumerate(kinds):
        drive, own = kind[0], None if bench is None else bench.of(kind)
        model = model_of(vehicle).thrusters.get(drive)
        if model is None or _inertia(model) == 0.0:
            continue
        if own is None or own.propeller is None or own.surface is None:
            raise CannotComputeError(
                f"the torque balance of drive {drive} of {vehicle.name} is to be solved in time; "
                "that needs the fitted propeller and drive of the bench"
            )
        fastest = 1.5 * float(own.surface.fastest_rps.max())
        shaft = np.linspace(0.0, fastest, TORQUE_SPEEDS)
        code_step = vehicle.drives[drive].code_max / (TORQUE_CODES - 1)
        codes = code_step * np.arange(TORQUE_CODES)
        # a drive under torque control gives no negative torque: it coasts
        torques[k] = np.maximum(drive_torque(shaft[None, :], codes[:, None], own.surface), 0.0)
        screws[k] = [
            own.propeller.diameter_m,
            *_three(own.propeller.thrust_coefficients),
            *_three(own.propeller.torque_coefficients),
            shaft[1],
            code_step,
            _free_thrust(own.propeller),
        ]
    return screws, torques


def _free_thrust(propeller: OpenWaterPropeller) -> float:
    """K_T / J^2 where K_M falls to zero, 0 where it does not. [-]."""
    at = first_zero(propeller.torque_coefficients)
    if not np.isfinite(at):
        return 0.0
    return min(float(polynomial(at, propeller.thrust_coefficients)) / at**2, 0.0)


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


def stacked(tables: list[FloatArray]) -> FloatArray:
    """Stack tables of unequal size, those that end earlier continued along their last slope."""
    rows = max(table.shape[1] for table in tables)
    columns = max(table.shape[2] for table in tables)
    return np.stack([_continued(_continued(table, 2, columns), 1, rows) for table in tables])


def _continued(table: FloatArray, axis: int, length: int) -> FloatArray:
    """Continue a table (2, speeds, codes) along its last slope to a length of an axis."""
    last = np.moveaxis(table, axis, 0)
    extra = length - len(last)
    if not extra:
        return table
    slope = last[-1] - last[-2] if len(last) > 1 else np.zeros_like(last[-1])
    beyond = last[-1] + slope * np.arange(1, extra + 1)[:, None, None]
    return np.moveaxis(np.concatenate([last, beyond]), 0, axis)
