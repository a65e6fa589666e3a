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
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from pipeline.diagnose.linear.workers import Workers
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.position_speed import sure_position, velocity_of_position
from pipeline.identify.windows import Window
from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.records.run_table import RunTable
from pipeline.simulate.kernel import RK4, STATE
from pipeline.simulate.kernel_follow import follow_window
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.simulate.pack_hull import vector_under
from pipeline.types import BoolArray, FloatArray, IntArray

#: Bandwidth of the pull: turning is measured by gyros, going by a DVL that is slower. [rad/s]
TURN_BANDWIDTH, GO_BANDWIDTH = 5.0, 2.5
#: Pull towards the measured position. [1/s^2]
_PLACE = 0.5
#: Angle, way or place beyond which the pull grows no further. [rad, m, m/s^2]
_MOST_OFF = 0.5
#: Steps for which the pull is held.
_HELD = 4
#: How often the motion is followed: each time the force of the time before is known in advance.
#: Where it is known of a model nearby, that is less often.
_PASSES, _PASSES_NEARBY = 4, 2
#: By how much the pull lags behind what caused it. [s]
_LATE_S = 0.12
#: Over how long the force that is known in advance is averaged. Learning from repetition amplifies
#: the noise of the sensors without such a filter, a little more each time (Bristow, Tharayil and
#: Alleyne, A survey of iterative learning control, 2006); with it the passes converge. [s]
_SMOOTH_S = 0.2

#: Values (steps + 1, k) of a channel and where they are known, of four channels.
_Readings = tuple[
    FloatArray, BoolArray, FloatArray, BoolArray, FloatArray, BoolArray, FloatArray, BoolArray
]


@dataclass(frozen=True)
class _Measured:
    """What a window was measured to do, at its steps, as the kernel takes it."""

    window: Window
    readings: _Readings
    """Angular velocity, velocity, attitude and position, each with where it is known."""
    command: FloatArray
    joins: bool
    """Goes on where the window before it ended."""


@dataclass(frozen=True)
class _Leader:
    """A model at a parameter vector, and what is the same in all windows."""

    packed: PackedVehicle
    vector: FloatArray
    mass: FloatArray
    place: FloatArray
    sure: bool
    """The position is sure enough to lead."""


def follow(  # noqa: PLR0917 - what is followed, then what follows
    packed: PackedVehicle,
    runs: Sequence[RunTable],
    windows: Sequence[Window],
    channels: Sequence[ChannelNoise],
    vector: FloatArray | None = None,
    nearby: Sequence[FloatArray] | None = None,
    workers: Workers | None = None,
) -> tuple[list[Window], list[FloatArray]]:
    """Windows that start on the followed motion, and the pull over each, (steps, 6) [N, N m].

    Parameters
    ----------
    packed : PackedVehicle
        The nominal vehicle.
    runs : sequence of RunTable
        What was measured.
    windows : sequence of Window
        Cut from them, run by run.
    channels : sequence of ChannelNoise
        For the place of the DVL.
    vector : ndarray, optional
        Parameter vector of the model that follows; the nominal one otherwise.
    nearby : sequence of ndarray, optional
        The pulls of another model on the same windows: from there it is not far.
    workers : Workers, optional
        Lead runs side by side; one after another otherwise.
    """
    at = packed.vector if vector is None else vector
    place = next((np.array(c.place_m) for c in channels if c.quantity == "velocity"), np.zeros(3))
    sure = sure_position(channels) is not None
    leader = _Leader(packed, at, mass_of(at), place + read(at, "dvl_lever_arm"), sure)
    begun = nearby or [np.zeros((len(window.command), 6)) for window in windows]
    pulls = list(begun)
    places: dict[int, list[int]] = {}
    for number, window in enumerate(windows):
        places.setdefault(window.run, []).append(number)

    def led(own: Sequence[int]) -> tuple[list[Window], list[FloatArray]]:
        table = runs[windows[own[0]].run]
        going = velocity_of_position(table, channels)
        measured = _measured(leader, table, [windows[k] for k in own], going)
        known = [pulls[k] for k in own]
        for _ in range(_PASSES if nearby is None else _PASSES_NEARBY):
            started, known = _pass(leader, measured, known)
        return started, known

    started = list(windows)
    found = (workers or Workers(1)).each([partial(led, own) for own in places.values()])
    for own, (new, forces) in zip(places.values(), found, strict=True):
        for number, window, force in zip(own, new, forces, strict=True):
            started[number], pulls[number] = window, force
    return started, pulls


