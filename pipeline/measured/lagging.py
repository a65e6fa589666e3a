"""From commands to the codes that act, which lag them, and back."""

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.simulate.kernel_alone import codes_that_act
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray


def settled(vector: FloatArray, commands: FloatArray) -> FloatArray:
    """Codes (m, n) that act after a while: dead zone and supply taken off."""
    padded = np.zeros((len(commands), MOST_THRUSTERS))
    padded[:, : commands.shape[1]] = commands
    acting = np.zeros_like(padded)
    codes_that_act(vector, padded, acting)
    return acting[:, : commands.shape[1]]


def lagged(
    packed: PackedVehicle, vector: FloatArray, commands: FloatArray, period_s: float
) -> FloatArray:
    """Codes (m, n) that act in the middle of each row: a first-order lag of what is commanded.

    A run begins with the drives where its first command has led them.
    """
    # a second of imports, which most diagnoses have no need of
    from scipy.signal import lfilter

    left = _left(packed, vector, period_s)
    aims = settled(vector, commands)
    found = np.empty_like(aims)
    for column, kept in enumerate(left):
        own = aims[:, column]
        # where the code is at the start of each row, then half a row on
        rest = np.array([kept * own[0]])
        ends, _ = lfilter([1.0 - kept], [1.0, -kept], own, zi=rest)
        begins = np.concatenate([own[:1], ends[:-1]])
        found[:, column] = own + (begins - own) * np.sqrt(kept)
    return found


def commands_for(
    packed: PackedVehicle, vector: FloatArray, acting: FloatArray, period_s: float
) -> FloatArray:
    """Commands (m, n) whose lagged codes are those wanted in the middle of each row.

    Where that takes a command beyond the range of its drive, it stays at the end and the rows that
    follow make up for it.
    """
    left = _left(packed, vector, period_s)
    half = np.sqrt(left)
    low, high = (settled(vector, packed.code_limits[None, :, side])[0] for side in (0, 1))
    aims, now = np.empty_like(acting), acting[0].copy()
    for row, wanted in enumerate(acting):
        aim = np.clip((wanted - now * half) / (1.0 - half), low, high)
        now = aim + (now - aim) * left
        aims[row] = aim
    return _before(packed, vector, aims)


def _left(packed: PackedVehicle, vector: FloatArray, period_s: float) -> FloatArray:
    """Return what a row leaves of the distance to the command, by thruster."""
    lag = read(vector, "lag")[: len(packed.thruster_names)]
    return np.asarray(np.where(lag > 0.0, np.exp(-period_s / np.maximum(lag, 1e-9)), 0.0))


def _before(packed: PackedVehicle, vector: FloatArray, aims: FloatArray) -> FloatArray:
    """Commands that the drives make these codes of."""
    count = len(packed.thruster_names)
    supply = 1.0 - float(read(vector, "supply_drop"))
    lost, largest = read(vector, "dead_zone")[:count], read(vector, "code_max")[:count]
    before = float(read(vector, "lag_dead_share")) * read(vector, "drive_dead")[:count]
    size = np.abs(aims)
    size = np.where(size > before, before + (size - before) / supply, size)
    size = np.where(size > 0.0, size * (largest - lost) / largest + lost, 0.0)
    return np.asarray(np.copysign(size, aims))
