"""Whether a file was read as its truth says, refused, told of, or read wrongly in silence."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from evaluation.bench_files.corruptions import CORRUPTIONS, Corruption
from evaluation.bench_files.table import save, write_down
from evaluation.bench_files.truth import Truth, draw_truth, judged
from pipeline.stages.bench_records import READERS
from pipeline.stages.job import RawRecord
from pipeline.types import FloatArray

Outcome = Literal["right", "refused", "told", "silently wrong"]
#: Of the largest value of each coordinate.
_TOLERANCE = 0.03
_WRONG_SHARE, _LEAST_SHARE = 0.05, 0.8
_CLEAN_SHARE = 0.35


@dataclass(frozen=True)
class Judged:
    """One file: its number, what was done to it, how it was read."""

    number: int
    kind: str
    corruptions: tuple[str, ...]
    outcome: Outcome
    has_way_out: bool
    """Of a refusal: whether it says what to do."""
    said: tuple[str, ...]


def judge_file(seed: int, number: int, folder: Path) -> Judged:
    """Draw a file, write it, read it without a mapping, and judge what came of it.

    Parameters
    ----------
    seed, number : int
        Which file; the same ones give the same file.
    folder : Path
        Where it is written; it is removed again unless it was read wrongly in silence.
    """
    rng = np.random.default_rng((seed, number))
    truth = draw_truth(rng)
    written = write_down(truth, rng)
    wanted = 0 if rng.random() < _CLEAN_SHARE else int(rng.integers(1, 3))
    done: list[Corruption] = []
    for at in rng.permutation(len(CORRUPTIONS)).tolist():
        if len(done) < wanted and CORRUPTIONS[at](written, truth, rng):
            done.append(CORRUPTIONS[at])
    path = save(written, folder, f"{truth.kind}_{seed}_{number}")
    record = READERS[truth.kind]([path], truth.vehicle, folder)
    outcome = _outcome(truth, record)
    if outcome != "silently wrong":
        path.unlink()
    errors = [one for one in record.problems if one.severity == "error"]
    return Judged(
        number,
        truth.kind,
        tuple(one.__name__ for one in done),
        outcome,
        any(one.remedy for one in errors),
        tuple(str(one) for one in record.problems if one.severity != "note"),
    )


def _outcome(truth: Truth, record: RawRecord) -> Outcome:
    used = [point for point in record.points if not point.marks]
    if not used:
        return "refused"
    right = _coordinates(truth)
    names = _names(truth)
    # an open-water row may lack one of its coefficients
    whole = [point for point in used if getattr(point, names[-1]) is not None]
    if not whole:
        return "told" if any(one.severity != "note" for one in record.problems) else "right"
    read = np.array([[getattr(point, name) or 0.0 for name in names] for point in whole])
    scale = np.maximum(np.abs(right).max(axis=0), 1e-12)
    apart = np.abs(read[:, None, :] - right[None, :, :]) / scale
    close = (apart <= _TOLERANCE).all(axis=2)
    wrong = 1.0 - float(close.any(axis=1).mean())
    found = float(close.any(axis=0)[_clear(truth)].mean())
    if wrong <= _WRONG_SHARE and found >= _LEAST_SHARE:
        return "right"
    warned = any(one.severity != "note" for one in record.problems)
    if wrong <= _WRONG_SHARE or warned:
        return "told" if warned else "silently wrong"
    return "silently wrong"


def _names(truth: Truth) -> tuple[str, ...]:
    return {
        "mooring": ("code", "thrust_n"),
        "load_test": ("code", "shaft_speed_rpm", "torque_nm"),
        "open_water": ("advance_ratio", "thrust_coefficient"),
    }[truth.kind]


def _coordinates(truth: Truth) -> FloatArray:
    x, y = judged(truth)
    if truth.kind == "open_water":
        return np.stack([x, y], axis=1)
    code = truth.columns["code"]
    return np.stack([code, y] if truth.kind == "mooring" else [code, x, y], axis=1)


def _clear(truth: Truth) -> FloatArray:
    """Return which readings must be found: those at rest are the tare."""
    if truth.kind == "open_water":
        return np.ones(truth.columns["speed"].size, bool)
    return np.asarray(truth.columns["code"] != 0.0)


def summary(files: Sequence[Judged]) -> str:
    """Return counts of the outcomes, and every file that was read wrongly in silence."""
    clean = [one for one in files if not one.corruptions]
    lines = [f"{len(files)} files, {len(clean)} of them without a corruption"]
    for outcome in ("right", "refused", "told", "silently wrong"):
        count = sum(one.outcome == outcome for one in files)
        of_clean = sum(one.outcome == outcome for one in clean)
        lines.append(f"  {outcome}: {count} ({of_clean} of those without a corruption)")
    refused = [one for one in files if one.outcome == "refused"]
    with_way = sum(one.has_way_out for one in refused)
    lines.append(f"  refusals that say what to do: {with_way} of {len(refused)}")
    lines += [
        f"  silently wrong: {one.kind} {one.number}: {', '.join(one.corruptions) or 'clean'}"
        for one in files
        if one.outcome == "silently wrong"
    ]
    lines += [
        f"  clean and {one.outcome}: {one.kind} {one.number}: {'; '.join(one.said)[:300]}"
        for one in clean
        if one.outcome not in {"right", "silently wrong"}
    ]
    return "\n".join(lines)
