"""Force and moment along a measured run, by the vehicle's own model: thrusters, and the hull."""

import numpy as np

from pipeline.control.bounded_allocation import configuration
from pipeline.physics.parameters import MOST_THRUSTERS, read, write
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.kernel_alone import demand_along, settled_along, wrench_along
from pipeline.simulate.pack import PackedVehicle, shafts_turn
from pipeline.simulate.run import Method, run
from pipeline.types import FloatArray

#: Mass of the body that stands in for the vehicle while its thrusters alone are computed. [kg]
_IMMOVABLE_KG = 1e12
#: What acts on the hull only where the place of the vehicle is known.
_OF_THE_PLACE = ("current", "wall_count", "tether_drag_area", "tether_pull")


def actuator_states(
    packed: PackedVehicle,
    command: FloatArray,
    period_s: float,
    *,
    vector: FloatArray | None = None,
) -> FloatArray:
    """Effective codes, or shaft speeds, of the thrusters that commands (m, n) lead to, (m + 1, n).

    Each command is held for a period [s]; the states are those at its start, and at the end of all.
    The kernel itself is run, with a body too heavy to move. That is exact where a thruster follows
    its code by a lag; where the torque balance is solved in time the shafts turn as at rest.
    """
    fixed = (packed.vector if vector is None else vector).copy()
    write(fixed, "mass", _IMMOVABLE_KG)
    write(fixed, "inertia", _IMMOVABLE_KG * np.eye(3))
    write(fixed, "centre_of_mass", 0.0)
    write(fixed, "centre_of_buoyancy", 0.0)
    write(fixed, "current", 0.0)
    # lags are taken exactly by any method
    method: Method = "rk4" if shafts_turn(fixed) else "semi_implicit"
    return run(packed, command, dt_s=period_s, vector=fixed, method=method).actuator


def thruster_wrench(
    packed: PackedVehicle,
    actuator: FloatArray,
    nu_relative: FloatArray,
    *,
    vector: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Wrench (m, 6) of the thrusters about the body origin [N, N m], thrust (m, n) of each [N].

    For `actuator` (m, n), effective codes or shaft speeds, at `nu_relative` (m, 6), the velocity
    relative to the water in body axes [m/s, rad/s].
    """
    count = len(packed.thruster_names)
    padded = np.zeros((len(actuator), STATE - BODY))
    padded[:, :count] = actuator
    thrusts = np.zeros((len(actuator), MOST_THRUSTERS))
    wrenches = np.zeros((len(actuator), 6))
    wrench_along(
        packed.vector if vector is None else vector,
        padded,
        np.ascontiguousarray(nu_relative, float),
        packed.thrust_tables,
        packed.screws,
        packed.steps,
        thrusts,
        wrenches,
    )
    return wrenches, thrusts[:, :count]


def settled_thrust(packed: PackedVehicle, codes: FloatArray, inflow_mps: FloatArray) -> FloatArray:
    """Thrust (k, n) of codes (k, n) without lag, the water at a speed along each thruster. [N].

    `inflow_mps` (k, n), or what broadcasts to it, is the speed past the hull; what each thruster
    has of its own (wake, gains, dead zone) is taken off here.
    """
    own = np.zeros((3, len(codes), MOST_THRUSTERS))
    own[0, :, : codes.shape[1]], own[1, :, : codes.shape[1]] = codes, inflow_mps
    settled_along(packed.vector, own[0], own[1], packed.thrust_tables, packed.steps, own[2])
    return np.asarray(own[2, :, : codes.shape[1]])


def inflow_speed(packed: PackedVehicle, nu: FloatArray) -> FloatArray:
    """Speed of the water along each thruster, (k, n), for velocities (k, 6) through the water."""
    # the velocity of a point along a direction is the wrench's transpose: d.(v + w x r)
    return np.asarray(nu @ levers(packed))


def levers(packed: PackedVehicle) -> FloatArray:
    """Force and moment on each axis of one newton of each thruster, (6, n). [1, m]."""
    count = len(packed.thruster_names)
    direction = read(packed.vector, "thruster_direction")[:count]
    place = read(packed.vector, "thruster_position")[:count]
    return configuration(place, direction)


def hull_wrench(packed: PackedVehicle, attitude: FloatArray, nu_relative: FloatArray) -> FloatArray:
    """Wrench (m, 6) of Coriolis terms, damping and restoring on the hull [N, N m].

    Away from walls and without a tether: with the thrusters' wrench tau and the mass matrix M the
    model is M nu_r' = wrench + tau. `attitude` (m, 4) are unit quaternions w x y z, body to NED,
    `nu_relative` (m, 6) the velocity relative to the water, body axes [m/s, rad/s].
    """
    vector, count = packed.vector.copy(), len(nu_relative)
    for name in _OF_THE_PLACE:
        write(vector, name, 0.0)
    state = np.concatenate([np.zeros((count, 3)), attitude, nu_relative], axis=1)
    demand = np.zeros((count, 6))
    demand_along(vector, state, np.zeros((count, 6)), packed.strips, demand)
    return -demand
