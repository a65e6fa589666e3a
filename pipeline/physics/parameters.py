"""One vector holds every number of the vehicle's model: the layout, and how to read and write it.

The compiled kernel takes the vector; a fit perturbs it; an effect of the library moves a few of its
entries off their neutral values. Nothing else tells the kernel what to compute, so a trajectory is
a function of (vector, commands, initial state) alone.

Each slot has a name, a shape and a unit. Thruster slots have one entry a thruster, up to
`MOST_THRUSTERS`; entries beyond the vehicle's thrusters keep their neutral values.
"""

from dataclasses import dataclass
from math import prod

import numpy as np

from pipeline.types import FloatArray

MOST_THRUSTERS = 12
MOST_WALLS = 5


@dataclass(frozen=True)
class Slot:
    """A named part of the vector; `neutral` fills it where the vehicle says nothing."""

    name: str
    shape: tuple[int, ...]
    unit: str
    neutral: float
    meaning: str

    @property
    def size(self) -> int:
        """Number of entries."""
        return prod(self.shape)


_EACH = (MOST_THRUSTERS,)

SLOTS: tuple[Slot, ...] = (
    # rigid body; payloads that are attached are already in these
    Slot("mass", (), "kg", 0.0, "dry mass with attached payloads"),
    Slot("centre_of_mass", (3,), "m", 0.0, "r_g, body axes"),
    Slot("inertia", (3, 3), "kg m^2", 0.0, "about the body origin"),
    Slot("weight", (), "N", 0.0, "W"),
    Slot("buoyancy", (), "N", 0.0, "B"),
    Slot("centre_of_buoyancy", (3,), "m", 0.0, "r_b, body axes"),
    Slot("added_mass", (6, 6), "kg, kg m, kg m^2", 0.0, "M_A, symmetric, positive"),
    Slot("coriolis_fraction", (), "1", 1.0, "share of C(nu) nu that is computed"),
    # hull forces
    Slot("linear_damping", (6, 6), "N s/m, N s, N m s", 0.0, "D: force is -D nu_r"),
    Slot("quadratic_damping", (6,), "N s^2/m^2, N m s^2", 0.0, "force is -d |nu_r| nu_r, by axis"),
    Slot("crossflow_fraction", (), "1", 0.0, "share of the coupling of sway-yaw and heave-pitch"),
    Slot("heave_lift_slope", (), "N s^2/m^2", 0.0, "Z = -k |u| w"),
    Slot("sway_lift_slope", (), "N s^2/m^2", 0.0, "Y = -k |u| v"),
    Slot("pitch_lift_slope", (), "N s^2/m", 0.0, "M = k |u| w, net of the Munk moment of C"),
    Slot("yaw_lift_slope", (), "N s^2/m", 0.0, "N = k |u| v, net of the Munk moment of C"),
    Slot("turnover_slope", (2,), "kg", 0.0, "part of both that goes with u: k (u - |u|) on top"),
    # surroundings
    Slot("density", (), "kg/m^3", 1000.0, "of the water"),
    Slot("current", (3,), "m/s", 0.0, "velocity of the water, NED"),
    Slot("wall_strength", (), "1", 0.0, "c in 1 + c (R / distance)^3 on added mass and damping"),
    Slot("wall_radius", (), "m", 0.0, "R, half the vehicle's smaller width"),
    Slot("wall_count", (), "1", 0.0, "walls in use"),
    Slot("wall_point", (MOST_WALLS, 3), "m", 0.0, "a point of each wall, NED"),
    Slot("wall_normal", (MOST_WALLS, 3), "1", 0.0, "unit normal into the water, NED"),
    Slot("tether_point", (3,), "m", 0.0, "where the tether pulls, body axes"),
    Slot("tether_drag_area", (), "m^2", 0.0, "C_d A of the towed tether, lumped at its point"),
    Slot("tether_pull", (), "N", 0.0, "constant pull towards the anchor"),
    Slot("tether_anchor", (3,), "m", 0.0, "upper end of the tether, NED"),
    # thrusters
    Slot("thruster_count", (), "1", 0.0, "thrusters in use"),
    Slot("thruster_position", (MOST_THRUSTERS, 3), "m", 0.0, "body axes"),
    Slot("thruster_direction", (MOST_THRUSTERS, 3), "1", 0.0, "unit vector of positive thrust"),
    Slot("thruster_type", _EACH, "1", 0.0, "index of its characteristic"),
    Slot("thrust_gain", _EACH, "1", 1.0, "thrust over that of the characteristic, both signs"),
    Slot("reverse_gain", _EACH, "1", 1.0, "extra factor on negative thrust"),
    Slot("inflow_fraction", _EACH, "1", 1.0, "share of the inflow that the thruster feels"),
    Slot("opposed_share", (), "1", 0.0, "rise of thrust against the motion over its fall along it"),
    Slot("dead_zone", _EACH, "code", 0.0, "codes lost on top of the characteristic's dead zone"),
    Slot("code_max", _EACH, "code", 127.0, "largest code"),
    Slot("code_min", _EACH, "code", -32767.0, "most negative code; -code_max where that is nearer"),
    Slot("drive_dead", _EACH, "code", 0.0, "dead zone of the characteristic itself"),
    Slot("lag", _EACH, "s", 0.0, "time constant of the first-order lag of code or shaft speed"),
    Slot(
        "lag_dead_share",
        (),
        "1",
        0.0,
        "share of the drives' dead zones that comes before lag and supply",
    ),
    Slot("lag_power", (), "1", 1.0, "what lags: this power of the share of the code beyond it"),
    Slot("lag_fall", (), "1", 0.0, "power by which the lag falls with the share of the code"),
    Slot("rotor_inertia", _EACH, "kg m^2", 0.0, "of shaft and propeller; 0: static thrust"),
    Slot("supply_drop", (), "1", 0.0, "share of the supply voltage that is missing at no load"),
    Slot("load_drop", (), "1", 0.0, "further share that is missing with every thruster at full"),
    Slot("misalignment_azimuth", _EACH, "rad", 0.0, "level tilt, across the stated direction"),
    Slot("misalignment_elevation", _EACH, "rad", 0.0, "tilt across the level one, up positive"),
    # measurement; read by the sensors, not by the kernel
    Slot("dvl_scale", (), "1", 1.0, "measured over true speed"),
    Slot("dvl_rotation", (3,), "rad", 0.0, "roll, pitch, yaw of the DVL against its stated mount"),
    Slot("dvl_delay", (), "s", 0.0, "age of a reading beyond the stated one"),
    Slot("dvl_lever_arm", (3,), "m", 0.0, "true minus stated place of the DVL, body axes"),
)

