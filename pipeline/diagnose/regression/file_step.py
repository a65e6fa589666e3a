"""The vehicle file's motion over a period of the grid: nu' = M^-1 (tau + F(nu)).

Attitude and wrench are as they were measured and claimed; the motion is followed in small steps.
"""

from collections.abc import Callable

import numpy as np

from pipeline.diagnose.regression.grid import CHANNELS, GridRun
from pipeline.simulate.kernel_alone import demand_along
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.types import FloatArray, IntArray

#: Next velocities (k, c) from those now and a period before, at rows of a run.
Step = Callable[[FloatArray, FloatArray, GridRun, IntArray], FloatArray]
#: Steps in which the motion is followed [s]; speeds beyond which it has run away.
_STEP_S, MOST = 0.02, 20.0


def file_step(packed: PackedVehicle) -> Step:
    """Follow the file's motion; what was not measured of it is as it has it along the run."""
    inverse = np.linalg.inv(mass_of(packed.vector))
    # by the attitude, which a run keeps under another wrench: runs of two days share names
    known: dict[int, tuple[FloatArray, FloatArray]] = {}

    def ahead(nu: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
        """Velocities (k, 6) a period after those that a vehicle has at the rows before."""
        state = np.zeros((len(nu), 13))
        begin, end = run.attitude[rows - 1], run.attitude[rows]
        # the same turn has two quaternions
        end = end * np.where(np.sum(begin * end, axis=1) < 0.0, -1.0, 1.0)[:, None]
        count = max(round(run.period_s / _STEP_S), 1)
        for k in range(count):
            between = begin + (k + 0.5) / count * (end - begin)
            state[:, 3:7] = between / np.linalg.norm(between, axis=1)[:, None]
            state[:, 7:13] = nu
            demand = np.zeros((len(nu), 6))
            demand_along(packed.vector, state, np.zeros((len(nu), 6)), packed.strips, demand)
            rate = (run.wrench[rows] - demand) @ inverse.T
            nu = np.clip(nu + run.period_s / count * rate, -MOST, MOST)
        return nu

    def along(run: GridRun, own: list[int]) -> FloatArray:
        """Velocities (m, 6) along a run, from rest: as measured where they were."""
        found = np.zeros((len(run.velocity), 6))
        found[:, own] = run.velocity
        others = [axis for axis in range(6) if axis not in own]
        for row in range(1, len(found)) if others else ():
            now = ahead(found[row - 1 : row], run, np.array([row]))
            found[row, others] = np.nan_to_num(now[0, others])
        return found

    def step(now: FloatArray, _before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
        own = [CHANNELS.index(name) for name in run.channels]
        if id(run.attitude) not in known:
            known[id(run.attitude)] = (run.attitude, along(run, own))
        nu = known[id(run.attitude)][1][rows - 1].copy()
        nu[:, own] = now
        return np.nan_to_num(ahead(nu, run, rows)[:, own])

    return step
