"""A parameter vector as keys of the vehicle file: the way back from `pack`."""

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.simulate.kernel_alone import fill_directions
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pack_hull import inertia_tensor, point_inertia
from pipeline.types import FloatArray
from pipeline.vehicle.estimates import share_changes
from pipeline.vehicle.frames import Change
from pipeline.vehicle.model_schema import FromBollard, Lift, Model
from pipeline.vehicle.schema import LEAST_GAIN, Vehicle


def changed_keys(
    vehicle: Vehicle, model: Model, packed: PackedVehicle, vector: FloatArray
) -> dict[str, Change]:
    """Keys of the vehicle file (frame of the file's own model: SNAME) for a parameter vector.

    `vehicle` and `model` are as the file states them, `packed` the same, `vector` that of the
    vehicle as it is to be.
    """
    old = packed.vector
    changes: dict[str, Change] = {}

    def differs(name: str) -> bool:
        return not np.array_equal(read(old, name), read(vector, name))

    changes |= _hull(model, old, vector)
    changes |= _body(model, vehicle, old, vector)
    if differs("coriolis_fraction") and float(read(vector, "coriolis_fraction")) > 0.5:
        changes["model.terms.coriolis"] = True
    names = packed.thruster_names
    if differs("inflow_fraction"):
        if not model.terms.thrust_falls_with_speed:
            changes["model.terms.thrust_falls_with_speed"] = True
        shares = read(vector, "inflow_fraction")[: len(names)].tolist()
        if [model.wake_fraction.of(name) for name in names] != [1.0 - one for one in shares]:
            changes |= share_changes(model.wake_fraction, names, shares)
    if differs("crossflow_fraction") and model.crossflow is not None:
        # the force is linear in both
        changes["model.crossflow.in_nominal"] = True
        share = float(read(vector, "crossflow_fraction")) / (
            float(read(old, "crossflow_fraction")) or 1.0
        )
        changes["model.crossflow.drag_coefficient"] = model.crossflow.drag_coefficient * share
    changes |= _thrusters(vehicle, model, packed, vector)
    changes |= _lift(model, old, vector)
    for name, key in (
        ("supply_drop", "model.supply.drop"),
        ("load_drop", "model.supply.load_drop"),
        ("tether_drag_area", "model.lumped_tether.drag_area_m2"),
        ("tether_pull", "model.lumped_tether.pull_n"),
        ("wall_strength", "model.pool.strength"),
    ):
        if differs(name):
            changes[key] = float(read(vector, name))
    if differs("current"):
        changes["model.current_ned_mps"] = tuple(read(vector, "current").tolist())
    return changes | _dvl(vehicle, vector)


def _dvl(vehicle: Vehicle, vector: FloatArray) -> dict[str, Change]:
    """Return where the DVL sits, how it is turned, how late it is and what it reads too much."""
    if vehicle.sensors is None or vehicle.sensors.dvl is None:
        return {}
    dvl, changes = vehicle.sensors.dvl, dict[str, Change]()
    arm, turn = read(vector, "dvl_lever_arm"), read(vector, "dvl_rotation")
    if arm.any():
        changes["sensors.dvl.position_m"] = tuple((np.array(dvl.position_m) + arm).tolist())
    if turn.any():
        stated = Rotation.from_euler("ZYX", np.radians(dvl.rotation_deg)[::-1])
        now = stated * Rotation.from_euler("ZYX", turn[::-1])
        angles = now.as_euler("ZYX", degrees=True)[::-1]
        changes["sensors.dvl.rotation_deg"] = tuple(angles.tolist())
    late, factor = float(read(vector, "dvl_delay")), float(read(vector, "dvl_scale"))
    if late:
        changes["sensors.dvl.delay_s"] = max(dvl.delay_s + late, 0.0)
    if factor != 1.0:
        changes["sensors.dvl.scale"] = dvl.scale * factor
    return changes