_BY_NAME = {slot.name: slot for slot in SLOTS}
_OFFSETS: dict[str, int] = {}
_end = 0
for _slot in SLOTS:
    _OFFSETS[_slot.name] = _end
    _end += _slot.size
#: Length of the vector.
LENGTH = _end


def offset(name: str) -> int:
    """Index of the first entry of a slot.

    >>> offset("mass")
    0
    """
    return _OFFSETS[name]


def slot(name: str) -> Slot:
    """Look a slot up by its name.

    >>> slot("current").unit
    'm/s'
    """
    return _BY_NAME[name]


def neutral_vector() -> FloatArray:
    """Return a new vector with every slot at its neutral value."""
    vector = np.empty(LENGTH)
    for entry in SLOTS:
        start = _OFFSETS[entry.name]
        vector[start : start + entry.size] = entry.neutral
    return vector


def read(vector: FloatArray, name: str) -> FloatArray:
    """View of a slot in its shape; writing to it writes to the vector.

    >>> vector = neutral_vector()
    >>> read(vector, "current")[:] = [0.3, 0.0, 0.0]
    >>> vector[offset("current")]
    np.float64(0.3)
    """
    entry = _BY_NAME[name]
    start = _OFFSETS[name]
    return vector[start : start + entry.size].reshape(entry.shape)


def write(vector: FloatArray, name: str, value: float | FloatArray) -> None:
    """Set a slot in place; the value is broadcast to its shape."""
    read(vector, name)[...] = value
