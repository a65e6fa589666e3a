"""A tether without a vehicle, moved by the compiled kernel between given ends.

A module of the tests.
"""

from typing import Literal

import numpy as np

from pipeline.physics.winch import Winch
from pipeline.simulate import kernel_swing as kernel
from pipeline.simulate.run import check_step
from pipeline.simulate.tether import (
    LumpedMassTether,
    TetherHistory,
    TetherRecord,
    TetherState,
    history,
    prepare,
    refuse,
)
from pipeline.types import ArrayLike, FloatArray


def swing(
    tether: LumpedMassTether,
    state: TetherState,
    *,
    steps: int,
    dt_s: float,
    lower: Literal["free", "held"],
    current_mps: FloatArray,
    lower_velocity_mps: FloatArray | None = None,
    winch: Winch | None = None,
    winch_command: ArrayLike = 0.0,
    settle: bool = False,
) -> TetherHistory:
    """Simulate a tether without a vehicle.

    Parameters
    ----------
    tether : LumpedMassTether
        The cable.
    state : TetherState
        To start from.
    steps, dt_s : int, float
        Number of steps and their length [s]; sub-steps are chosen inside.
    lower : {"free", "held"}
        Whether the lower end hangs free or is held, or moved.
    current_mps : ndarray, shape (3,)
        NED. [m/s]
    lower_velocity_mps : ndarray, shape (3,) or (steps, 3), optional
        Of the lower end, NED, held for a step each; at rest otherwise. [m/s]
    winch : Winch, optional
        At the top.
    winch_command : float or ndarray, shape (steps,)
        u, between -1 and 1. [-]
    settle : bool
        Whether the nodes are stopped at each peak of their energy, which brings them to rest.

    Raises
    ------
    CannotComputeError
        A number is not one, the step is too large, or more cable was paid out than there is
        room for.
    """
    check_step(dt_s)
    inputs = prepare(
        tether,
        state,
        current_mps=current_mps,
        winch=winch,
        winch_command=winch_command,
    )
    out = TetherRecord.empty(steps, len(inputs.place))
    below = np.zeros(3) if lower_velocity_mps is None else lower_velocity_mps
    status = kernel.swing(
        kernel.FREE if lower == "free" else kernel.HELD,
        np.array(below, float, ndmin=2),
        float(dt_s),
        settle,
        *inputs,
        *out,
    )
    refuse(status, tether, dt_s)
    return history(out, inputs, dt_s=dt_s)
