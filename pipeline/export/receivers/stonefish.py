"""Stonefish: a scenario with the vehicle as a robot of one link, for its versions 1.5 and 1.6.

World and body axes are those of SNAME. Mass, centre of gravity and moments of inertia are stated;
buoyancy, added mass and drag are worked out by Stonefish of the link's mesh, here a cylinder along
x of the displaced volume. Its added mass is one number for all directions, the mean of what it
takes for the cylinder; length and radius are those whose mean is the vehicle's. Drag is a sum over
the faces, with v the velocity of the water past a face of area A and normal n outwards:

    form drag  rho C_d / 2 v |v| (-v.n) A where v.n < 0,    friction  rho C_f v_t A

so that it goes with the cube of the speed and with the speed; the coefficients of each axis are
fitted to the vehicle's damping up to the speed that half the thrust reaches. A thruster takes a
code, which lags, to thrust by a table (Stonefish, SolidEntity.cpp and docs/actuators.rst).
"""

import xml.etree.ElementTree as ET
from collections.abc import Callable

import numpy as np

from pipeline.export.receivers.exported import Exported, Subject, numbers
from pipeline.physics.parameters import read
from pipeline.types import FloatArray

#: Slices of a cylinder, and how far its length may be from its diameter.
_SLICES, _SLENDEREST = 32, 10.0
_AXES = 3


def stonefish(subject: Subject) -> Exported:
    """Return the scenario, and the motion by the equations above."""
    packed, vector = subject.packed, subject.packed.vector
    density = float(read(vector, "density"))
    length, radius = _cylinder(vector, packed.context.gravity_mps2)
    form, friction = _coefficients(subject, length, radius)
    root = ET.Element("scenario")
    water = ET.SubElement(ET.SubElement(root, "environment"), "ocean")
    ET.SubElement(water, "water", density=f"{density:.9g}", jerlov="0.2")
    if np.any(read(vector, "current")):
        stream = ET.SubElement(water, "current", type="uniform")
        ET.SubElement(stream, "velocity", xyz=numbers(read(vector, "current")))
    materials = ET.SubElement(root, "materials")
    ET.SubElement(materials, "material", name="Hull", density="1000.0", restitution="0.5")
    looks = ET.SubElement(root, "looks")
    ET.SubElement(looks, "look", name="Yellow", rgb="1.0 0.9 0.0", roughness="0.3")
    robot = ET.SubElement(root, "robot", name=packed.name, fixed="false", self_collisions="false")
    link = ET.SubElement(
        robot, "base_link", name="Hull", type="cylinder", physics="submerged", buoyant="true"
    )
    ET.SubElement(link, "dimensions", radius=f"{radius:.9g}", height=f"{length:.9g}")
    at = numbers(read(vector, "centre_of_buoyancy"))
    ET.SubElement(link, "origin", xyz=at, rpy=f"0 {np.pi / 2:.9g} 0")
    ET.SubElement(link, "material", name="Hull")
    ET.SubElement(link, "look", name="Yellow")
    ET.SubElement(link, "mass", value=f"{float(read(vector, 'mass')):.9g}")
    ET.SubElement(link, "inertia", xyz=numbers(_moments(vector)))
    ET.SubElement(link, "cg", xyz=numbers(read(vector, "centre_of_mass")), rpy="0 0 0")
    ET.SubElement(
        link, "hydrodynamics", viscous_drag=numbers(friction), quadratic_drag=numbers(form)
    )
    for k, name in enumerate(packed.thruster_names):
        _thruster(robot, subject, k, name)
    ET.SubElement(robot, "world_transform", xyz="0 0 5", rpy="0 0 0")
    ET.indent(root)
    body = ET.tostring(root, encoding="unicode") + "\n"
    return Exported(
        file=f"{packed.name}.scn",
        text=lambda head: f'<?xml version="1.0"?>\n<!--\n{head}-->\n{body}',
        # two hyphens would end the comment
        comment=lambda line: "  " + line.replace("--", "- -"),
        says=(
            "Setpoints of the thrusters are codes, in the order of vehicle.yaml.",
            "A mesh propeller.obj must lie in the data folder; it is only drawn.",
        ),
        lost=(
            "added mass by direction (one number for all three), and so no Munk moment",
            "drag that goes with the square of the speed, and damping of turns as stated",
            "products of inertia, lift, walls, tether; the hull is a cylinder of the same volume",
            "thrust that falls with speed, drag of an undriven propeller, supply voltage",
        ),
        vector=vector,
        fly=_motion(subject, length, radius, form, friction),
    )


