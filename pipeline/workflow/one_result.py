"""One stage's result of one vehicle, made anew where it is stale; what ``run --only`` would be."""

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Generic, TypeVar

from pipeline.errors import CannotComputeError, InputError, Problem
from pipeline.plan import TITLES, choose, processed_file
from pipeline.provenance import Envelope, read_envelope
from pipeline.records.base import Record
from pipeline.workflow.outcome import refused_behind
from pipeline.workflow.progress import Progress
from pipeline.workflow.run import RunRequest, run
from pipeline.workflow.summary import failure_line

R = TypeVar("R", bound=Record)


@dataclass(frozen=True)
class OneResult(Generic[R]):
    """The result, the file it was read from, and the errors of raw files it had to do without."""

    vehicle: str
    file: Path
    envelope: Envelope[R]
    refused: tuple[Problem, ...]


def one_result(request: RunRequest, stage: str, model: type[R]) -> OneResult[R]:
    """Bring one stage's result up to date and read it; progress goes to standard error.

    Parameters
    ----------
    request : RunRequest
        With exactly one vehicle.
    stage : str
        A stage that writes an envelope.
    model : type of Record
        What the envelope holds.

    Raises
    ------
    UsageError
        When there is no such vehicle.
    InputError, CannotComputeError
        When the vehicle cannot be read, or a stage failed; the text says why.
    """
    result = run(replace(request, only=(stage,)), Progress(sys.stderr))
    for problem in result.refused:
        raise InputError(problem)
    name = result.vehicles[0]  # behind it come its further types of thruster
    if result.failed:
        raise CannotComputeError(failure_line(result.failed[0]))
    file = request.out / processed_file(name, stage)
    if not result.complete and not file.is_file():
        raise CannotComputeError(f"{name}: the run did not come to this: {TITLES[stage]}.")
    envelope = read_envelope(file, stage, model)
    (vehicle,), _ = choose(request.vehicles, request.raw, request.out)
    return OneResult(name, file, envelope, refused_behind(vehicle, stage, request.out))
