"""Which keys of the vehicle file an identification changes, and to what."""

from collections.abc import Mapping

import numpy as np

from pipeline.identify.vehicle_parameters import AXES
from pipeline.records.identification import IdentifiedParameter, ThrustFound
from pipeline.simulate.pack_hull import added_mass_matrix
from pipeline.types import FloatArray
from pipeline.vehicle.frames import Change, changes_as_stated
from pipeline.vehicle.hull_shares import share_changes
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vehicle

_CENTRE = ("trim_x", "trim_y", "metacentric_height")


def file_changes(
    vehicle: Vehicle,
    model: Model,
    found: tuple[IdentifiedParameter, ...],
    thrust: tuple[ThrustFound, ...] = (),
) -> tuple[dict[str, Change], tuple[str, ...]]:
    """Say what to change in the vehicle file so that it gives the identified model.

    Written is what stands, with the values of the fit in which everything else was held at what the
    file says; the factors of the thrusters become their thrust deduction. Buoyancy becomes
    displaced volume, the heights between the centres become the place of the centre of buoyancy,
    ballast and payloads on board taken off both. Where the lift of the hull holds the Munk moment,
    its slopes are moved so that the moment of both together stays what it was in the fit.

    Parameters
    ----------
    vehicle : Vehicle
        As its file states it.
    model : Model
        Its model section.
    found : tuple of IdentifiedParameter
        Parameters of the whole-vehicle fit.
    thrust : tuple of ThrustFound
        What it made of the thrust.

    Returns
    -------
    dict of str to Change
        Dotted path -> value.
    tuple of str
        What could not be written as it was found.
    """
    values = {
        one.name: one.value if one.file_value is None else one.file_value
        for one in found
        if one.stands
    }
    changes: dict[str, Change] = {}
    damping, notes = _damping(values)
    changes |= damping
    changes |= _added_mass(model, values)
    changes |= _hydrostatics(vehicle, model, values)
    changes |= _lags(vehicle, model, values)
    changes |= _shares(vehicle, model, found, thrust)
    return changes_as_stated(changes, vehicle.frame), notes


def _damping(values: Mapping[str, float]) -> tuple[dict[str, float], tuple[str, ...]]:
    changes: dict[str, float] = {}
    notes = []
    for kind in ("linear", "quadratic"):
        for axis, name in enumerate(AXES):
            value = values.get(f"{kind}_damping_{name}")
            if value is None:
                continue
            if value < 0.0:
                notes.append(
                    f"{kind}_damping_{name} came out negative ({value:.4g}) and is written as 0: "
                    "a vehicle file states no damping that drives."
                )
            changes[f"model.damping.{kind}.{axis}"] = max(value, 0.0)
    return changes, tuple(notes)


def _added_mass(model: Model, values: Mapping[str, float]) -> dict[str, float]:
    before = added_mass_matrix(model)
    after = before.copy()
    for axis, name in enumerate(AXES):
        wanted = values.get(f"added_mass_{name}")
        if wanted is None:
            continue
        # as the fit does: couplings follow with the root of the factor
        wanted = max(wanted, 0.0)
        if after[axis, axis] > 0.0:
            root = np.sqrt(wanted / after[axis, axis])
            after[axis, :] *= root
            after[:, axis] *= root
        after[axis, axis] = wanted
    if model.added_mass.diagonal is not None:
        changes = {
            f"model.added_mass.diagonal.{axis}": float(after[axis, axis])
            for axis, name in enumerate(AXES)
            if f"added_mass_{name}" in values
        }
    else:
        changes = {
            f"model.added_mass.matrix.{i}.{j}": float(after[i, j])
            for i in range(6)
            for j in range(6)
            if after[i, j] != before[i, j]
        }
    return changes | _lift(model, before, after)


