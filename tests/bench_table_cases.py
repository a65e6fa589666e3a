"""A thruster and its mooring tables for the tests: closed formulas, nothing of the package."""

import numpy as np

from pipeline.diagnose.bench.model import ReferenceCurve, ThrusterAtRest
from pipeline.diagnose.bench.table import BenchTable, bench_table
from pipeline.records.base import Source
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray

CODE_MAX = 127.0
VOLTS = 24.0


def thrust(code: FloatArray) -> FloatArray:
    """Quadratic beyond a dead zone of 10 codes, 40 N at full code, astern 0.9 of it."""
    size = 40.0 * (np.maximum(np.abs(code) - 10.0, 0.0) / 117.0) ** 2
    return np.where(code < 0.0, -0.9, 1.0) * size


def model(*, volts: bool = True) -> ThrusterAtRest:
    """The thruster as a model."""
    code = np.linspace(-CODE_MAX, CODE_MAX, 255)
    channels = {"thrust": ReferenceCurve(code, thrust(code), np.full(code.size, 0.1))}
    if volts:
        ends = np.array([-CODE_MAX, CODE_MAX])
        channels["voltage"] = ReferenceCurve(ends, np.full(2, VOLTS), np.zeros(2), level=True)
    return ThrusterAtRest("tug", ("stern",), CODE_MAX, channels, False, 0.01, "a formula")


def points(
    code: FloatArray, thrust_n: FloatArray, volts: float | None = None, *, seed: int = 0
) -> list[MooringPoint]:
    """Readings with 0.05 N of scatter."""
    rng = np.random.default_rng(seed)
    return [
        MooringPoint(
            source=Source(file="new.csv", sheet=None, row=i + 2),
            code=float(c),
            thrust_n=float(t + rng.normal(0.0, 0.05)),
            voltage_v=volts,
            sweep="up",
        )
        for i, (c, t) in enumerate(zip(code, thrust_n, strict=True))
    ]


def codes(step: float = 7.0) -> FloatArray:
    """Codes of both signs."""
    size = np.arange(step, 127.1, step)
    return np.concatenate([-size[::-1], size])


def table(thrust_n: FloatArray, volts: float | None = None, *, seed: int = 0) -> BenchTable:
    """A table at `codes()`."""
    return bench_table(
        points(codes(), thrust_n, volts, seed=seed), model(volts=volts is not None), name="new"
    )
