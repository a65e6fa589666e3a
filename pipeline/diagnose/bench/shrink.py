"""How far a mooring table's gap shrinks at codes that took no part, and where the gap lies."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from pipeline.diagnose.bench.effects import predict
from pipeline.diagnose.bench.fit import BenchComparison
from pipeline.diagnose.bench.model import UNITS
from pipeline.records.diagnosis import ChannelGap, RegimeShare, Shrink, ShrinkFigures, Where
from pipeline.types import BoolArray, FloatArray

Values = Mapping[tuple[str, str], float]
#: Every which code of a sign is held out.
EVERY = 3
_DRAWS = 1000
_BLOCK = 2
#: A channel, or a range of codes, is named from this ratio to the floor, or share.
_CARRIES = 1.5


def held_out_codes(code: FloatArray) -> BoolArray:
    """Mark every third code of each sign, counted from the second one beyond zero.

    >>> held_out_codes(np.array([-30.0, -20.0, -10.0, 10.0, 20.0, 30.0])).tolist()
    [False, True, False, False, True, False]
    """
    marked = np.zeros(code.size, bool)
    for sign in (-1.0, 1.0):
        side = np.flatnonzero(np.sign(code) == sign)
        side = side[np.argsort(np.abs(code[side]))]
        marked[side[1::EVERY]] = True
    return marked


def gap_channels(problem: BenchComparison) -> dict[str, ChannelGap]:
    """Gap of every channel against its two floors."""
    found: dict[str, ChannelGap] = {}
    for channel in problem.stack.channels:
        residual = problem.table.mean[channel] - problem.nominal[channel]
        scatter = problem.table.scatter[channel] / np.sqrt(problem.table.count)
        floor = _rms(np.sqrt(np.diag(problem.healthy[channel])))
        rmse = _rms(residual)
        found[channel] = ChannelGap(
            rmse=rmse,
            sensor_floor=_rms(scatter),
            healthy_floor=floor,
            ratio=rmse / floor,
            unit=UNITS[channel],
            horizons={},
        )
    return found


def where(problem: BenchComparison, gap: Mapping[str, ChannelGap]) -> Where:
    """Channels above their floor, and how the thrust gap is shared between ranges of codes."""
    code = problem.table.code
    residual = problem.table.mean["thrust"] - problem.nominal["thrust"]
    excess = np.maximum(residual**2 - np.diag(problem.healthy["thrust"]), 0.0)
    edges = np.array([-1.0, -2 / 3, -1 / 3, 0.0, 1 / 3, 2 / 3, 1.0]) * float(np.abs(code).max())
    regimes = []
    for low, high in pairwise(edges.tolist()):
        # a code between two ranges is counted once, in the one nearer to 0
        size = np.sign(low + high) * code
        nearer, further = sorted((abs(low), abs(high)))
        inside = (size > nearer) & (size <= further)
        share = float(excess[inside].sum() / excess.sum()) if excess.sum() > 0.0 else 0.0
        if share > 0.0:
            regimes.append(
                RegimeShare(
                    regressor="code",
                    unit="code",
                    range=(low, high),
                    share=share,
                    share_of_time=float(inside.mean()),
                )
            )
    regimes.sort(key=lambda one: -one.share)
    carried = [name for name, one in gap.items() if one.ratio > _CARRIES]
    carried.sort(key=lambda name: -gap[name].ratio)
    return Where(channels=tuple(carried), regimes=tuple(regimes), times=())


def shrink(problem: BenchComparison, values: Values, held_out: str, *, seed: int = 0) -> Shrink:
    """Gap at the held-out codes before and after; (before - after) / (before - healthy floor).

    The interval is that of a bootstrap over blocks of neighbouring codes (Kunsch 1989).

    Parameters
    ----------
    problem : BenchComparison
        Model and the held-out part of the table.
    values : mapping
        The answer's parameters; empty where it has none.
    held_out : str
        What was held out, in words.
    seed : int
        Of the bootstrap.
    """
    after = predict(problem.model, values, problem.table.code, problem.stack.channels)
    channels = {
        name: _figures(
            problem.table.mean[name] - problem.nominal[name],
            problem.table.mean[name] - after[name],
            np.sqrt(np.diag(problem.healthy[name])),
            seed,
        )
        for name in problem.stack.channels
    }
    thrust = channels["thrust"]
    return Shrink(**thrust.model_dump(), channels=channels, held_out=held_out)


def closed(before: float, after: float, floor: float) -> float | None:
    """Share of the explainable gap that is gone; None where there is nothing to explain.

    >>> closed(3.0, 1.5, 1.0), closed(0.9, 0.8, 1.0), closed(3.0, 0.5, 1.0)
    (0.75, None, 1.0)
    """
    if before <= floor:
        return None
    return min((before - after) / (before - floor), 1.0)


def _figures(before: FloatArray, after: FloatArray, floor: FloatArray, seed: int) -> ShrinkFigures:
    generator = np.random.default_rng(seed)
    blocks = [np.arange(i, min(i + _BLOCK, before.size)) for i in range(0, before.size, _BLOCK)]
    drawn = []
    for _ in range(_DRAWS):
        picked = generator.integers(len(blocks), size=len(blocks))
        index = np.concatenate([blocks[i] for i in picked])
        value = closed(_rms(before[index]), _rms(after[index]), _rms(floor[index]))
        if value is not None:
            drawn.append(value)
    total = closed(_rms(before), _rms(after), _rms(floor))
    low_high = None
    if total is not None and len(drawn) > _DRAWS // 2:
        low, high = np.quantile(drawn, [0.025, 0.975])
        low_high = (float(low), float(high))
    return ShrinkFigures(
        before=_rms(before),
        after=_rms(after),
        noise_floor=_rms(floor),
        gap_closed=total,
        ci95=low_high,
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
