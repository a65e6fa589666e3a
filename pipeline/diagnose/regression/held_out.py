"""Predict what took no part: the learned response beside the vehicle file and simpler ways.

From windows of a run that was left out the velocities are followed ahead, attitude and commands as
they were measured. The file's motion follows by nu' = M^-1 (tau + F(nu)), with a constant for each
velocity from the other runs; the learned one by its regression, a linear black box by a regression
without squares and products.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np

from pipeline.diagnose.regression.file_step import MOST, Step, file_step
from pipeline.diagnose.regression.grid import CHANNELS, FORCES, GridRun
from pipeline.diagnose.regression.response import Response
from pipeline.records.reference import Prediction
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray, IntArray

Method = Literal["reference", "vehicle file", "identified file", "black box", "last value"]
#: How far ahead. [s]
AHEAD_S = (1.0, 3.0, 6.0)
#: Windows begin so far apart. [s]
_EVERY_S = 1.5
_RIDGE = 3.0
#: Error over that of the file from which on a response is clearly the better model. [1]
CLEARLY = 0.9


@dataclass(frozen=True)
class FileModel:
    """A vehicle file as it moves; `apart` are the runs that it may be judged by (None: all)."""

    packed: PackedVehicle
    apart: frozenset[int] | None = None


def predictions(response: Response, files: Mapping[Method, FileModel]) -> tuple[Prediction, ...]:
    """Predict every run of a reference with that run left out.

    Parameters
    ----------
    response : Response
        What was learned.
    files : mapping
        Vehicle files, by what they are called.
    """
    errors: dict[tuple[Method, str, float], list[FloatArray]] = {}
    steps = {method: file_step(model.packed) for method, model in files.items()}
    constant = {
        method: [_off(step, run) for run in response.runs] for method, step in steps.items()
    }
    for left, run in enumerate(response.runs):
        others = [one for k, one in enumerate(response.runs) if k != left]
        ways: dict[Method, Step] = {
            "reference": by_response(response, left),
            "black box": _by_black_box(others),
            "last value": lambda now, _before, _run, _rows: now,
        }
        for method, model in files.items():
            if model.apart is None or left in model.apart:
                others_off = [one for k, one in enumerate(constant[method]) if k != left]
                ways[method] = _with(steps[method], np.mean(others_off, axis=0))
        for method, step in ways.items():
            for ahead_s, found in followed(step, run, starts(run), AHEAD_S).items():
                for c, name in enumerate(run.channels):
                    errors.setdefault((method, name, ahead_s), []).append(found[:, c])
    return tuple(_table(errors))


def _table(errors: Mapping[tuple[Method, str, float], list[FloatArray]]) -> list[Prediction]:
    """Put the errors of all channels of a quantity together."""
    rows = []
    methods = dict.fromkeys(method for method, _, _ in errors)
    for quantity, own, unit in (
        ("velocity", CHANNELS[:3], "m/s"),
        ("angular_velocity", CHANNELS[3:], "rad/s"),
    ):
        for ahead_s, method in product(AHEAD_S, methods):
            places = [(method, name, ahead_s) for name in own]
            parts = [one for place in places for one in errors.get(place, [])]
            every = np.concatenate(parts) if parts else np.zeros(0)
            if every.size:
                rows.append(
                    Prediction(
                        method=method,
                        quantity=quantity,
                        unit=unit,
                        ahead_s=ahead_s,
                        rmse=float(np.sqrt(np.mean(every**2))),
                        readings=int(every.size),
                    )
                )
    return rows


def error_ahead(response: Response) -> float:
    """Return by how much a response is off of runs left out: mean log of its errors, all ways."""
    squares: dict[tuple[str, float], list[FloatArray]] = {}
    for left, run in enumerate(response.runs):
        errors = followed(by_response(response, left), run, starts(run), AHEAD_S)
        for ahead_s, found in errors.items():
            for c, name in enumerate(run.channels):
                quantity = "velocity" if name in CHANNELS[:3] else "angular_velocity"
                squares.setdefault((quantity, ahead_s), []).append(found[:, c] ** 2)
    every = [np.concatenate(one) for one in squares.values()]
    means = [float(np.mean(one)) for one in every if one.size]
    return float(np.mean(np.log(np.maximum(means, 1e-24)))) / 2.0


def decides(table: Sequence[Prediction]) -> tuple[bool, str]:
    """Say whether the learned response decides: whether it predicts better than the file.

    Judged by all ways ahead alike: what is better over a second and then runs away is no model of
    the vehicle.
    """
    file = {(row.quantity, row.ahead_s): row.rmse for row in table if row.method == "vehicle file"}
    ratios: dict[float, list[float]] = {}
    for row in table:
        other = file.get((row.quantity, row.ahead_s), 0.0)
        if row.method == "reference" and other > 0.0:
            ratios.setdefault(row.ahead_s, []).append(float(np.log(row.rmse / other)))
    if not ratios:
        return False, "no velocity and no rate could be predicted of what was left out."
    by_way = {ahead_s: float(np.exp(np.mean(one))) for ahead_s, one in sorted(ratios.items())}
    told = (
        f"on sound runs that were left out its error {', '.join(f'{s:g}' for s in by_way)} s ahead "
        f"is {', '.join(f'{one:.2f}' for one in by_way.values())} times that of the vehicle file"
    )
    if float(np.prod(list(by_way.values()))) < CLEARLY ** len(by_way):
        return True, f"{told}."
    return False, f"{told}, which is not clearly better."


def starts(run: GridRun) -> IntArray:
    """Rows of a run from which it is followed ahead."""
    return np.arange(FORCES, len(run.velocity) - 1, max(round(_EVERY_S / run.period_s), 1))


def followed(
    step: Step, run: GridRun, starts: IntArray, far_s: Sequence[float]
) -> dict[float, FloatArray]:
    """Errors (k, c) so many seconds ahead of each start that the run is long enough for."""
    counts = {ahead: max(round(ahead / run.period_s), 1) for ahead in far_s}
    now, before = run.velocity[starts], run.velocity[starts - 1]
    found, last = {}, len(run.velocity) - 1
    for done in range(1, max(counts.values()) + 1):
        rows = starts + done
        alive = rows <= last
        rows = np.minimum(rows, last)
        following = np.clip(np.nan_to_num(step(now, before, run, rows)), -MOST, MOST)
        now, before = following, now
        for ahead, count in counts.items():
            if count == done:
                found[ahead] = (now - run.velocity[rows])[alive]
    return found


def by_response(response: Response, left: int | None) -> Step:
    """Return the learned motion, without a run that is left out."""

    def step(now: FloatArray, before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
        return response.next_of(left, (now, before), run, rows)

    return step


def _off(step: Step, run: GridRun) -> FloatArray:
    """Return by how much (c,) a run goes beyond what is predicted of it a row ahead, on average."""
    rows = np.arange(FORCES, len(run.velocity))
    now, before = run.velocity[rows - 1], run.velocity[rows - 2]
    return np.asarray(np.mean(run.velocity[rows] - step(now, before, run, rows), axis=0))


def _with(step: Step, constant: FloatArray) -> Step:
    """Add to a motion what the other runs go beyond it: trim and offsets of sensors."""

    def more(now: FloatArray, before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
        return step(now, before, run, rows) + constant

    return more


def _by_black_box(runs: Sequence[GridRun]) -> Step:
    """Regress the next velocities on those now and on the forces, all linear."""
    features, following = [], []
    for run in runs:
        rows = np.arange(FORCES, len(run.velocity))
        features.append(_linear(run.velocity[rows - 1], run, rows))
        following.append(run.velocity[rows])
    x, y = np.concatenate(features), np.concatenate(following)
    size = np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-9)
    scaled = x / size
    slope = np.linalg.solve(scaled.T @ scaled + _RIDGE * np.eye(x.shape[1]), scaled.T @ y)
    slope /= size[:, None]

    def step(now: FloatArray, _before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
        return np.asarray(_linear(now, run, rows) @ slope)

    return step


def _linear(now: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
    return np.concatenate(
        [np.ones((len(now), 1)), now, run.down[rows - 1], run.wrench[rows], run.wrench[rows - 1]],
        axis=1,
    )
