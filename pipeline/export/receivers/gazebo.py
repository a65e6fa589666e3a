"""Gazebo: a world in SDF with the vehicle, for the systems Buoyancy, Hydrodynamics and Thruster.

Body axes of a model are x forward, y to port, z up, the world east, north, up: vectors of SNAME
become (x, -y, -z). The added mass stands in ``fluid_added_mass`` of the link, where it is positive
and solved with the inertia (DART alone does that); the older keys of Hydrodynamics (xDotU ...) are
left at 0, so that it counts once. Damping of Hydrodynamics is negative: (xU + xUabsU |u|) u.
A thruster takes newtons, which it gives at any speed (gz-sim, Hydrodynamics.hh and Thruster.hh).
"""

import xml.etree.ElementTree as ET

import numpy as np

from pipeline.export.receivers.exported import Exported, Subject, numbers
from pipeline.physics.parameters import read, write
from pipeline.types import FloatArray

_FLIP = np.array([1.0, -1.0, -1.0])
_BOTH = np.concatenate([_FLIP, _FLIP])
_AXES = ("x", "y", "z", "p", "q", "r")
_DAMPING = (("x", "U"), ("y", "V"), ("z", "W"), ("k", "P"), ("m", "Q"), ("n", "R"))


def gazebo(subject: Subject) -> Exported:
    """Return the world; what its equations make of the vehicle is in `vector`."""
    packed = subject.packed
    root = ET.Element("sdf", version="1.10")
    world = ET.SubElement(root, "world", name=packed.name)
    _sub(world, "gravity", f"0 0 {-packed.context.gravity_mps2:.6g}")
    for system in ("physics", "user-commands", "scene-broadcaster"):
        name = {"physics": "Physics", "user-commands": "UserCommands"}.get(
            system, "SceneBroadcaster"
        )
        ET.SubElement(
            world, "plugin", filename=f"gz-sim-{system}-system", name=f"gz::sim::systems::{name}"
        )
    water = _plugin(world, "buoyancy", "Buoyancy")
    _sub(water, "uniform_fluid_density", float(read(packed.vector, "density")))
    model = ET.SubElement(world, "model", name=packed.name)
    _link(model, packed.vector, packed.context.gravity_mps2)
    _hydrodynamics(model, packed.vector)
    for k, name in enumerate(packed.thruster_names):
        _thruster(model, subject, k, name)
    ET.indent(root)
    body = ET.tostring(root, encoding="unicode") + "\n"
    return Exported(
        file=f"{packed.name}.sdf",
        text=lambda head: f'<?xml version="1.0"?>\n<!--\n{head}-->\n{body}',
        # two hyphens would end the comment
        comment=lambda line: "  " + line.replace("--", "- -"),
        lost=(
            "codes, dead zones, lag, and the fall of thrust with speed: a thruster takes newtons",
            "lift and the cross-flow of strips; walls, tether, supply voltage",
            "couplings of the damping, which acts at the centre of mass",
            "the added mass, where the physics engine is not DART",
            "the collision box has the displaced volume, not the shape of the hull",
        ),
        vector=_published(packed.vector),
    )


def _published(vector: FloatArray) -> FloatArray:
    """Parameter vector of the equations of the exported model."""
    found = vector.copy()
    for slot in (
        *("inflow_fraction", "lag", "rotor_inertia", "crossflow_fraction", "turnover_slope"),
        *("heave_lift_slope", "sway_lift_slope", "pitch_lift_slope", "yaw_lift_slope"),
        *("wall_count", "wall_strength", "tether_drag_area", "tether_pull"),
        *("supply_drop", "load_drop"),
    ):
        write(found, slot, 0.0)
    write(found, "linear_damping", np.diag(np.diag(read(vector, "linear_damping"))))
    write(found, "coriolis_fraction", 1.0)
    return found


