"""When the best answer is none: too much is left of the force, or of the held-out gap."""

from dataclasses import replace

from pipeline.diagnose.answer import NONE, UNKNOWN, Answers
from pipeline.diagnose.calibration import Calibration
from pipeline.records.diagnosis import Leftover, Shrink


def leaves_too_much(
    found: Answers,
    left: Leftover,
    closed: Shrink,
    limits: Calibration,
    *,
    healthy_known: bool,
) -> Answers:
    """Put `unknown` first where the best answer leaves what no healthy vehicle does.

    The outside force that an answer leaves is compared with that of a healthy vehicle, axis by
    axis; a fault that starts in mid-run or comes and goes leaves much of it at some times. An
    effect must also shrink the held-out gap: one that makes it worse explains nothing.
    """
    top = found.ranking[0]
    if top.name == UNKNOWN:
        return found
    most = limits.most_force_healthy if healthy_known else limits.most_force
    force = max(left.axes.values(), default=0.0)
    too_much = force > most
    if top.name != NONE and closed.before > limits.most_gap:
        explained = closed.gap_closed if closed.gap_closed is not None else 0.0
        too_much = too_much or (closed.after > limits.most_gap and explained < 0.5)
    if not too_much:
        return found
    known = found.of(UNKNOWN)
    # what the evidence says within the library still counts, among what is left
    share = min(force / most, 10.0) / (1.0 + min(force / most, 10.0))
    rest = 1.0 - max(share, 0.5)
    candidate = replace(
        known if known is not None else top,
        name=UNKNOWN,
        probability=1.0 - rest,
        finding=None,
    )
    others = tuple(
        replace(one, probability=one.probability * rest)
        for one in found.ranking
        if one.name != UNKNOWN
    )
    return replace(found, ranking=(candidate, *others))