def _moments(vector: FloatArray) -> FloatArray:
    """Moments of inertia (3,) about the centre of mass. [kg m^2]."""
    mass, centre = float(read(vector, "mass")), read(vector, "centre_of_mass")
    about = np.diag(np.asarray(read(vector, "inertia"))) - mass * (centre @ centre - centre**2)
    return np.maximum(about, 1e-6)


def _cylinder(vector: FloatArray, gravity_mps2: float) -> tuple[float, float]:
    """Length and radius of the displaced volume whose mean added mass is nearest the vehicle's."""
    density = float(read(vector, "density"))
    volume = float(read(vector, "buoyancy")) / (density * gravity_mps2)
    mean = float(np.diag(read(vector, "added_mass"))[:_AXES].mean())
    # Stonefish: rho pi r^2 along the axis (a length is missing there), rho pi r^2 L across
    over = 3.0 * mean / (density * volume) - 2.0
    ends = [(4.0 * volume * x**2 / np.pi) ** (1 / 3) for x in (1 / _SLENDEREST, _SLENDEREST)]
    length = float(np.clip(1.0 / max(over, 1e-9), *ends))
    return length, float(np.sqrt(volume / (np.pi * length)))


def _coefficients(subject: Subject, length: float, radius: float) -> tuple[FloatArray, FloatArray]:
    """C_d and C_f (3,) of each axis: a u + b u^3 fitted to the damping up to the speed reached."""
    vector, ahead = subject.packed.vector, subject.ahead[:, -1]
    density = float(read(vector, "density"))
    side, end = 2.0 * np.pi * radius * length, np.pi * radius**2
    front = np.array([end, 2.0 * radius * length, 2.0 * radius * length])
    along = np.array([side, 2.0 * end + side / 2.0, 2.0 * end + side / 2.0])
    form, friction = np.zeros(_AXES), np.zeros(_AXES)
    for k in range(_AXES):
        first = float(read(vector, "linear_damping")[k, k])
        second = float(read(vector, "quadratic_damping")[k])
        push = 0.5 * float(np.abs(subject.matrix[k]) @ ahead)
        reached = 2.0 * push / max(np.sqrt(first**2 + 4.0 * second * push) + first, 1e-9)
        u = np.linspace(0.02, 1.0, 50) * max(min(reached, 5.0), 0.1)
        found = np.linalg.lstsq(np.stack([u, u**3], axis=1), first * u + second * u**2, rcond=None)[
            0
        ]
        friction[k] = max(found[0], 0.0) / (density * along[k])
        form[k] = max(found[1], 0.0) / (0.5 * density * front[k])
    return form, friction


def _thruster(robot: ET.Element, subject: Subject, k: int, name: str) -> None:
    vector, vehicle = subject.packed.vector, subject.vehicle
    at, to = (read(vector, f"thruster_{what}")[k] for what in ("position", "direction"))
    code = subject.share * subject.packed.code_limits[k, 1]
    part = ET.SubElement(robot, "actuator", name=name, type="thruster")
    ET.SubElement(part, "specs", max_setpoint=f"{code[-1]:.9g}", inverted_setpoint="false")
    diameter = vehicle.propellers[vehicle.thrusters[k].propeller].diameter_m
    propeller = ET.SubElement(part, "propeller", diameter=f"{diameter:.9g}", right="true")
    ET.SubElement(propeller, "mesh", filename="propeller.obj", scale="1.0")
    ET.SubElement(propeller, "material", name="Hull")
    ET.SubElement(propeller, "look", name="Yellow")
    lag = float(read(vector, "lag")[k])
    rotor = ET.SubElement(part, "rotor_dynamics", type="first_order" if lag else "zero_order")
    if lag:
        ET.SubElement(rotor, "time_constant", value=f"{lag:.9g}")
    model = ET.SubElement(part, "thrust_model", type="linear_interpolation")
    knots, thrust = _table(subject, k)
    ET.SubElement(model, "input", value=numbers(knots))
    ET.SubElement(model, "output", value=numbers(thrust))
    yaw, pitch = np.arctan2(to[1], to[0]), -np.arcsin(np.clip(to[2], -1.0, 1.0))
    ET.SubElement(part, "origin", xyz=numbers(at), rpy=f"0 {pitch:.9g} {yaw:.9g}")
    ET.SubElement(part, "link", name="Hull")


def _table(subject: Subject, k: int) -> tuple[FloatArray, FloatArray]:
    """Codes of both signs and the thrust at rest of thruster k."""
    code = subject.share * subject.packed.code_limits[k, 1]
    thrust = np.concatenate([-subject.astern[k][:0:-1], subject.ahead[k]])
    return np.concatenate([-code[:0:-1], code]), thrust


