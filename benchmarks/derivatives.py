"""Exact derivatives of a run by complex steps through the NumPy peer, to judge differences by."""

from collections.abc import Sequence

import numpy as np

from benchmarks.peer_numpy import simulate_numpy
from pipeline.physics.parameters import offset, slot
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray

#: No difference is taken, so the step can be as small as a float: the error is h^2, nothing.
IMAGINARY_STEP = 1e-30

#: What a pool fit moves: body, added mass, damping, surroundings, thrusters.
FORTY_PARAMETERS: tuple[tuple[str, int], ...] = (
    ("mass", 0),
    ("buoyancy", 0),
    *(("centre_of_mass", k) for k in range(3)),
    *(("added_mass", 7 * k) for k in range(6)),
    ("added_mass", 4),
    ("inertia", 4),
    *(("linear_damping", 7 * k) for k in range(6)),
    *(("quadratic_damping", k) for k in range(6)),
    ("crossflow_fraction", 0),
    ("heave_lift_slope", 0),
    ("pitch_lift_slope", 0),
    ("current", 0),
    ("current", 1),
    ("wall_strength", 0),
    ("tether_drag_area", 0),
    ("tether_pull", 0),
    ("thrust_gain", 0),
    ("thrust_gain", 3),
    ("inflow_fraction", 1),
    ("dead_zone", 2),
    ("lag", 0),
    ("misalignment_azimuth", 1),
    ("misalignment_elevation", 2),
)


def complex_step_jacobian(
    packed: PackedVehicle,
    commands: FloatArray,
    parameters: Sequence[tuple[str, int]],
    *,
    dt_s: float,
    start: FloatArray,
    method: str,
) -> FloatArray:
    """Differentiate the body's states, (m + 1, 13, parameters): Im y(theta + i h) / h.

    Off-diagonal entries of the added mass and the inertia are moved with their mirror images.
    """
    columns = []
    for name, index in parameters:
        vector = packed.vector.astype(complex)
        places = {index}
        if name in {"added_mass", "inertia"}:
            size = slot(name).shape[0]
            row, column = divmod(index, size)
            places.add(size * column + row)
        for place in places:
            vector[offset(name) + place] += 1j * IMAGINARY_STEP
        result = simulate_numpy(
            packed, commands, dt_s=dt_s, start=start, vector=vector, method=method
        )
        columns.append(result.states[:, :13].imag / IMAGINARY_STEP)
    return np.stack(columns, axis=-1)


def relative_errors(found: FloatArray, exact: FloatArray, scales: FloatArray) -> FloatArray:
    """Errors (channels, parameters): largest over time, over the derivative's largest.

    A derivative of less than a thousandth of the channel's strongest (each times the parameter's
    scale) is measured by that thousandth: it moves nothing.
    """
    error = np.abs(found - exact).max(axis=0)
    size = np.abs(exact).max(axis=0) * scales
    strongest = size.max(axis=1, keepdims=True)
    return np.asarray(error * scales / np.maximum(size, 1e-3 * strongest))
