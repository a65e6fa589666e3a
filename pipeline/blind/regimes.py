"""Where a fault shows: how the gap of a window goes with what the vehicle does in it."""

from collections.abc import Sequence

import numpy as np

from pipeline.blind.severity import WINDOW, Floors
from pipeline.blind.truth.craft import Craft
from pipeline.blind.truth.flight import TruthFlight
from pipeline.blind.truth.kernel_flight import SAMPLES
from pipeline.types import FloatArray

REGIMES = ("speed", "command", "turning", "depth", "wall", "time")


def regimes_of(
    trace: FloatArray, floors: Floors, flights: Sequence[TruthFlight], craft: Craft
) -> dict[str, float]:
    """Rank correlation (Spearman) of the gap in windows with each regressor.

    Parameters
    ----------
    trace : ndarray, shape (windows, k, 12)
        What the fault does, flight after flight.
    floors : Floors
        What it is measured against.
    flights : sequence of TruthFlight
        The same flights.
    craft : Craft
        The stated vehicle: its walls and largest codes.

    Returns
    -------
    dict
        Of `REGIMES` those that vary.
    """
    known = np.isfinite(floors.healthy)
    gap = np.sqrt((trace[:, :, known] ** 2 / floors.healthy[known] ** 2).mean(axis=(1, 2)))
    rows = [row for flight in flights for row in _rows(flight, craft)]
    table = np.array(rows)
    out = {}
    for k, name in enumerate(REGIMES):
        values = table[:, k]
        if np.isfinite(values).all() and np.ptp(values) > 1e-6 and np.ptp(gap) > 0.0:
            out[name] = float(np.corrcoef(_rank(values), _rank(gap))[0, 1])
    return out


def _rank(values: FloatArray) -> FloatArray:
    return np.argsort(np.argsort(values)).astype(float)


def _rows(flight: TruthFlight, craft: Craft) -> list[tuple[float, ...]]:
    """Speed, command level, turning, depth, distance to the wall, time of each window."""
    out: list[tuple[float, ...]] = []
    for first in range(0, len(flight.commands) - WINDOW + 1, WINDOW):
        motion = slice(first * SAMPLES, (first + WINDOW) * SAMPLES)
        ground, place = flight.ground[motion], flight.place[motion]
        level = np.abs(flight.commands[first : first + WINDOW]) / craft.code_max
        away = np.inf
        for wall in craft.walls:
            away = min(away, float(((place - wall[:3]) @ wall[3:]).mean()))
        out.append(
            (
                float(np.linalg.norm(ground[:, :3], axis=1).mean()),
                float(level.mean()),
                float(np.abs(ground[:, 5]).mean()),
                float(place[:, 2].mean()),
                away,
                float(first),
            )
        )
    return out