def _lift(model: Model, old: FloatArray, vector: FloatArray) -> dict[str, Change]:
    """Return the slopes of the hull's lift, as the file states them at its speed.

    Where they hold the Munk moment they move with the added masses that it is made of.
    """
    lift = model.lift or Lift(speed_mps=1.0, includes_munk=False)
    changes: dict[str, Change] = {}
    moved = np.diag(read(vector, "added_mass") - read(old, "added_mass"))
    held = lift.includes_munk and model.terms.coriolis
    munk = {"pitch": moved[2] - moved[0], "yaw": moved[0] - moved[1]} if held else {}
    for slot, key, sign in (
        ("heave_lift_slope", "heave_n_per_rad", 1.0),
        ("sway_lift_slope", "sway_n_per_rad", 1.0),
        ("pitch_lift_slope", "pitch_nm_per_rad", -1.0),
        ("yaw_lift_slope", "yaw_nm_per_rad", 1.0),
    ):
        more = float(read(vector, slot) - read(old, slot) + munk.get(key.split("_")[0], 0.0))
        if more:
            stated = float(getattr(lift, key))
            changes[f"model.lift.{key}"] = stated + sign * more * lift.speed_mps**2
    if changes and model.lift is None:
        changes |= {"model.lift.speed_mps": 1.0, "model.lift.includes_munk": False}
    return changes


def _hull(model: Model, old: FloatArray, vector: FloatArray) -> dict[str, Change]:
    """Return added mass and damping, the entries that changed."""
    changes: dict[str, Change] = {}
    matrix, before = read(vector, "added_mass"), read(old, "added_mass")
    if not np.array_equal(matrix, before):
        if model.added_mass.diagonal is not None:
            for axis in np.flatnonzero(np.diag(matrix) != np.diag(before)).tolist():
                changes[f"model.added_mass.diagonal.{axis}"] = float(matrix[axis, axis])
        else:
            for row, column in np.argwhere(matrix != before).tolist():
                changes[f"model.added_mass.matrix.{row}.{column}"] = float(matrix[row, column])
    ways = {
        "linear": (np.diag(read(vector, "linear_damping")), np.diag(read(old, "linear_damping"))),
        "quadratic": (read(vector, "quadratic_damping"), read(old, "quadratic_damping")),
    }
    for kind, (now, was) in ways.items():
        for axis in np.flatnonzero(now != was).tolist():
            changes[f"model.damping.{kind}.{axis}"] = float(now[axis])
    return changes


def _body(model: Model, vehicle: Vehicle, old: FloatArray, vector: FloatArray) -> dict[str, Change]:
    """Mass, volume, their centres and the inertia of the dry body (payloads on board stay)."""
    body, stated = model.rigid_body, "model.rigid_body"
    changes: dict[str, Change] = {}

    def more(name: str) -> FloatArray:
        return np.asarray(read(vector, name) - read(old, name))

    def more_of(size: str, centre: str) -> FloatArray:
        now, before = read(vector, size) * read(vector, centre), read(old, size) * read(old, centre)
        return np.asarray(now - before)

    weight_per_volume = vehicle.water.density_kgpm3 * vehicle.water.gravity_mps2
    mass = body.mass_kg + float(more("mass"))
    volume = body.displaced_volume_m3 + float(more("buoyancy")) / weight_per_volume
    if mass != body.mass_kg:
        changes[f"{stated}.mass_kg"] = mass
    if volume != body.displaced_volume_m3:
        changes[f"{stated}.displaced_volume_m3"] = volume
    centre = np.array(body.centre_of_mass_m)
    moment = more_of("mass", "centre_of_mass")
    if np.abs(moment).max() > 0.0:
        centre = (body.mass_kg * centre + moment) / mass
        changes[f"{stated}.centre_of_mass_m"] = tuple(centre.tolist())
    lift = more_of("buoyancy", "centre_of_buoyancy") / weight_per_volume
    if np.abs(lift).max() > 0.0:
        place = (body.displaced_volume_m3 * np.array(body.centre_of_buoyancy_m) + lift) / volume
        changes[f"{stated}.centre_of_buoyancy_m"] = tuple(place.tolist())
    before = inertia_tensor(body.inertia_kgm2)
    # the vector has it about the body's origin, the file about the centre of mass
    about_origin = before + point_inertia(body.mass_kg, np.array(body.centre_of_mass_m))
    tensor = about_origin + more("inertia") - point_inertia(mass, centre)
    if not np.allclose(tensor, before, rtol=1e-9, atol=1e-9):
        changes[f"{stated}.inertia_kgm2"] = (
            *np.diag(tensor).tolist(),
            *(-float(tensor[row, column]) for row, column in ((0, 1), (0, 2), (1, 2))),
        )
    return changes


