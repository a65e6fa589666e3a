"""Thresholds of the answers, set from generated cases; see `calibration.json` beside this file."""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from pipeline.records.base import Record


class _File(Record):
    """The committed file: what was set, from which cases, by which command."""

    exponent: float
    none: float
    single: float
    pair: float
    set_level: float
    left_over: float
    verdict: float
    most_force: float
    most_force_healthy: float
    most_gap: float
    made_by: str
    cases: int
    seeds: str


@dataclass(frozen=True)
class Calibration:
    """What turns evidence into answers.

    Attributes
    ----------
    exponent : float
        Of the likelihood; below 1 because models are never quite right.
    none, single, pair : float
        Prior probability that nothing, one effect, two effects are at work.
    set_level : float
        Probability that the answer set must hold.
    left_over : float
        Share of the outside force needed without an effect that may be left with it.
    verdict : float
        Probability from which an answer stands alone.
    most_force, most_force_healthy : float
        Outside force (rms over that of a healthy vehicle, worst axis) that an answer may leave,
        without and with healthy runs.
    most_gap : float
        Held-out gap over the healthy floor that an answer may leave.
    """

    exponent: float
    none: float
    single: float
    pair: float
    set_level: float
    left_over: float
    verdict: float
    most_force: float
    most_force_healthy: float
    most_gap: float
    source: str


@cache
def calibration() -> Calibration:
    """Read the committed thresholds."""
    text = files("pipeline.diagnose").joinpath("calibration.json").read_text(encoding="utf-8")
    found = _File.model_validate(json.loads(text))
    return Calibration(
        found.exponent,
        found.none,
        found.single,
        found.pair,
        found.set_level,
        found.left_over,
        found.verdict,
        found.most_force,
        found.most_force_healthy,
        found.most_gap,
        f"{found.cases} generated cases, seeds {found.seeds}: {found.made_by}"
        if found.cases
        else "not yet set from generated cases: the thresholds are a first guess",
    )
