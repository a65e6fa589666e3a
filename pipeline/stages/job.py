"""What a stage is given, how it reads the results before it, and how it leaves its own."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

from pipeline.errors import CannotComputeError, InputError, Place, Problem, is_of_the_machine
from pipeline.inputs.no_solution import with_reason
from pipeline.plan import MISSING, TITLES, VEHICLE_FILE, VehicleFolder, typed_name
from pipeline.provenance import Envelope, file_digest, read_envelope, read_tables, write_envelope
from pipeline.records.base import Record
from pipeline.records.measurements import LoadTestRecord, MooringRecord, OpenWaterRecord
from pipeline.stage_table import STAGES
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

R = TypeVar("R", bound=Record)
RawRecord = LoadTestRecord | MooringRecord | OpenWaterRecord


class FirmwareFiles(Record):
    """Receipt of a vehicle's firmware sources: their digests, by path from the output folder."""

    files: dict[str, str]
    notes: tuple[str, ...] = ()
    """What the files had to do without."""


class NotMeasuredError(CannotComputeError):
    """What the stage starts from is not there: nothing is wrong, there is just nothing to do."""


@dataclass(frozen=True)
class Job:
    """One stage of one vehicle: all it may read and the files that it writes.

    `inputs` are the vehicle file, raw files and processed files, each relative to the working
    folder (the output folder) or absolute.
    """

    stage: str
    vehicle_name: str
    code: str
    inputs: tuple[Path, ...]
    output: Path
    more_outputs: tuple[Path, ...] = ()

    @property
    def vehicle_file(self) -> Path:
        """The path of ``vehicle.yaml``."""
        return next(path for path in self.inputs if path.name == VEHICLE_FILE)

    @property
    def folder(self) -> VehicleFolder:
        """The vehicle's folder, or what stands for a further type of thruster in it."""
        path = self.vehicle_file.parent
        main = Path(os.path.normpath(path.absolute())).name
        typed = self.vehicle_name.startswith(f"{main}-")
        of_type = self.vehicle_name.removeprefix(f"{main}-") if typed else ""
        return VehicleFolder(self.vehicle_name, str(path), of_type)

    @property
    def raw_root(self) -> Path:
        """The folder that the vehicle's folder lies in."""
        return self.vehicle_file.parent.parent

    def beside(self, ending: str) -> Path:
        """Return the file of another kind that lies beside the result, under its name."""
        return self.output.with_suffix(ending)

    def measured(self, read: Callable[[Sequence[Path], Vehicle, Path], RawRecord]) -> RawRecord:
        """Read the raw files of this stage's kind; the record names those that were refused.

        Raises `NotMeasuredError` when there are none, not even one that was not read for its name.
        """
        room = self.vehicle_file.parent / self.stage / self.folder.thruster_type
        files = tuple(path for path in self.inputs if path.parent == room)
        shown = room.relative_to(self.raw_root).as_posix()
        misnamed: tuple[Problem, ...] = self.folder.misnamed_problems(self.stage, shown)
        if not files and not misnamed:
            called = self.stage.replace("_", "-")
            raise NotMeasuredError(f"There are no {called} files in {room.as_posix()}.")
        record = read(files, self.vehicle(), self.raw_root)
        return record.model_copy(update={"problems": (*misnamed, *record.problems)})

    def vehicle(self) -> Vehicle:
        """Read the vehicle file; for a further type of thruster what its bench needs of it."""
        return load_vehicle(self.vehicle_file).of_type(self.folder.thruster_type)

    def envelope(self, kind: str, model: type[R]) -> Envelope[R]:
        """Read the result of an earlier stage, which may be the reason why there is none."""
        return read_envelope(self._result(f"{kind}.json"), kind, model)

    def _result(self, name: str) -> Path:
        """Return the path of a result: this vehicle's own, where there are several."""
        found = [path for path in self.inputs if path.name == name]
        return next((path for path in found if path.parent.name == self.vehicle_name), found[0])

    def of_type(self, thruster_type: str) -> "Job":
        """Return this job as one of a further type of thruster, whose results are read then."""
        return replace(self, vehicle_name=typed_name(self.vehicle_name, thruster_type))

    def record(self, kind: str, model: type[R]) -> R | None:
        """Return the record of an earlier stage, None when it left none."""
        return self.envelope(kind, model).record

    def needed(self, kind: str, model: type[R]) -> R:
        """Return the record of an earlier stage.

        Raises `NotMeasuredError` when it left none; the text passes its reason on.
        """
        return self._whole(kind, self.envelope(kind, model))

    def needed_at(self, ending: str, kind: str, model: type[R]) -> R:
        """Return the record of the input whose path has this ending; raises as `needed`."""
        path = next(path for path in self.inputs if path.as_posix().endswith(f"/{ending}"))
        return self._whole(kind, read_envelope(path, kind, model))

    def all_of(self, kind: str, model: type[R]) -> tuple[tuple[str, Envelope[R]], ...]:
        """Return name and envelope of every input that a stage of runs or days has left."""
        return tuple(
            (path.stem, read_envelope(path, kind, model))
            for path in self.inputs
            if path.parent.name == STAGES[kind].room and path.suffix == ".json"
        )

    @staticmethod
    def _whole(kind: str, envelope: Envelope[R]) -> R:
        if envelope.record is None:
            reason = envelope.why_not or "no reason was given."
            if reason.startswith(MISSING):
                raise NotMeasuredError(reason)  # the first gap explains all that follow
            raise NotMeasuredError(f"There is no {TITLES[kind]}: {_lower(reason)}")
        return envelope.record

    def tables(self) -> dict[str, Any]:
        """Read ``tables.json``."""
        return read_tables(self._result("tables.json"))

    def input_digests(self) -> dict[str, str]:
        """Return the digest of every input under a name that holds on every machine."""
        folder = self.vehicle_file.parent
        return {
            f"{self.folder.digest_prefix}{path.relative_to(folder).as_posix()}"
            if path.is_relative_to(folder)
            else self._result_name(path): file_digest(path)
            for path in self.inputs
        }

    def _result_name(self, path: Path) -> str:
        """Name a result from the output folder; a copy fetched from a storage is named as it."""
        for name in (self.vehicle_name, path.parent.name):
            room = f"processed/{name}/"
            _, found, rest = path.as_posix().rpartition(room)
            if found:
                return f"{room}{rest}"
        return path.as_posix()