def _link(model: ET.Element, vector: FloatArray, gravity: float) -> None:
    mass, density = float(read(vector, "mass")), float(read(vector, "density"))
    centre = read(vector, "centre_of_mass")
    own = np.asarray(read(vector, "inertia")) - mass * (
        centre @ centre * np.eye(3) - np.outer(centre, centre)
    )
    own = own * np.outer(_FLIP, _FLIP)
    added = np.asarray(read(vector, "added_mass")) * np.outer(_BOTH, _BOTH)
    link = ET.SubElement(model, "link", name="base_link")
    inertial = ET.SubElement(link, "inertial")
    _sub(inertial, "pose", f"{numbers(centre * _FLIP)} 0 0 0")
    _sub(inertial, "mass", mass)
    inertia = ET.SubElement(inertial, "inertia")
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        _sub(inertia, f"i{'xyz'[i]}{'xyz'[j]}", float(own[i, j]))
    water = ET.SubElement(inertial, "fluid_added_mass")
    # about the centre of mass, where the link's inertia is
    shift = np.eye(6)
    x, y, z = centre * _FLIP
    shift[:3, 3:] = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    at_centre = shift.T @ added @ shift
    for i in range(6):
        for j in range(i, 6):
            _sub(water, _AXES[i] + _AXES[j], float(at_centre[i, j]))
    # a cube of the displaced volume about the centre of buoyancy
    edge = (float(read(vector, "buoyancy")) / (density * gravity)) ** (1.0 / 3.0)
    for kind in ("collision", "visual"):
        part = ET.SubElement(link, kind, name=f"hull_{kind}")
        _sub(part, "pose", f"{numbers(read(vector, 'centre_of_buoyancy') * _FLIP)} 0 0 0")
        box = ET.SubElement(ET.SubElement(part, "geometry"), "box")
        _sub(box, "size", numbers([edge] * 3))


def _hydrodynamics(model: ET.Element, vector: FloatArray) -> None:
    plugin = _plugin(model, "hydrodynamics", "Hydrodynamics")
    _sub(plugin, "link_name", "base_link")
    _sub(plugin, "water_density", float(read(vector, "density")))
    north, east, down = read(vector, "current").tolist()
    _sub(plugin, "default_current", numbers([east, north, -down]))
    linear = np.diag(read(vector, "linear_damping")).tolist()
    quadratic = read(vector, "quadratic_damping").tolist()
    for (axis, speed), first, second in zip(_DAMPING, linear, quadratic, strict=True):
        _sub(plugin, f"{axis}{speed}", -first)
        _sub(plugin, f"{axis}{speed}abs{speed}", -second)


def _thruster(model: ET.Element, subject: Subject, k: int, name: str) -> None:
    vector = subject.packed.vector
    at, to = (read(vector, f"thruster_{what}")[k] * _FLIP for what in ("position", "direction"))
    vehicle = subject.vehicle
    diameter = vehicle.propellers[vehicle.thrusters[k].propeller].diameter_m
    part = ET.SubElement(model, "link", name=f"{name}_propeller")
    # x of the propeller along its thrust
    yaw, pitch = np.arctan2(to[1], to[0]), -np.arcsin(np.clip(to[2], -1.0, 1.0))
    _sub(part, "pose", f"{numbers(at)} 0 {pitch:.9g} {yaw:.9g}")
    inertial = ET.SubElement(part, "inertial")
    _sub(inertial, "mass", 1e-3)
    inertia = ET.SubElement(inertial, "inertia")
    for axis in ("ixx", "iyy", "izz"):
        _sub(inertia, axis, 1e-6)
    joint = ET.SubElement(model, "joint", name=f"{name}_joint", type="revolute")
    _sub(joint, "parent", "base_link")
    _sub(joint, "child", f"{name}_propeller")
    _sub(ET.SubElement(joint, "axis"), "xyz", "1 0 0")
    plugin = _plugin(model, "thruster", "Thruster")
    _sub(plugin, "namespace", subject.packed.name)
    _sub(plugin, "joint_name", f"{name}_joint")
    # of the spin that is shown alone: the command is the thrust
    _sub(plugin, "thrust_coefficient", 0.004422)
    _sub(plugin, "fluid_density", float(read(vector, "density")))
    _sub(plugin, "propeller_diameter", diameter)
    _sub(plugin, "velocity_control", "true")
    _sub(plugin, "max_thrust_cmd", float(subject.ahead[k, -1]))
    _sub(plugin, "min_thrust_cmd", -float(subject.astern[k, -1]))


def _plugin(parent: ET.Element, file: str, name: str) -> ET.Element:
    return ET.SubElement(
        parent, "plugin", filename=f"gz-sim-{file}-system", name=f"gz::sim::systems::{name}"
    )


def _sub(parent: ET.Element, tag: str, value: float | str) -> None:
    ET.SubElement(parent, tag).text = value if isinstance(value, str) else f"{value + 0.0:.9g}"