def _lift(model: Model, before: FloatArray, after: FloatArray) -> dict[str, float]:
    lift = model.lift
    if lift is None or not lift.includes_munk or not model.terms.coriolis:
        return {}
    moved, square = np.diag(after) - np.diag(before), lift.speed_mps**2
    found = {}
    if moved[2] != moved[0]:
        pitch = lift.pitch_nm_per_rad - square * float(moved[2] - moved[0])
        found["model.lift.pitch_nm_per_rad"] = pitch
    if moved[0] != moved[1]:
        yaw = lift.yaw_nm_per_rad + square * float(moved[0] - moved[1])
        found["model.lift.yaw_nm_per_rad"] = yaw
    return found


def _hydrostatics(vehicle: Vehicle, model: Model, values: Mapping[str, float]) -> dict[str, Change]:
    body, water = model.rigid_body, vehicle.water
    on_board = model.on_board
    mass = body.mass_kg + sum(one.mass_kg for one in on_board)
    carried = sum(one.volume_m3 for one in on_board)
    volume = body.displaced_volume_m3 + carried
    # first moments of volume and mass: totals less what the payloads add
    moment = body.displaced_volume_m3 * np.array(body.centre_of_buoyancy_m)
    of_payloads = np.zeros(3)
    mass_moment = body.mass_kg * np.array(body.centre_of_mass_m)
    for one in on_board:
        of_payloads += one.volume_m3 * np.array(one.position_m)
        mass_moment += one.mass_kg * np.array(one.position_m)
    centre = (moment + of_payloads) / volume
    wanted_volume = volume
    if "residual_buoyancy" in values:
        weight = mass * water.gravity_mps2
        total = weight + values["residual_buoyancy"]
        wanted_volume = total / (water.density_kgpm3 * water.gravity_mps2)
    wanted = centre.copy()
    for axis, name in enumerate(_CENTRE):
        if name in values:
            wanted[axis] = mass_moment[axis] / mass - values[name]
    changes: dict[str, Change] = {}
    if wanted_volume != volume:
        changes["model.rigid_body.displaced_volume_m3"] = wanted_volume - carried
    if wanted_volume != volume or (wanted != centre).any():
        own = (wanted_volume * wanted - of_payloads) / (wanted_volume - carried)
        changes["model.rigid_body.centre_of_buoyancy_m"] = tuple(own.tolist())
    return changes


def _lags(vehicle: Vehicle, model: Model, values: Mapping[str, float]) -> dict[str, float]:
    if "thruster_lag" not in values:
        return {}
    drives = [
        one.drive
        for one in vehicle.thrusters
        if model.thrusters[one.drive].lag_s > 0 and not model.thrusters[one.drive].balance_in_time
    ]
    if not drives:
        return {}
    stated = {drive: model.thrusters[drive].lag_s for drive in drives}
    mean = sum(stated[drive] for drive in drives) / len(drives)
    factor = max(values["thruster_lag"], 0.0) / mean
    return {f"model.thrusters.{drive}.lag_s": lag * factor for drive, lag in stated.items()}


def _shares(
    vehicle: Vehicle,
    model: Model,
    found: tuple[IdentifiedParameter, ...],
    thrust: tuple[ThrustFound, ...],
) -> dict[str, Change]:
    """Wake fraction with its standard uncertainty, and the thrust that each thruster has left."""
    names = [one.name for one in vehicle.thrusters]
    changes: dict[str, Change] = {}
    for one in found:
        if one.name == "wake_fraction" and one.stands and one.prior_value < 1.0:
            value = one.value if one.file_value is None else one.file_value
            by = (1.0 - value) / (1.0 - one.prior_value)
            left = [by * (1.0 - model.wake_fraction.of(name)) for name in names]
            changes |= share_changes(model.wake_fraction, names, left, one.std)
    factors = {one.name: one.file_value for one in thrust if one.file_value is not None}
    own = [factors.get(f"thrust_{name}", 1.0) for name in names]
    if any(factor != 1.0 for factor in own):
        stated = [1.0 - model.thrust_deduction.of(name) for name in names]
        left = [factor * share for factor, share in zip(own, stated, strict=True)]
        changes |= share_changes(model.thrust_deduction, names, left)
    return changes
