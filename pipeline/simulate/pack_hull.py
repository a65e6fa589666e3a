"""A vehicle's body, water and surroundings in the parameter vector, also for one run."""

import numpy as np

from pipeline.physics.carried_body import carry
from pipeline.physics.parameters import read, write
from pipeline.records.run_table import Conditions
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Lift, Model
from pipeline.vehicle.schema import Vehicle

_WITH_DENSITY = (
    "density",
    "buoyancy",
    "added_mass",
    "quadratic_damping",
    "heave_lift_slope",
    "sway_lift_slope",
    "pitch_lift_slope",
    "yaw_lift_slope",
    "turnover_slope",
)


def vector_under(known: Conditions, vector: FloatArray) -> FloatArray:
    """Return the parameter vector of a run for one of the vehicle; that one is not changed.

    Applied last, on whatever vector is asked for: effects switched on, free parameters moved.
    Buoyancy, added mass, quadratic damping and lift are in proportion to the density of the water;
    linear damping and the thrust at a code stay, because viscosity and the drive decide them.
    `known` says how the vehicle differed from its file.

    Raises
    ------
    CannotComputeError
        When nothing of the vehicle's mass or buoyancy would be left.
    """
    if known.as_stated:
        return vector
    found = vector.copy()
    if known.density_kgpm3 is not None:
        share = known.density_kgpm3 / float(read(found, "density"))
        for name in _WITH_DENSITY:
            read(found, name)[...] *= share
    for body in known.bodies:
        carry(
            found,
            body.mass_kg,
            body.volume_m3,
            np.array(body.position_m),
            gravity_mps2=known.gravity_mps2,
            inertia_kgm2=np.array(body.inertia_kgm2),
            name=body.name,
        )
    return found


def write_body(vector: FloatArray, model: Model, gravity: float, density: float) -> None:
    """Write body, ballast, attached payloads, added mass and damping into a vector, in place."""
    body = model.rigid_body
    parts = [(body.mass_kg, np.array(body.centre_of_mass_m), inertia_tensor(body.inertia_kgm2))]
    volumes = [(body.displaced_volume_m3, np.array(body.centre_of_buoyancy_m))]
    for one in model.on_board:
        place = np.array(one.position_m)
        parts.append((one.mass_kg, place, np.diag(one.inertia_kgm2)))
        volumes.append((one.volume_m3, place))
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


def write_lift(vector: FloatArray, vehicle: Vehicle, model: Model) -> None:
    """Write lift slopes per speed squared, in place; the Munk moment is counted once.

    C(nu) nu holds the Munk moments (A_33 - A_11) u w in pitch and (A_11 - A_22) u v in yaw. A
    measured or computed moment against the angle of attack holds them too, so they are taken off.
    What is left is the moment of the lift force as far as that can make it at an end of the hull,
    and goes with |u|; the rest of it, and Munk's where C(nu) nu is left out, turns over with u.
    """
    lift = model.lift if model.lift is not None else Lift(speed_mps=1.0, includes_munk=False)
    per_speed = 1.0 / lift.speed_mps**2
    held = np.array(munk_held(model))
    munk = held if model.terms.coriolis else np.zeros(2)
    force = np.array([lift.heave_n_per_rad, lift.sway_n_per_rad]) * per_speed
    moment = np.array([-lift.pitch_nm_per_rad, lift.yaw_nm_per_rad]) * per_speed
    largest = np.abs(force) * hull_end_m(vehicle, model)
    write(vector, "heave_lift_slope", force[0])
    write(vector, "sway_lift_slope", force[1])
    write(vector, "pitch_lift_slope", moment[0] - munk[0])
    write(vector, "yaw_lift_slope", moment[1] - munk[1])
    fixed = np.clip(moment - held, -largest, largest)
    write(vector, "turnover_slope", moment - munk - fixed)


def munk_held(model: Model) -> tuple[float, float]:
    """Munk moments of pitch and yaw that the file's lift slopes hold [kg]."""
    if model.lift is None or not model.lift.includes_munk:
        return 0.0, 0.0
    a = added_mass_matrix(model)
    return float(a[2, 2] - a[0, 0]), float(a[0, 0] - a[1, 1])


def hull_end_m(vehicle: Vehicle, model: Model) -> float:
    """Distance of the hull's farther end from the origin, by its sections and thrusters [m]."""
    places = [one.position_m[0] for one in vehicle.thrusters]
    if model.crossflow is not None:
        places += [section.x_m for section in model.crossflow.sections]
    return max((abs(x) for x in places), default=0.0)


def write_surroundings(vector: FloatArray, model: Model) -> None:
    """Write current, cross-flow, walls and what is known of the tether into a vector, in place."""
    write(vector, "current", np.array(model.current_ned_mps))
    write(vector, "tether_drag_area", model.lumped_tether.drag_area_m2)
    write(vector, "tether_pull", model.lumped_tether.pull_n)
    if model.crossflow is not None and model.crossflow.in_nominal:
        write(vector, "crossflow_fraction", 1.0)
    if model.pool is not None:
        walls = model.pool.walls
        write(vector, "wall_count", float(len(walls)))
        write(vector, "wall_radius", model.pool.vehicle_radius_m)
        write(vector, "wall_strength", model.pool.strength)
        points = np.zeros((5, 3))
        normals = np.zeros((5, 3))
        points[: len(walls)] = [wall.point_ned_m for wall in walls]
        normals[: len(walls)] = [wall.normal_ned for wall in walls]
        write(vector, "wall_point", points)
        write(vector, "wall_normal", normals)
    if model.tether is not None:
        write(vector, "tether_point", np.array(model.tether.attachment_m))
        write(vector, "tether_anchor", np.array(model.tether.anchor_ned_m))


def crossflow_strips(model: Model) -> FloatArray:
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
