"""Thresholds of the answers, set from generated cases; see `calibration.json` beside this file."""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from pydantic import ConfigDict, TypeAdapter


@dataclass(frozen=True)
class Calibration:
    """What turns evidence into answers.

    Attributes
    ----------
    exponent : float
        Of the likelihood; below 1 because models are never quite right.
    none, single, pair : float
        Prior probability that nothing, one effect, two effects are at work.
    pair_share : float
        Share of what the best single effect explains that a second one must add: the flaws of a
        model grow with what is explained, and look like a second effect.
    held_out : float
        Weight of the log evidence of windows that took no part, where it speaks against an answer.
    set_level : float
        Probability that the answer set must hold.
    left_over : float
        Share of the outside force needed without an effect that may be left with it.
    verdict : float
        Probability from which an answer stands alone.
    most_force, most_force_healthy : float
        Outside force (rms over that of a healthy vehicle, worst axis) that an answer may leave,
        without and with healthy runs.
    most_level, most_level_healthy : float
        Level of the outside force up to which it counts as ordinary, without and with healthy runs.
    most_gap : float
        Held-out gap over the healthy floor that an answer may leave.
    least_gap : float
        Error of the worst channel over its healthy floor below which there is no gap.
    most_none_gap, most_none_gap_healthy : float
        The same, above which there is one whatever the evidence says; without and with healthy
        runs.
    interval_factor : float
        By how much the intervals are wider than the linear Gaussian model has them.
    source : str
        How they were set.
    """

    __pydantic_config__ = ConfigDict(extra="forbid", allow_inf_nan=False)

    exponent: float
    none: float
    single: float
    pair: float
    pair_share: float
    held_out: float
    set_level: float
    left_over: float
    verdict: float
    most_force: float
    most_force_healthy: float
    most_level: float
    most_level_healthy: float
    most_gap: float
    least_gap: float
    most_none_gap: float
    most_none_gap_healthy: float
    interval_factor: float
    source: str


@cache
def calibration() -> Calibration:
    """Read the committed thresholds."""
    text = files("pipeline.diagnose.rules").joinpath("calibration.json").read_text(encoding="utf-8")
    told = json.loads(text)
    made_by, cases, seeds = (told.pop(key) for key in ("made_by", "cases", "seeds"))
    source = "not yet set from generated cases: the thresholds are a first guess"
    if cases:
        source = f"{cases} generated cases, seeds {seeds}: {made_by}"
    return TypeAdapter(Calibration).validate_python({**told, "source": source})