def _faces(length: float, radius: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Centres (m, 3), outward normals (m, 3) and areas (m,) of the cylinder's faces."""
    angle = (np.arange(_SLICES) + 0.5) * 2.0 * np.pi / _SLICES
    out = np.stack([np.zeros(_SLICES), np.cos(angle), np.sin(angle)], axis=1)
    ahead = np.tile([1.0, 0.0, 0.0], (_SLICES, 1))
    rim, half = 2.0 / 3.0 * radius * out, 0.5 * length * ahead
    centre = np.concatenate([radius * out, rim + half, rim - half])
    normal = np.concatenate([out, ahead, -ahead])
    side, end = 2.0 * np.pi * radius * length, np.pi * radius**2
    area = np.repeat([side, end, end], _SLICES) / _SLICES
    return centre, normal, area


def _motion(
    subject: Subject, length: float, radius: float, form: FloatArray, friction: FloatArray
) -> Callable[[FloatArray, int, float], FloatArray]:
    """Return what flies codes (n,) for a count of steps of dt: nu (count, 6) of the origin."""
    vector, gravity = subject.packed.vector, subject.packed.context.gravity_mps2
    density, mass = float(read(vector, "density")), float(read(vector, "mass"))
    r_cg, r_cb = read(vector, "centre_of_mass"), read(vector, "centre_of_buoyancy")
    centre, normal, area = _faces(length, radius)
    centre = centre + r_cb - r_cg
    disc = density * np.pi * radius**2
    total = mass + (disc + 2.0 * disc * length) / 3.0
    added = density * np.pi * length**2 * radius**3 / 12.0
    moments = _moments(vector) + np.array([0.0, added, added])
    matrix, current = subject.matrix, read(vector, "current")
    lag = read(vector, "lag")[: len(subject.ahead)]
    tables = [_table(subject, k) for k in range(len(subject.ahead))]
    weight, buoyancy = mass * gravity, float(read(vector, "buoyancy"))

    def weighed(force: FloatArray, each: FloatArray) -> FloatArray:
        size = float(np.linalg.norm(force))
        return force * float(np.abs(force) @ each) / size if size > 0.0 else force

    def rates(state: FloatArray, wrench: FloatArray) -> FloatArray:
        v, turn, attitude = state[:3], state[3:6], state[6:].reshape(3, 3)
        past = attitude.T @ current - (v + np.cross(turn, centre))
        across = np.sum(past * normal, axis=1)
        into = np.where(across < 0.0, -across, 0.0) * area * np.linalg.norm(past, axis=1)
        drag = past * into[:, None]
        skin = (past - across[:, None] * normal) * area[:, None]
        down = attitude[2]
        force = wrench[:3] + (weight - buoyancy) * down
        moment = wrench[3:] - np.cross(r_cg, wrench[:3]) - np.cross(r_cb - r_cg, buoyancy * down)
        for each, share, coefficients in ((drag, 0.5, form), (skin, 1.0, friction)):
            force = force + share * density * weighed(each.sum(axis=0), coefficients)
            moment = moment + share * density * weighed(
                np.cross(centre, each).sum(axis=0), coefficients
            )
        spin = attitude @ np.cross(np.eye(3), turn)
        return np.concatenate(
            [
                force / total - np.cross(turn, v),
                (moment - np.cross(turn, moments * turn)) / moments,
                spin.ravel(),
            ]
        )

    def fly(codes: FloatArray, count: int, dt_s: float) -> FloatArray:
        state = np.concatenate([np.zeros(6), np.eye(3).ravel()])
        found = np.zeros((count, 6))
        left = np.where(lag > 0.0, np.exp(-dt_s / np.maximum(lag, 1e-9)), 0.0)
        acts = np.zeros(len(codes))
        for k in range(count):
            found[k, :3] = state[:3] - np.cross(state[3:6], r_cg)
            found[k, 3:] = state[3:6]
            middle = codes + (acts - codes) * np.sqrt(left)
            acts = codes + (acts - codes) * left
            thrust = [np.interp(c, *table) for c, table in zip(middle, tables, strict=True)]
            wrench = matrix @ np.array(thrust)
            k1 = rates(state, wrench)
            k2 = rates(state + 0.5 * dt_s * k1, wrench)
            k3 = rates(state + 0.5 * dt_s * k2, wrench)
            state = state + dt_s / 6.0 * (k1 + 2 * k2 + 2 * k3 + rates(state + dt_s * k3, wrench))
        return found

    return fly
