r"""Make the model follow the measured motion, and keep the force that this takes.

A vehicle with a strong fault turns quite otherwise than its nominal model within seconds, and what
is linear around the nominal motion says little of it. So the model is led along the measured motion
by a force that pulls it there,

.. math:: F = M (2 \omega e_v + \omega^2 e_x), \qquad e_v = \nu_{meas} - \nu, \quad e_x = \int e_v

and all derivatives are taken along that motion. The force is what the model lacks; the linear model
asks which effects would supply it. It carries the noise of the sensors, to which the derivatives
are not sensitive: no residual is taken from it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.windows import Window
from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.records.run_table import RunTable
from pipeline.simulate.kernel import RK4, STATE
from pipeline.simulate.kernel_follow import follow_window
from pipeline.simulate.kernel_hull import mass_matrix
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray, IntArray

#: Bandwidth of the pull: turning is measured by gyros, going by a DVL that is slower. [rad/s]
TURN_BANDWIDTH, GO_BANDWIDTH = 5.0, 2.5
#: Pull towards the measured position. [1/s^2]
_PLACE = 0.5
#: Angle, way or place beyond which the pull grows no further. [rad, m, m/s^2]
_MOST_OFF = 0.5
#: A position less sure than this leads nowhere. [m]
_SURE_M = 0.05
#: Steps for which the pull is held.
_HELD = 4
#: How often the motion is followed: each time the force of the time before is known in advance.
_PASSES = 4
#: By how much the pull lags behind what caused it. [s]
_LATE_S = 0.12


def follow(
    packed: PackedVehicle,
    runs: Sequence[RunTable],
    windows: Sequence[Window],
    channels: Sequence[ChannelNoise],
    vector: FloatArray | None = None,
) -> tuple[list[Window], list[FloatArray]]:
    """Windows that start on the followed motion, and the pull over each, (steps, 6) [N, N m].

    Parameters
    ----------
    packed : PackedVehicle
        The nominal vehicle.
    runs : sequence of RunTable
        What was measured.
    windows : sequence of Window
        Cut from them.
    channels : sequence of ChannelNoise
        For the place of the DVL.
    vector : ndarray, optional
        Parameter vector of the model that follows; the nominal one otherwise.
    """
    at = packed.vector if vector is None else vector
    pulls = [np.zeros((len(window.command), 6)) for window in windows]
    started = list(windows)
    for _ in range(_PASSES):
        started, pulls = _pass(packed, at, runs, windows, channels, pulls)
    return started, pulls


def _pass(  # noqa: PLR0917 - one caller
    packed: PackedVehicle,
    vector: FloatArray,
    runs: Sequence[RunTable],
    windows: Sequence[Window],
    channels: Sequence[ChannelNoise],
    known: Sequence[FloatArray],
) -> tuple[list[Window], list[FloatArray]]:
    """Follow once, with a force that is known in advance."""
    sure = any(c.quantity == "position" and c.white <= _SURE_M for c in channels)
    place = next((np.array(c.place_m) for c in channels if c.quantity == "velocity"), np.zeros(3))
    started, pulls = [], []
    state: FloatArray | None = None
    last: tuple[int, float] | None = None
    for window, ahead in zip(windows, known, strict=True):
        # goes on where the window before ended, so that the drives are where they were
        joins = last is not None and last == (window.run, round(window.begin_s, 6))
        begin = window.start
        if joins and state is not None:
            # but where it was measured to be: a velocity that is a little off would lead it away
            begin = state.copy()
            if "depth" in window.readings:
                begin[2] = window.start[2]
            if "position" in window.readings and not sure:
                begin[:2] = window.start[:2]
        state, pull = _follow_window(
            packed, vector, runs[window.run], window, begin, place, ahead, sure
        )
        if state is None:
            begin = window.start
            state, pull = None, np.zeros((len(window.command), 6))
        started.append(replace(window, start=begin))
        pulls.append(pull)
        last = (window.run, round(window.begin_s + window.duration_s, 6))
    return started, pulls


def _follow_window(  # noqa: PLR0917 - one caller
    packed: PackedVehicle,
    vector: FloatArray,
    table: RunTable,
    window: Window,
    begin: FloatArray,
    place: FloatArray,
    ahead: FloatArray,
    sure: bool,
) -> tuple[FloatArray | None, FloatArray]:
    """State at the end and the pull; None where the simulation ran away."""
    matrix = np.empty((6, 6))
    mass_matrix(vector, 1.0, matrix)
    steps = len(window.command)
    period = float(np.median(np.diff(table.time_s)))
    index = round(window.begin_s / period) + round(window.step_s / period) * np.arange(steps + 1)
    index = np.minimum(index, table.time_s.size - 1)
    # what the DVL shows is taken as this model has it: late, scaled, turned, from another place
    late = round(float(read(vector, "dvl_delay")) / period)
    told = np.clip(index + late, 0, table.time_s.size - 1)
    velocity, velocity_known = _channel(table, "velocity", told, 3)
    error = Rotation.from_euler("ZYX", read(vector, "dvl_rotation")[::-1])
    velocity = error.apply(velocity / max(float(read(vector, "dvl_scale")), 0.1))
    late = round(_LATE_S / window.step_s)
    pull = ahead[np.minimum(np.arange(steps) + late, steps - 1)]
    command = np.zeros((steps, MOST_THRUSTERS))
    command[:, : len(packed.thruster_names)] = window.command
    states = np.empty((steps + 1, STATE))
    sound = follow_window(
        vector,
        begin,
        command,
        float(window.step_s),
        _HELD,
        RK4,
        matrix,
        np.array([TURN_BANDWIDTH, GO_BANDWIDTH, _PLACE if sure else 0.0, _MOST_OFF]),
        place + read(vector, "dvl_lever_arm"),
        *_channel(table, "angular_velocity", index, 3),
        velocity,
        velocity_known,
        *_channel(table, "attitude", index, 4),
        *_channel(table, "position", index, 3),
        packed.strips,
        packed.thrust_tables,
        packed.screws,
        packed.torque_tables,
        packed.steps,
        states,
        pull,
    )
    return (states[-1] if sound else None), pull


def _channel(
    table: RunTable, quantity: str, index: IntArray, width: int
) -> tuple[FloatArray, BoolArray]:
    if quantity not in table.values:
        return np.zeros((index.size, width)), np.zeros(index.size, bool)
    values = table.values[quantity][index]
    known = table.valid[quantity][index] & np.isfinite(values).all(axis=1)
    return np.where(known[:, None], values, 0.0), known
