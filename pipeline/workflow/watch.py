"""``rig2sea watch``: look at the raw folder again and again, and run when something whole is new.

Looking is done by listing folders, which works on network shares and removable disks where
notifications do not. What has been done is known from ``processed/``, so a restart loses nothing
and repeats nothing.
"""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

from pipeline.errors import InputError
from pipeline.ingest.log_files import bags_in, is_closed, is_log_name, log_beside, parts_of
from pipeline.plan import POOL, RAW_KINDS, VEHICLE_FILE, UsageError, VehicleFolder, choose
from pipeline.vehicle.run_notes import BAG_FILE
from pipeline.workflow.outcome import Outcome, Result, failure_line, page_lines
from pipeline.workflow.pool_runs import file_names, result_file, run_name
from pipeline.workflow.progress import Progress
from pipeline.workflow.run import RunRequest, run

#: A log whose writer did not close it is taken for whole after so many times the settling time.
UNCLOSED_FACTOR = 10.0
Mark = tuple[int, int]


@dataclass
class Watcher:
    """What was seen of the raw files, and what has been run.

    A file that stays as it is for `settle_s` [s] counts as whole. `now_s` and `do_run` stand apart
    so that a test needs neither to wait nor to run.
    """

    request: RunRequest
    settle_s: float = 3.0
    now_s: Callable[[], float] = time.monotonic
    do_run: Callable[[RunRequest, Progress], Result] = run
    _since: dict[Path, tuple[Mark, float]] = field(default_factory=dict)
    _done: dict[str, frozenset[tuple[Path, Mark]]] = field(default_factory=dict)
    _said: set[str] = field(default_factory=set)
    _faults: bool = False
    _not_begun: bool = False

    def look(self) -> list[str]:
        """Look once; run what is whole and new. Returns lines to print."""
        try:
            vehicles, problems = choose(self.request.vehicles, self.request.raw, self.request.out)
        except UsageError as error:
            # the vehicle that was named may still come
            return self._once([f"Waiting for it: {error}"])
        self._faults |= bool(problems)
        lines = self._once(f"error: {problem}" for problem in problems)
        if not vehicles and not problems:
            # the folder may be misspelt: nothing would ever come, without a word
            lines += self._once([f"Waiting: {self.request.raw} holds no vehicle yet."])
        seen = {one.name: self._files(one) for one in vehicles}
        self._remember(path for files in seen.values() for path in files)
        due, waiting = [], {}
        for one in vehicles:
            settled = frozenset(
                (path, self._since[path][0]) for path in seen[one.name] if self._is_settled(path)
            )
            unsettled = {path for path in seen[one.name] if not self._is_settled(path)}
            if self._must_wait(one, unsettled) or settled == self._done.get(one.name):
                continue
            due.append((one, settled))
            waiting[one.name] = frozenset(
                log for path in unsettled for log in _logs_of(path, seen[one.name])
            )
        if not due:
            return lines
        names = tuple(str(self.request.out / one.folder) for one, _ in due)
        try:
            result = self.do_run(
                replace(self.request, vehicles=names, waiting=waiting), Progress(quiet=True)
            )
        except (InputError, UsageError) as error:
            # another run is at work, or a folder cannot be written: it is tried again
            self._not_begun = True
            return lines + self._once([f"error: {error}"])
        self._faults |= result.code != 0
        self._not_begun = False
        for one, settled in due:
            self._done[one.name] = settled
        self._said = {text for text in self._said if not text.startswith("error: ")}
        return lines + list(page_lines(result, self.request.out)) + self._once(_errors(result))

    @property
    def failed(self) -> bool:
        """Whether a file was refused or a stage failed, or the last run could not begin."""
        return self._faults or self._not_begun

    @property
    def still_coming(self) -> list[str]:
        """Files that are still on their way."""
        return [str(path) for path in self._since if not self._is_settled(path)]

    def _files(self, vehicle: VehicleFolder) -> list[Path]:
        folder = self.request.out / vehicle.folder
        found = [folder / VEHICLE_FILE]
        for kind in (*RAW_KINDS, POOL):
            found += [folder / kind / name for name in file_names(folder / kind)]
        for bag in bags_in(folder / POOL):
            found += [bag, *parts_of(bag)]
        return sorted(found)

    def _remember(self, paths: Iterable[Path]) -> None:
        """Note since when each file is as it is now; forget those that are gone."""
        now, seen = self.now_s(), {}
        for path in paths:
            try:
                status = path.stat()
            except OSError:
                continue  # it went while we looked
            mark = (status.st_size, status.st_mtime_ns)
            known = self._since.get(path)
            seen[path] = known if known is not None and known[0] == mark else (mark, now)
        self._since = seen

    def _is_settled(self, path: Path) -> bool:
        known = self._since.get(path)
        if known is None:
            return False
        still_s = self.now_s() - known[1]
        if still_s < self.settle_s:
            return False
        if not is_log_name(path.name) or is_closed(path):
            return True
        # a log that was cut off long ago is waited for no longer: with --once it would be for ever
        return max(still_s, _age_s(path)) >= UNCLOSED_FACTOR * self.settle_s

    def _must_wait(self, vehicle: VehicleFolder, unsettled: set[Path]) -> bool:
        """Whether the vehicle cannot be run yet: a bench file comes, or a known log comes anew."""
        pool = self.request.out / vehicle.folder / POOL
        for path in unsettled:
            if pool not in path.parents:
                return True
            if is_log_name(path.name):
                name = path.name if path.parent == pool else f"{path.parent.name}/{BAG_FILE}"
                result = result_file(vehicle.name, "pool_run", run_name(name))
                if (self.request.out / result).is_file():
                    return True
        return False

    def _once(self, texts: Iterable[str]) -> list[str]:
        """Return those that were not said before."""
        new = [text for text in texts if text not in self._said]
        self._said.update(new)
        return new


def _age_s(path: Path) -> float:
    """Return since when a file is as it is, by the clocks; no program can set its entry's back."""
    try:
        status = path.stat()
    except OSError:
        return 0.0
    return time.time() - max(status.st_mtime, status.st_ctime)


def _logs_of(path: Path, files: Iterable[Path]) -> list[str]:
    """Return the log that a file belongs to: itself, or the one beside its notes."""
    if (path.parent / BAG_FILE).is_file() and path.parent.name != POOL:
        return [f"{path.parent.name}/{BAG_FILE}"]
    if is_log_name(path.name):
        return [path.name]
    log = log_beside(path, (one for one in files if one.parent == path.parent))
    return [] if log is None else [log.name]


def _errors(result: Result) -> list[str]:
    found = [f"error: {problem}" for problem in result.refused]
    outcomes: tuple[Outcome, ...] = result.outcomes
    found += [f"error: {p}" for one in outcomes for p in one.problems if p.severity == "error"]
    found += [f"error: {failure_line(event)}" for event in result.failed]
    return found + ([result.stopped] if result.stopped else [])
