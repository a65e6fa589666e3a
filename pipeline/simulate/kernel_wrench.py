"""Compiled kernel: the wrench of the thrusters along a run whose motion is known."""

from typing import Any

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS
from pipeline.simulate.compiled import compiled
from pipeline.simulate.kernel_thrusters import add_thrust, thruster_levers

Array = Any


@compiled
def wrench_along(
    p: Array,
    actuators: Array,
    velocities: Array,
    thrust_tables: Array,
    screws: Array,
    steps: Array,
    thrusts: Array,
    wrenches: Array,
) -> None:
    """Fill thrusts (m, 12) and wrenches (m, 6) for actuator states (m, 12), velocities (m, 6).

    Velocities are relative to the water.
    """
    levers = np.zeros((MOST_THRUSTERS, 6))
    thruster_levers(p, levers)
    inflow, per_step = np.zeros(MOST_THRUSTERS), 1.0 / steps
    for k in range(actuators.shape[0]):
        for i in range(6):
            wrenches[k, i] = 0.0
        add_thrust(
            p,
            levers,
            actuators[k],
            velocities[k],
            thrust_tables,
            screws,
            per_step,
            thrusts[k],
            inflow,
            wrenches[k],
        )
