"""Stretches of runs simulated each under the conditions of its run."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.records.run_conditions import Conditions
from pipeline.simulate.kernel import STATE
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pieces import Pieces, run_pieces
from pipeline.simulate.vector_under import vector_under
from pipeline.types import FloatArray, IntArray


@dataclass(frozen=True)
class Alike:
    """Stretches of a layout under the same conditions, with the steps and rows that are theirs."""

    conditions: Conditions
    stretches: IntArray
    pieces: Pieces
    steps: IntArray
    rows: IntArray


def alike_pieces(layout: Pieces, conditions: Sequence[Conditions]) -> tuple[Alike, ...]:
    """Sort the stretches of a layout by their conditions."""
    found = []
    for known in dict.fromkeys(conditions):
        own = np.array([k for k, one in enumerate(conditions) if one == known])
        first, end = layout.bounds[own], layout.bounds[own + 1]
        steps = np.concatenate([np.arange(a, b) for a, b in zip(first, end, strict=True)])
        rows = np.concatenate(
            [np.arange(a + k, b + k + 1) for k, a, b in zip(own, first, end, strict=True)]
        )
        pieces = Pieces(
            layout.commands[steps],
            np.concatenate([[0], np.cumsum(end - first)]),
            layout.steps_s[own],
        )
        found.append(Alike(known, own, pieces, steps, rows))
    return tuple(found)


def run_alike(
    packed: PackedVehicle,
    layout: Pieces,
    alike: tuple[Alike, ...],
    vector: FloatArray,
    *,
    starts: FloatArray,
    external: FloatArray,
    method: int | None = None,
) -> tuple[FloatArray, FloatArray]:
    """States and accelerations of a layout, each run as it is known to have been.

    Parameters as of `run_pieces`; `vector` is the vehicle's, whatever ran with more ballast or
    less, and `alike` the layout sorted by conditions.
    """
    if len(alike) == 1:
        under = vector_under(alike[0].conditions, vector)
        return run_pieces(packed, layout, under, starts, external, method=method)
    count = len(layout.commands) + len(starts)
    states, rates = np.empty((count, STATE)), np.empty((count, 6))
    for one in alike:
        states[one.rows], rates[one.rows] = run_pieces(
            packed,
            one.pieces,
            vector_under(one.conditions, vector),
            starts[one.stretches],
            external[one.steps],
            method=method,
        )
    return states, rates
