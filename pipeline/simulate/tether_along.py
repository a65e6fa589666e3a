r"""What a tether did to a vehicle in a measured run.

A fit simulates short windows of a run thousands of times, and a cable of twenty segments that moves
with the vehicle would make each a hundred times as long. So the cable is simulated once for a run,
before the fit, on a vehicle that is led along what was measured; its force on the vehicle is then
known from outside, as a current's would be, and every window is simulated under it.

The measured motion itself will not do: a cable turns the noise of a position into newtons (EA over
the length of a segment is kilonewtons a metre). The vehicle and its cable are flown together with
the commands of the run, and a force

.. math:: F = M (2 \omega e_v + \omega^2 e_x)

leads them along gyro, attitude, velocity, depth and position as far as they were measured. What the
model of the vehicle lacks is in that force and not in the cable's: the cable only feels the motion.

At the right parameters a window moves as was measured, and the force is that of this motion. What
is left out is how the cable's force would differ along a motion that differs: its own added mass
and drag, and the stiffness of one that is taut, in the derivatives of the fit.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from pipeline.errors import CannotComputeError
from pipeline.records.run_table import RunTable
from pipeline.simulate.fly import usual_step_s
from pipeline.simulate.kernel_alone import fill_turn
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.simulate.pack_hull import vector_under
from pipeline.simulate.run import initial_state
from pipeline.simulate.run_conditions import RunSetup
from pipeline.simulate.tethered_mover import nominal_mover
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

#: Time for which the leading force is held. [s]
_HELD_S = 0.1
#: Bandwidth of turning and of going [rad/s]; pull towards depth and position [1/s^2], slow enough
#: for a position that comes every few seconds and is half a metre off.
_TURN, _GO, _DEPTH, _PLACE = 4.0, 2.0, 0.5, 0.05
#: A position that is known most of the time stands for a velocity, averaged over so long. [s]
_GOING_S, _MOSTLY = 1.0, 0.5
#: Angle, way, or pull beyond which the force grows no further. [rad, m, m/s^2]
_MOST_OFF = 0.5
#: A motion that is faster has run away. [m/s, rad/s]
_FASTEST = 100.0


@dataclass(frozen=True)
class _Channel:
    """A quantity of a table at its rows, (m, k), and where it is known, (m,)."""

    values: FloatArray
    known: BoolArray


def tether_force(
    packed: PackedVehicle, sensors: Sensors, table: RunTable, setup: RunSetup
) -> FloatArray | None:
    """Force and moment of the tether on the vehicle at every row of a run (m, 6) [N, N m].

    Body axes, about the body origin; None where the run has no tether. What is missing at the start
    of the `table` is taken for rest at the NED origin; `setup` is tether, winch, ballast and events
    of the run.

    Raises
    ------
    CannotComputeError
        When the tether does not reach the vehicle, or cannot be simulated along this motion.
    """
    mover = nominal_mover(setup.model, setup.orders)
    if mover is None or table.time_s.size < 2:
        return None
    lead = _Lead(sensors, table)
    step_s = usual_step_s(packed)
    inner = round(_HELD_S / step_s)
    state = lead.start()
    commands = np.nan_to_num(table.values["command"])
    end_s = float(table.time_s[-1] - table.time_s[0])
    for block in range(int(np.ceil(end_s / _HELD_S - 1e-9))):
        begin_s = block * _HELD_S
        rows = lead.rows(begin_s + step_s * np.arange(inner, dtype=float))
        vector = vector_under(setup.conditions(begin_s), packed.vector)
        push = lead.force(int(rows[0]), state, vector)
        state = mover(
            packed,
            commands[rows],
            dt_s=step_s,
            vector=vector,
            start=state,
            start_time_s=begin_s,
            external=push[None],
        ).final_state
        if not np.abs(state[7:13]).max() < _FASTEST:
            raise CannotComputeError(
                f"the vehicle on its tether cannot be led along what was measured from "
                f"{begin_s:.1f} s on"
            )
    log = mover.log()
    # what is held over a step is the mean of both its ends
    mean = 0.5 * (log.wrench_on_vehicle[1:] + log.wrench_on_vehicle[:-1])
    middle_s = log.time_s[:-1] + 0.5 * step_s
    half_s = 0.5 * table.period_s
    at_s = table.time_s - table.time_s[0] + half_s
    return np.stack([np.interp(at_s, middle_s, column) for column in mean.T], axis=1)


class _Lead:
    """Leads a vehicle along the channels of a table."""

    def __init__(self, sensors: Sensors, table: RunTable) -> None:
        def channel(quantity: str, width: int) -> _Channel:
            if quantity not in table.values:
                empty = np.zeros((table.time_s.size, width))
                return _Channel(empty, np.zeros(table.time_s.size, bool))
            values = table.values[quantity]
            known = table.valid[quantity] & np.isfinite(values).all(axis=1)
            return _Channel(np.where(known[:, None], values, 0.0), known)

        self.rate, self.attitude = channel("angular_velocity", 3), channel("attitude", 4)
        self.velocity, self.depth = channel("velocity", 3), channel("depth", 1)
        self.position = channel("position", 3)
        self.period_s = table.period_s
        self.last = table.time_s.size - 1
        dvl, depth = sensors.dvl, sensors.depth
        self.dvl_m = np.zeros(3) if dvl is None else np.array(dvl.position_m)
        self.depth_m = np.zeros(3) if depth is None else np.array(depth.position_m)
        if not self.velocity.known.any():
            self.velocity, self.dvl_m = self._going(), np.zeros(3)
        self.way = np.zeros(3)
        self.tilt = np.empty(3)

    def _going(self) -> _Channel:
        """Velocity that the position shows, body axes, averaged over `_GOING_S`."""
        known = self.position.known & self.attitude.known
        if not known.any() or not self.position.known.mean() > _MOSTLY:
            return _Channel(np.zeros((known.size, 3)), np.zeros(known.size, bool))
        place = uniform_filter1d(
            self.position.values, max(round(_GOING_S / self.period_s), 1), axis=0, mode="nearest"
        )
        turn = np.where(known[:, None], self.attitude.values, (1.0, 0.0, 0.0, 0.0))
        speed = np.gradient(place, self.period_s, axis=0)
        return _Channel(Rotation.from_quat(turn[:, [1, 2, 3, 0]]).apply(speed, inverse=True), known)

    def rows(self, time_s: FloatArray) -> IntArray:
        """Rows of the table at times from its first on, the last that has begun."""
        return np.asarray(np.minimum((time_s / self.period_s + 1e-6).astype(int), self.last))

    def start(self) -> FloatArray:
        """Kernel state at the first row; what is not known there is zero."""
        state = initial_state()
        if self.attitude.known[0]:
            turn = self.attitude.values[0]
            state[3:7] = turn / np.linalg.norm(turn)
        if self.rate.known[0]:
            state[10:13] = self.rate.values[0]
        if self.velocity.known[0]:
            state[7:10] = self.velocity.values[0] - np.cross(state[10:13], self.dvl_m)
        for channel, place in ((self.position, slice(0, 3)), (self.depth, slice(2, 3))):
            if channel.known.any():
                # the first reading stands for the start: it may come seconds later
                state[place] = channel.values[int(np.argmax(channel.known))]
        if self.depth.known.any():
            state[2] -= _turn_of(state).apply(self.depth_m)[2]
        return state

    def force(self, row: int, state: FloatArray, vector: FloatArray) -> FloatArray:
        """Force (6,) that leads from a state towards a row. [N, N m]."""
        wanted = np.zeros(6)
        rate = self.rate.values[row] if self.rate.known[row] else state[10:13]
        if self.rate.known[row]:
            wanted[3:] += 2.0 * _TURN * (rate - state[10:13])
        if self.attitude.known[row]:
            fill_turn(state, self.attitude.values[row], self.tilt)
            wanted[3:] += _TURN**2 * np.clip(self.tilt, -_MOST_OFF, _MOST_OFF)
        if self.velocity.known[row]:
            off = self.velocity.values[row] - np.cross(rate, self.dvl_m) - state[7:10]
            self.way += _HELD_S * off
            wanted[:3] += 2.0 * _GO * off
            wanted[:3] += _GO**2 * np.clip(self.way, -_MOST_OFF, _MOST_OFF)
        away = np.zeros(3)
        turn = _turn_of(state)
        if self.position.known[row]:
            away = _PLACE * (self.position.values[row] - state[:3])
        if self.depth.known[row]:
            deep = state[2] + turn.apply(self.depth_m)[2]
            away[2] = _DEPTH * (float(self.depth.values[row, 0]) - deep)
        wanted[:3] += turn.apply(np.clip(away, -_MOST_OFF, _MOST_OFF), inverse=True)
        return np.asarray(mass_of(vector) @ wanted)


def _turn_of(state: FloatArray) -> Rotation:
    return Rotation.from_quat(state[[4, 5, 6, 3]])
