"""Each piece of the motion simulated anew: from elsewhere, pushed otherwise, as another vehicle.

An outside force is counted as the acceleration that it gives, times the nominal mass matrix. Were
it counted in newtons, a vehicle of less mass, less drag and less thrust would need less of it for
the same motion, and that would speak for it: all of them came out too small together.
"""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.linear.coordinates import may_bend
from pipeline.diagnose.linear.linear_model import Point, Setting, vector_of
from pipeline.diagnose.linear.predictions import (
    Bench,
    Motion,
    drives_at,
    innovations,
    other_drives,
    same_motion,
    simulate_cut,
)
from pipeline.identify.window_derivatives import moved_starts
from pipeline.physics.parameters import read
from pipeline.simulate.kernel import BODY
from pipeline.simulate.pack import mass_of
from pipeline.types import FloatArray

#: Steps of the derivatives: position [m], attitude [rad], velocity [m/s], turning rate [rad/s].
_STEPS = np.repeat([1e-3, 1e-5, 1e-4, 1e-4], 3)
#: The same of the outside forces, in the unit of a healthy vehicle's.
_FORCE_STEP = 0.1
#: The same of the characteristic's unknowns, in their standard deviations.
_PROFILE_STEP = 0.01
#: The same of the pull, of which all is taken away.
_PULL_STEP = 1e-3
#: Departure below which a wide step is taken where one is asked for.
_AT_NEUTRAL = 0.02
#: Departure of a lead while the departure that needs it is moved.
_LEAD_STEP = 0.02


@dataclass(frozen=True)
class Pass:
    """One way of moving all pieces: readings (entries,) and ends (pieces, 12), per unit."""

    readings: FloatArray
    ends: FloatArray


@dataclass(frozen=True)
class Seen:
    """Motion of all pieces, their readings (entries,) and ends (pieces, STATE)."""

    motion: Motion
    readings: FloatArray
    ends: FloatArray


@dataclass(frozen=True)
class MovedPieces:
    """Where the pieces start, what pushes them, and what comes out."""

    setting: Setting
    point: Point
    vector: FloatArray
    starts: FloatArray
    forces: FloatArray
    known: Seen
    wide: float

    def from_start(self, index: int) -> Pass:
        """Move the starts in one of twelve directions."""
        if index < 3 and _alike_everywhere(self.vector):
            return _way(self.known, self._elsewhere(index), _STEPS[index])
        by = np.zeros((len(self.starts), 12))
        by[:, index] = _STEPS[index]
        moved = seen_in(self.setting, self.vector, moved_starts(self.starts, by), self.forces)
        return _way(self.known, moved, _STEPS[index])

    def _elsewhere(self, axis: int) -> Seen:
        """Carry the motion a step along one axis of the world, as it is."""
        by = np.zeros(self.starts.shape[1])
        by[axis] = _STEPS[axis]
        motion = replace(self.known.motion, state=self.known.motion.state + by)
        return Seen(motion, _raw(self.setting.bench, self.vector, motion), self.known.ends + by)

    def from_force(self, axis: int) -> Pass:
        """Push along one axis."""
        nominal = mass_of(self.setting.bench.stack.packed.vector)
        more = np.zeros(6)
        more[axis] = _FORCE_STEP * self.setting.force_unit[axis]
        more = mass_of(self.vector) @ np.linalg.solve(nominal, more)
        return self._from_forces(self.forces + more, _FORCE_STEP)

    def from_profile(self, number: int) -> Pass:
        """Push as one of the characteristic's unknowns does."""
        more = _PROFILE_STEP * self.setting.profiles[:, :, number]
        return self._from_forces(self.forces + more, _PROFILE_STEP)

    def from_pull(self) -> Pass:
        """Take a little of the pull away."""
        pull = self.point.pull * np.concatenate(self.setting.bench.pulls)
        return self._from_forces(self.forces - _PULL_STEP * pull, -_PULL_STEP)

    def _from_forces(self, forces: FloatArray, by: float) -> Pass:
        return _way(self.known, seen_in(self.setting, self.vector, self.starts, forces), by)

    def from_departure(self, number: int) -> Pass:
        """Move one departure off where it is."""
        setting, one = self.setting, self.setting.coordinates[number]
        moved, known, vector, by = self.point.departures.copy(), self.known, self.vector, one.step
        bends = number in may_bend(setting.coordinates)
        if self.wide and bends and abs(moved[number]) < _AT_NEUTRAL:
            by = self.wide * np.sign(one.step)
        if one.leads:
            if abs(one.lead_size(moved)) < one.least_lead:
                # without its lead it does nothing: taken where the first is at its own step
                moved[one.leads[0]] = _LEAD_STEP * np.sign(setting.coordinates[one.leads[0]].step)
                moved[number] = 0.0
                vector = vector_of(setting, moved)
                known = seen_in(setting, vector, self.starts, self._forces_of(vector))
            by = one.step * one.lead_size(moved)
        moved[number] += by
        changed = vector_of(setting, moved)
        if same_motion(changed, vector):
            readings = _raw(setting.bench, changed, known.motion)
            return Pass((known.readings - readings) / by, np.zeros((len(self.starts), 12)))
        begin = self.starts
        if other_drives(changed, vector):
            # the drives are not where they were when the piece begins
            pieces = setting.bench.start_of_piece
            ways = [drives_at(setting.bench, one, pieces) for one in (vector, changed)]
            begin = self.starts.copy()
            begin[:, BODY : BODY + ways[0].shape[1]] += ways[1] - ways[0]
        return _way(known, seen_in(setting, changed, begin, self._forces_of(changed)), by)

    def _forces_of(self, vector: FloatArray) -> FloatArray:
        """Return what pushes a vehicle of other masses as the forces here push this one."""
        here, there = mass_of(self.vector), mass_of(vector)
        if np.array_equal(here, there):
            return self.forces
        return np.asarray(self.forces @ np.linalg.solve(here, there))


def _alike_everywhere(vector: FloatArray) -> bool:
    """Whether a vehicle moves alike wherever it is: no wall is near it, and no tether pulls."""
    return not (read(vector, "wall_strength").any() or read(vector, "tether_pull").any())


def _way(first: Seen, second: Seen, by: float) -> Pass:
    """Take derivatives from two motions of the pieces; readings are measured less predicted."""
    return Pass((first.readings - second.readings) / by, _between(first.ends, second.ends) / by)


def seen_in(setting: Setting, vector: FloatArray, starts: FloatArray, forces: FloatArray) -> Seen:
    """Simulate all pieces."""
    bench = setting.bench
    states, rates = simulate_cut(bench, vector, starts, forces)
    rows = bench.row_of_sample
    motion = Motion(states[rows], rates[rows])
    return Seen(motion, _raw(bench, vector, motion), states[bench.cut.last_row])


def _raw(bench: Bench, vector: FloatArray, motion: Motion) -> FloatArray:
    """Innovations of all channels as one vector (entries,)."""
    return np.concatenate([one.ravel() for one in innovations(bench, vector, motion)])


def _between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Way (k, 12) from first to second states: place, body rotation, velocity."""
    found = np.empty((len(first), 12))
    found[:, :3] = second[:, :3] - first[:, :3]
    found[:, 6:] = second[:, 7:13] - first[:, 7:13]
    a, b = first[:, 3:7], second[:, 3:7]
    found[:, 3:6] = 2.0 * (a[:, :1] * b[:, 1:] - b[:, :1] * a[:, 1:] - np.cross(a[:, 1:], b[:, 1:]))
    return found
