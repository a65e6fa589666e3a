"""From commands to the codes that act, which lag them, and back."""

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.kernel_alone import codes_that_act, lag_pieces
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray


def settled(vector: FloatArray, commands: FloatArray) -> FloatArray:
    """Codes (m, n) that act after a while: dead zone and supply taken off."""
    padded = np.zeros((len(commands), MOST_THRUSTERS))
    padded[:, : commands.shape[1]] = commands
    acting = np.zeros_like(padded)
    codes_that_act(vector, padded, acting)
    return acting[:, : commands.shape[1]]


def lagged(vector: FloatArray, commands: FloatArray, period_s: float) -> FloatArray:
    """Codes (m, n) that act in the middle of each row: what is commanded, late.

    A run begins with the drives where its first command has led them.
    """
    count = commands.shape[1]
    padded = np.zeros((len(commands), MOST_THRUSTERS))
    padded[:, :count] = commands
    start = np.zeros((1, STATE))
    start[0, BODY : BODY + count] = settled(vector, commands[:1])[0]
    late = np.zeros((len(commands), 3, MOST_THRUSTERS))
    lag_pieces(vector, start, padded, np.array([0, len(commands)]), np.array([period_s]), late)
    return np.ascontiguousarray(late[:, 1, :count])


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
