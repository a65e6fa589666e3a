"""The floating-point firmware: its tables, every number rounded to single precision."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.export.grid_check import largest_negative
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic

Float32Array = npt.NDArray[np.float32]


@dataclass(frozen=True)
class SingleBranch:
    """One sign of thrust, every number rounded to single precision."""

    speed_mps: Float32Array
    thrust_max_n: Float32Array
    fraction: Float32Array
    code: Float32Array
    drag_n: Float32Array


@dataclass(frozen=True)
class SingleTables:
    """Both signs; `thrust_dead_n` is rounded down so that `>` decides as in real numbers."""

    thrust_dead_n: np.float32
    code_min: int
    code_max: int
    tested_mps: np.float32
    positive: SingleBranch
    negative: SingleBranch


def single_tables(characteristic: FirmwareCharacteristic) -> SingleTables:
    """Round a characteristic that `check_characteristic` accepted to single precision."""
    dead = np.float32(characteristic.thrust_dead_n)
    if float(dead) > characteristic.thrust_dead_n:
        dead = np.nextafter(dead, np.float32(-np.inf))
    return SingleTables(
        thrust_dead_n=dead,
        code_min=characteristic.code_min,
        code_max=characteristic.code_max,
        tested_mps=np.float32(characteristic.fastest_tested_mps),
        positive=_single_branch(characteristic.positive, characteristic.code_max),
        negative=_single_branch(characteristic.negative, largest_negative(characteristic)),
    )


def _single_branch(branch: FirmwareBranch, code_max: int) -> SingleBranch:
    return SingleBranch(
        speed_mps=np.asarray(branch.speed_mps, np.float32),
        thrust_max_n=np.asarray(branch.thrust_max_n, np.float32),
        fraction=np.asarray(branch.fraction, np.float32),
        code=np.clip(branch.code, 0.0, code_max).astype(np.float32),
        drag_n=np.asarray(branch.drag_n or np.zeros(len(branch.speed_mps)), np.float32),
    )