def _measured(
    leader: _Leader,
    table: RunTable,
    windows: Sequence[Window],
    going: tuple[FloatArray, BoolArray] | None,
) -> list[_Measured]:
    """Take what was measured at the steps of the windows of one run.

    Where no velocity was, `going`, which the position shows, stands for it.
    """
    vector = leader.vector
    period = float(np.median(np.diff(table.time_s)))
    # what the DVL shows is taken as this model has it: late, scaled, turned, from another place
    late = round(float(read(vector, "dvl_delay")) / period)
    error = Rotation.from_euler("ZYX", read(vector, "dvl_rotation")[::-1])
    scale = max(float(read(vector, "dvl_scale")), 0.1)
    found = []
    ended: float | None = None
    for window in windows:
        steps = len(window.command)
        index = round(window.begin_s / period) + round(window.step_s / period) * np.arange(
            steps + 1
        )
        index = np.minimum(index, table.time_s.size - 1)
        told = np.clip(index + late, 0, table.time_s.size - 1)
        rate, rate_known = _channel(table, "angular_velocity", index, 3)
        velocity, velocity_known = _channel(table, "velocity", told, 3)
        velocity = error.apply(velocity / scale)
        if going is not None:
            # of the origin; the kernel looks for that of the DVL's place
            velocity = going[0][index] + np.cross(rate, leader.place)
            velocity_known = going[1][index]
        command = np.zeros((steps, MOST_THRUSTERS))
        command[:, : len(leader.packed.thruster_names)] = window.command
        readings: _Readings = (
            rate,
            rate_known,
            velocity,
            velocity_known,
            *_channel(table, "attitude", index, 4),
            *_channel(table, "position", index, 3),
        )
        found.append(_Measured(window, readings, command, ended == round(window.begin_s, 6)))
        ended = round(window.begin_s + window.duration_s, 6)
    return found


def _pass(
    leader: _Leader, measured: Sequence[_Measured], known: Sequence[FloatArray]
) -> tuple[list[Window], list[FloatArray]]:
    """Follow the windows of a run once, with a force that is known in advance."""
    started, pulls = [], []
    state: FloatArray | None = None
    for one, ahead in zip(measured, known, strict=True):
        window = one.window
        begin = window.start
        # goes on where the window before ended, so that the drives are where they were
        if one.joins and state is not None:
            # but where it was measured to be: a velocity that is a little off would lead it away
            begin = state.copy()
            if "depth" in window.readings:
                begin[2] = window.start[2]
            if "position" in window.readings and not leader.sure:
                begin[:2] = window.start[:2]
        state, pull = _follow_window(leader, one, begin, ahead)
        if state is None:
            begin = window.start
            pull = np.zeros((len(window.command), 6))
        started.append(replace(window, start=begin))
        pulls.append(pull)
    return started, pulls


def _follow_window(
    leader: _Leader, one: _Measured, begin: FloatArray, ahead: FloatArray
) -> tuple[FloatArray | None, FloatArray]:
    """State at the end and the pull; None where the simulation ran away."""
    packed, steps = leader.packed, len(one.command)
    late = round(_LATE_S / one.window.step_s)
    smooth = max(round(_SMOOTH_S / one.window.step_s), 1)
    ahead = uniform_filter1d(ahead, smooth, axis=0, mode="nearest")
    # what is known to act from outside is no part of the pull, but acts beside it
    outside = np.zeros((steps, 6)) if one.window.outside is None else one.window.outside
    pull = ahead[np.minimum(np.arange(steps) + late, steps - 1)] + outside
    states = np.empty((steps + 1, STATE))
    sound = follow_window(
        vector_under(one.window.conditions, leader.vector),
        begin,
        one.command,
        float(one.window.step_s),
        _HELD,
        RK4,
        leader.mass,
        np.array([TURN_BANDWIDTH, GO_BANDWIDTH, _PLACE if leader.sure else 0.0, _MOST_OFF]),
        leader.place,
        *one.readings,
        *packed.tables,
        states,
        pull,
    )
    return (states[-1] if sound else None), pull - outside


def _channel(
    table: RunTable, quantity: str, index: IntArray, width: int
) -> tuple[FloatArray, BoolArray]:
    if quantity not in table.values:
        return np.zeros((index.size, width)), np.zeros(index.size, bool)
    values = table.values[quantity][index]
    known = table.valid[quantity][index] & np.isfinite(values).all(axis=1)
    return np.where(known[:, None], values, 0.0), known
