"""What a verdict changes in the vehicle file, and what no key of the file can say."""

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.effects.specification import EffectSpec
from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pack_hull import inertia_tensor, point_inertia
from pipeline.types import FloatArray
from pipeline.vehicle.frames import Change
from pipeline.vehicle.hull_shares import share_changes
from pipeline.vehicle.model_schema import FromBollard, Model
from pipeline.vehicle.schema import Vehicle


def file_changes(
    vehicle: Vehicle, model: Model, packed: PackedVehicle, vector: FloatArray
) -> dict[str, Change]:
    """Keys of the vehicle file (frame of the file's own model: SNAME) for a parameter vector.

    Parameters
    ----------
    vehicle, model : Vehicle, Model
        As the file states them.
    packed : PackedVehicle
        The same, packed.
    vector : ndarray
        Parameter vector with the effects of the verdict.
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
    if differs("thrust_gain"):
        gains = read(vector, "thrust_gain")[: len(names)].tolist()
        changes |= share_changes(model.thrust_deduction, names, gains)
    if differs("crossflow_fraction") and float(read(vector, "crossflow_fraction")) > 0.5:
        changes["model.crossflow.in_nominal"] = True
    changes |= _thrusters(vehicle, model, packed, vector)
    if differs("dvl_lever_arm") and vehicle.sensors is not None and vehicle.sensors.dvl is not None:
        place = np.array(vehicle.sensors.dvl.position_m) + read(vector, "dvl_lever_arm")
        changes["sensors.dvl.position_m"] = tuple(place.tolist())
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
    """Lag, reverse thrust and dead zone, where all thrusters of a drive changed alike."""
    changes: dict[str, Change] = {}
    old = packed.vector
    for drive, stated in model.thrusters.items():
        own = [k for k, one in enumerate(vehicle.thrusters) if one.drive == drive]
        if not own:
            continue

        def alike(name: str, own: Sequence[int] = own) -> tuple[float, float] | None:
            now, before = read(vector, name)[list(own)], read(old, name)[list(own)]
            if np.array_equal(now, before) or np.ptp(now) > 1e-12:
                return None
            return float(before[0]), float(now[0])

        lag = alike("lag")
        if lag is not None:
            changes[f"model.thrusters.{drive}.lag_s"] = lag[1]
        curve = stated.characteristic
        if not isinstance(curve, FromBollard):
            continue
        reverse, dead = alike("reverse_gain"), alike("dead_zone")
        key = f"model.thrusters.{drive}.characteristic"
        if reverse is not None:
            changes[f"{key}.thrust_min_n"] = curve.thrust_min_n * reverse[1] / reverse[0]
        if dead is not None:
            changes[f"{key}.dead_zone_code"] = curve.dead_zone_code + dead[1]
    return changes


def left_to_say(specs: Sequence[EffectSpec], changes: Mapping[str, Change]) -> tuple[str, ...]:
    """Effects that no key of the file can hold, as options of ``rig2sea simulate``."""
    written = {
        "added_mass": ("added_mass",),
        "linear_damping": ("damping.linear",),
        "quadratic_damping": ("damping.quadratic",),
        "residual_buoyancy": ("displaced_volume",),
        "cg_shift": ("centre_of_mass",),
        "payload": ("rigid_body",),
        "coriolis_omitted": ("terms.coriolis",),
        "advance_speed_loss": ("thrust_falls", "wake_fraction"),
        "crossflow_coupling": ("crossflow",),
        "thruster_lag": ("lag_s",),
        "thrust_deduction": ("thrust_deduction",),
        "thruster_degraded": ("thrust_deduction",),
        "reverse_thrust": ("thrust_min_n",),
        "dead_zone": ("dead_zone_code",),
        "dvl_lever_arm": ("dvl.position_m",),
    }
    return tuple(
        f"--effect {spec}"
        for spec in specs
        if not any(part in key for part in written.get(spec.id, ()) for key in changes)
    )
