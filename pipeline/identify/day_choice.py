"""Which parts of a day's runs the identification takes: the most exciting, within a time."""

from collections.abc import Sequence

import numpy as np

from pipeline.identify.channel_noise import QUANTITIES, was_measured
from pipeline.records.run_table import RunTable
from pipeline.records.trial import RunUsed
from pipeline.types import BoolArray, FloatArray

#: Runs are weighed in pieces of this length. [s]
PIECE_S = 40.0
#: Commands that change less than this share of their range tell nothing of the vehicle.
LEAST_EXCITATION = 0.01
#: A piece whose commands are known for less of its rows is not taken.
LEAST_COMMANDED = 0.5


def choose_stretches(
    runs: Sequence[RunTable], code_max: FloatArray, budget_s: float
) -> tuple[tuple[RunTable, ...], tuple[RunUsed, ...], tuple[str, ...]]:
    """Choose the stretches in which the commands change most.

    Parameters
    ----------
    runs : sequence of RunTable
        The day's runs.
    code_max : ndarray, shape (n,)
        Largest code of each thruster.
    budget_s : float
        Seconds of run that may be taken in all. [s]

    Returns
    -------
    tuple
        The stretches as tables of their own, what they are, and a sentence for each run of which
        nothing was taken.
    """
    pieces: list[tuple[float, int, int, int]] = []
    passed: list[str] = []
    for number, run in enumerate(runs):
        if not was_measured(run, "command"):
            passed.append(f"{run.name}: its log has no commands.")
            continue
        if not any(was_measured(run, quantity) for quantity in QUANTITIES):
            passed.append(f"{run.name}: no channel shows how the vehicle moved.")
            continue
        own = [(score, number, a, b) for score, a, b in _pieces(run, code_max)]
        if not own:
            passed.append(_why_none(run))
        pieces += own
    chosen: list[tuple[float, int, int, int]] = []
    left_s = budget_s
    for piece in sorted(pieces, key=lambda one: (-one[0], one[1:])):
        length_s = _length_s(runs[piece[1]], piece)
        if length_s <= left_s + 1e-9:
            chosen.append(piece)
            left_s -= length_s
    merged = _merged(sorted(chosen, key=lambda one: one[1:]))
    taken = {piece[1] for piece in merged}
    passed += [
        f"{runs[number].name}: others have commands that change more, and {budget_s:g} s are full."
        for number in sorted({piece[1] for piece in pieces} - taken)
    ]
    tables, used = [], []
    for score, number, begin, end in merged:
        run = runs[number]
        tables.append(run.rows(begin, end))
        used.append(
            RunUsed(
                run=run.name,
                from_s=float(run.time_s[begin]),
                to_s=float(run.time_s[end - 1]),
                excitation=score,
            )
        )
    return tuple(tables), tuple(used), tuple(passed)


def _pieces(run: RunTable, code_max: FloatArray) -> list[tuple[float, int, int]]:
    """Score and rows of each piece that is worth taking."""
    found = []
    for begin, end in _long_enough(run):
        there = _commanded(run, begin, end)
        if there.mean() < LEAST_COMMANDED:
            continue
        spread = np.std(run.values["command"][begin:end][there] / code_max, axis=0)
        score = float(np.sqrt(np.mean(spread**2)))
        if score >= LEAST_EXCITATION:
            found.append((score, begin, end))
    return found


def _long_enough(run: RunTable) -> list[tuple[int, int]]:
    """Rows of the pieces of a run; a rest of less than half a piece is none."""
    period = run.period_s if run.time_s.size > 1 else 1.0
    length = max(round(PIECE_S / period), 2)
    ends = (
        (begin, min(begin + length, run.time_s.size)) for begin in range(0, run.time_s.size, length)
    )
    return [(begin, end) for begin, end in ends if end - begin >= length // 2]


def _commanded(run: RunTable, begin: int, end: int) -> BoolArray:
    """Whether the commands of each row are known, (end - begin,)."""
    command = run.values["command"][begin:end]
    return np.asarray(run.valid["command"][begin:end] & np.isfinite(command).all(axis=1))


def _why_none(run: RunTable) -> str:
    """Say why no piece of a run is worth taking."""
    pieces = _long_enough(run)
    if not pieces:
        return (
            f"{run.name}: {run.time_s[-1]:.0f} s are too short; {PIECE_S / 2:g} s at least are "
            "needed."
        )
    if all(_commanded(run, *piece).mean() < LEAST_COMMANDED for piece in pieces):
        return f"{run.name}: most of its commands are missing."
    return f"{run.name}: its commands hardly change."


def _length_s(run: RunTable, piece: tuple[float, int, int, int]) -> float:
    return float(run.time_s[piece[3] - 1] - run.time_s[piece[2]])


def _merged(pieces: Sequence[tuple[float, int, int, int]]) -> list[tuple[float, int, int, int]]:
    """Join pieces of one run that follow each other."""
    found: list[tuple[float, int, int, int]] = []
    for score, number, begin, end in pieces:
        if found and found[-1][1] == number and found[-1][3] == begin:
            before = found[-1]
            weight = (before[3] - before[2], end - begin)
            mean = float(np.average([before[0], score], weights=weight))
            found[-1] = (mean, number, before[2], end)
        else:
            found.append((score, number, begin, end))
    return found