def _thrusters(
    vehicle: Vehicle, model: Model, packed: PackedVehicle, vector: FloatArray
) -> dict[str, Change]:
    """Gains, directions, lags, dead zones; of a drive where all its thrusters changed alike."""
    old, names = packed.vector, packed.thruster_names
    count = len(names)
    changes = _gains(vehicle, model, packed, vector)
    for slot, key, of_drive in (
        ("lag", "lag_s", "lag_s"),
        ("rotor_inertia", "", "rotor_inertia_kgm2"),
        ("dead_zone", "dead_zone_code", "characteristic.dead_zone_code"),
    ):
        now, before = (read(one, slot)[:count] for one in (vector, old))
        for drive, stated in model.thrusters.items():
            own = [k for k, one in enumerate(vehicle.thrusters) if one.drive == drive]
            moved = [k for k in own if now[k] != before[k]]
            if not moved:
                continue
            alike = len(moved) == len(own) and np.ptp(now[own] - before[own]) <= 1e-12
            if slot == "dead_zone" and alike and isinstance(stated.characteristic, FromBollard):
                more = float(now[own[0]] - before[own[0]])
                held = stated.characteristic.dead_zone_code
                changes[f"model.thrusters.{drive}.{of_drive}"] = held + more
            elif slot != "dead_zone" and alike and np.ptp(now[own]) <= 1e-12:
                changes[f"model.thrusters.{drive}.{of_drive}"] = float(now[own[0]])
            elif key:
                changes |= {f"thrusters.{k}.{key}": float(now[k]) for k in moved}
    tilt = [read(vector, f"misalignment_{angle}")[:count] for angle in ("azimuth", "elevation")]
    if any(angle.any() for angle in tilt):
        directions = np.zeros((MOST_THRUSTERS, 3))
        fill_directions(vector, directions)
        for k in np.flatnonzero(tilt[0].astype(bool) | tilt[1].astype(bool)).tolist():
            changes[f"thrusters.{k}.direction"] = tuple(directions[k].tolist())
    return changes


def _gains(
    vehicle: Vehicle, model: Model, packed: PackedVehicle, vector: FloatArray
) -> dict[str, Change]:
    """Return thrust deduction for what all have in common, the rest as each thruster's gains."""
    old, names = packed.vector, packed.thruster_names
    if not names:
        return {}
    both = [
        read(vector, slot)[: len(names)] / np.maximum(read(old, slot)[: len(names)], 1e-12)
        for slot in ("thrust_gain", "reverse_gain")
    ]
    ratio, astern = both
    changes: dict[str, Change] = {}
    values, counts = np.unique(ratio.round(9), return_counts=True)
    # what most have in common is the hull's; of two that differ the one nearer to 1
    common = float(values[np.lexsort((np.abs(np.log(np.maximum(values, 1e-9))), -counts))[0]])
    if common != 1.0 and counts.max() > 1:
        left = [(1.0 - model.thrust_deduction.of(name)) * common for name in names]
        changes |= share_changes(model.thrust_deduction, names, left)
        ratio = ratio / common
    drives = {one.drive for one in vehicle.thrusters}
    for drive in drives if np.ptp(astern) <= 1e-12 and astern[0] != 1.0 else ():
        curve = model.thrusters[drive].characteristic
        if isinstance(curve, FromBollard):
            key = f"model.thrusters.{drive}.characteristic.thrust_min_n"
            changes[key] = curve.thrust_min_n * float(astern[0])
    for k, one in enumerate(vehicle.thrusters):
        written = f"model.thrusters.{one.drive}.characteristic.thrust_min_n" in changes
        back = float(ratio[k]) * (1.0 if written else float(astern[k]))
        for key, stated, factor in (
            ("gain_ahead", one.gain_ahead, float(ratio[k])),
            ("gain_reverse", one.gain_reverse, back),
        ):
            if abs(factor - 1.0) > 1e-9:
                gain = stated * factor
                changes[f"thrusters.{k}.{key}"] = gain if gain >= LEAST_GAIN else 0.0
    return changes
