"""Which parts of a day's runs the identification takes: the most exciting, within a time."""

from collections.abc import Sequence

import numpy as np

from pipeline.identify.channel_noise import QUANTITIES, was_measured
from pipeline.records.run_table import RunTable
from pipeline.records.trial import RunUsed
from pipeline.types import FloatArray

#: Runs are weighed in pieces of this length. [s]
PIECE_S = 40.0
#: Commands that change less than this share of their range tell nothing of the vehicle.
LEAST_EXCITATION = 0.01
#: A piece whose commands are known for less of its rows is not taken.
LEAST_COMMANDED = 0.5

#: How much its commands change, number of the run, first row, and the one after the last.
_Piece = tuple[float, int, int, int]


def choose_stretches(
    runs: Sequence[RunTable], code_max: FloatArray, budget_s: float
) -> tuple[tuple[RunTable, ...], tuple[RunUsed, ...], tuple[str, ...]]:
    """Choose the stretches of a day's runs in which the commands change most.

    `code_max` (n,) is the largest code of each thruster, `budget_s` the seconds of run that may be
    taken in all. Returns the stretches as tables of their own, what they are, and a sentence for
    each run of which nothing was taken.
    """
    pieces: list[_Piece] = []
    passed: list[str] = []
    for number, run in enumerate(runs):
        own, why = _pieces(run, code_max)
        pieces += [(score, number, begin, end) for score, begin, end in own]
        if not own:
            passed.append(why)
    chosen: list[_Piece] = []
    left_s = budget_s
    for piece in sorted(pieces, key=lambda one: (-one[0], one[1:])):
        _, number, begin, end = piece
        length_s = float(runs[number].time_s[end - 1] - runs[number].time_s[begin])
        if length_s <= left_s + 1e-9:
            chosen.append(piece)
            left_s -= length_s
    merged = _merged(sorted(chosen, key=lambda one: one[1:]))
    passed += [
        f"{runs[number].name}: others have commands that change more, and {budget_s:g} s are full."
        for number in sorted({piece[1] for piece in pieces} - {piece[1] for piece in merged})
    ]
    used = tuple(
        RunUsed(
            run=runs[number].name,
            from_s=float(runs[number].time_s[begin]),
            to_s=float(runs[number].time_s[end - 1]),
            excitation=score,
        )
        for score, number, begin, end in merged
    )
    tables = tuple(runs[number].rows(begin, end) for _, number, begin, end in merged)
    return tables, used, tuple(passed)


def _pieces(run: RunTable, code_max: FloatArray) -> tuple[list[tuple[float, int, int]], str]:
    """Score and rows of each piece that is worth taking; why, where none is."""
    if not was_measured(run, "command"):
        return [], f"{run.name}: its log has no commands."
    if not any(was_measured(run, quantity) for quantity in QUANTITIES):
        return [], f"{run.name}: no channel shows how the vehicle moved."
    rows = run.time_s.size
    length = max(round(PIECE_S / (run.period_s if rows > 1 else 1.0)), 2)
    # a rest of less than half a piece is none
    parts = [(a, min(a + length, rows)) for a in range(0, rows, length) if rows - a >= length // 2]
    if not parts:
        return [], (
            f"{run.name}: {run.time_s[-1]:.0f} s are too short; {PIECE_S / 2:g} s at least are "
            "needed."
        )
    command, there = run.values["command"] / code_max, run.trusted("command")
    known = [part for part in parts if there[slice(*part)].mean() >= LEAST_COMMANDED]
    if not known:
        return [], f"{run.name}: most of its commands are missing."
    found = []
    for begin, end in known:
        spread = np.std(command[begin:end][there[begin:end]], axis=0)
        found.append((float(np.sqrt(np.mean(spread**2))), begin, end))
    return [
        one for one in found if one[0] >= LEAST_EXCITATION
    ], f"{run.name}: its commands hardly change."


def _merged(pieces: Sequence[_Piece]) -> list[_Piece]:
    """Join pieces of one run that follow each other."""
    found: list[_Piece] = []
    for score, number, begin, end in pieces:
        if found and found[-1][1] == number and found[-1][3] == begin:
            before = found[-1]
            weight = (before[3] - before[2], end - begin)
            mean = float(np.average([before[0], score], weights=weight))
            found[-1] = (mean, number, before[2], end)
        else:
            found.append((score, number, begin, end))
    return found