def leave_record(job: Job, compute: Callable[[], Record], *, failure_is_error: bool = False) -> str:
    """Compute a record and write its envelope; without a record, write the reason and return it.

    `failure_is_error`: inputs that are complete and give no result contradict each other, and the
    run ends with exit code 1.

    Raises `Rig2SeaError` when the disk is full, broken or read-only: that is no result.
    """
    record: Record | None = None
    why_not: str | None = None
    problems: tuple[Problem, ...] = ()
    digests = job.input_digests()
    try:
        with with_reason(TITLES.get(job.stage, job.stage)):
            record = compute()
    except (CannotComputeError, InputError) as error:
        if is_of_the_machine(error) and not isinstance(error, NotMeasuredError):
            raise
        why_not = str(error)
        if isinstance(error, InputError):
            problems = (error.problem,)
        elif failure_is_error and not isinstance(error, NotMeasuredError):
            place = Place(f"{job.vehicle_name}, {TITLES[job.stage]}")
            problems = (place.error(why_not),)
    made = Envelope[Record](
        job.stage, job.vehicle_name, digests, job.code, record, why_not, problems
    )
    write_envelope(job.output, made)
    return "" if why_not is None else f"left out. {why_not}"


def leaves_record(compute: Callable[[Job], Record | tuple[Record, str]]) -> Callable[[Job], str]:
    """Make a stage of what computes its record, or record and what is told; see `leave_record`."""

    @wraps(compute)
    def run(job: Job) -> str:
        told = ""

        def record() -> Record:
            nonlocal told
            found = compute(job)
            if isinstance(found, tuple):
                found, told = found
            return found

        return leave_record(job, record) or told

    return run


def _lower(text: str) -> str:
    """Let a sentence go on after a colon, without touching names such as K_T."""
    return text[:1].lower() + text[1:] if text[1:2].islower() or text[1:2] == " " else text
