"""Events of a run that nobody wrote down: a module let go or taken up, or a force that sets in."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.events.force_step import (
    ForceStep,
    OutsideForce,
    force_step,
    outside_force,
)
from pipeline.errors import CannotComputeError
from pipeline.records.run_table import Conditions, KnownBody, KnownOfRun, RunTable
from pipeline.simulate.context import model_of
from pipeline.simulate.run_conditions import module_body
from pipeline.vehicle.attachment_schema import Payload

#: Share of a step that may be left once a module explains it: its drag is not in the file. [1]
_MOST_LEFT = 0.15
#: Events that a run may have.
_MOST = 3


@dataclass(frozen=True)
class ForceEvent:
    """What happened in a run at the time of a step; `body` was put on, or taken off, if any was.

    `body` is None where no module of the vehicle file explains the step; `left` is the share of the
    step that it leaves.
    """

    run: str
    seen: OutsideForce
    step: ForceStep
    body: KnownBody | None = None
    left: float = 0.0

    @property
    def released(self) -> bool:
        """Whether a module was let go."""
        return self.body is not None and self.body.mass_kg < 0.0


def with_events(case: Case) -> tuple[Case, tuple[ForceEvent, ...]]:
    """Find the events of all runs that are asked, and let the runs know of them."""
    found: list[ForceEvent] = []
    runs, holdout = (
        tuple(_with_events(case, run, found) for run in group)
        for group in (case.runs, case.holdout)
    )
    return replace(case, runs=runs, holdout=holdout), tuple(found)


def _with_events(case: Case, run: RunTable, found: list[ForceEvent]) -> RunTable:
    for _ in range(_MOST):
        try:
            seen = outside_force(case.packed, run, case.vehicle.sensors)
        except CannotComputeError:
            return run
        step = force_step(seen)
        if step is None:
            return run
        event, run = _explained(case, run, seen, step)
        found.append(event)
    return run


def _explained(
    case: Case, run: RunTable, seen: OutsideForce, step: ForceStep
) -> tuple[ForceEvent, RunTable]:
    """Take the module that explains a step, or the force itself where none does."""
    after, axes = seen.begin_s >= step.at_s, list(seen.axes)
    std = np.maximum(step.std[axes], 1e-9)
    size, least = float(np.linalg.norm(step.force[axes] / std)), _MOST_LEFT
    free = _known_from(run, step.at_s, lambda now: now)
    force = np.zeros((run.time_s.size, 6)) if free.force is None else free.force.copy()
    force[run.time_s >= step.at_s] += step.force
    best = ForceEvent(run.name, seen, step), replace(run, known=replace(free, force=force))
    for payload in model_of(case.vehicle).payloads:
        body = _moved(payload, run.conditions_at(step.at_s))
        try:
            told = replace(
                run,
                known=_known_from(run, step.at_s, partial(_carrying, body=body, case=case)),
            )
            left = outside_force(case.packed, told, case.vehicle.sensors).force
        except CannotComputeError:  # nothing would be left of the vehicle
            continue
        jump = left[after].mean(axis=0) - left[~after].mean(axis=0)
        rest = float(np.linalg.norm(jump / std)) / size
        if rest < least:
            least, best = rest, (ForceEvent(run.name, seen, step, body, rest), told)
    return best


def _moved(payload: Payload, now: Conditions) -> KnownBody:
    """Return a module as it can change: off where it is on board, on where it is not."""
    aboard = payload.attached
    for body in now.bodies:
        if body.name == payload.name:
            aboard = body.mass_kg > 0.0
    return module_body(payload, -1.0 if aboard else 1.0)


def _carrying(now: Conditions, body: KnownBody, case: Case) -> Conditions:
    """Put a body on; what undoes one that is there takes it away."""
    others = tuple(one for one in now.bodies if one.name != body.name)
    bodies = others if len(others) < len(now.bodies) else (*others, body)
    return replace(now, bodies=bodies, gravity_mps2=case.vehicle.water.gravity_mps2)


def _known_from(
    run: RunTable, at_s: float, change: Callable[[Conditions], Conditions]
) -> KnownOfRun:
    """Return what is known of a run with conditions that change from a time on."""
    known = run.known if run.known is not None else KnownOfRun()
    times = sorted({*known.from_s, at_s})
    return replace(
        known,
        from_s=tuple(times),
        conditions=tuple(
            change(known.at(time_s)) if time_s >= at_s else known.at(time_s) for time_s in times
        ),
    )
