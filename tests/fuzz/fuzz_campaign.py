"""Coverage-guided search for files that a reader cannot stand; a module of the tests.

Each file is read by a process of its own kind that may die of it. Files that reach lines of the
readers that none before them reached are kept, and damaged further.
"""

import contextlib
import hashlib
import importlib
import multiprocessing
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from types import FrameType
from typing import Any

import fuzz_damage as damage
from fuzz_targets import TARGETS, Target, fault

import pipeline

CORPUS = Path(__file__).parent / "corpus"
LARGEST = 20_000
"""A file of the corpus has at most so many bytes."""
_IMPORTED_LATE = ("python_calamine", "ruamel.yaml", "zstandard", "lz4.frame", "scipy.optimize")
_QUEUE = 400
_WATCHED_ONE_IN = 4
"""Watching makes a reader some four times slower, so most files are read without."""
_WATCHED = tuple(
    str(Path(pipeline.__file__).parent / room)
    for room in ("ingest", "vehicle", "records", "provenance.py")
)


@dataclass
class Finding:
    """A fault of a reader: what was raised, where, and the file that did it."""

    target: str
    what: str
    where: str
    data: bytes


@dataclass
class Tally:
    """What a campaign did with one reader."""

    tried: int = 0
    kept: int = 0
    lines: int = 0
    findings: list[Finding] = field(default_factory=list)


class Coverage:
    """Lines of the readers that were reached, by a trace function: slow, exact, no dependency."""

    def __init__(self) -> None:
        self.seen: set[tuple[str, int]] = set()
        self._now: set[tuple[str, int]] = set()

    @contextmanager
    def watching(self) -> Iterator[None]:
        self._now = set()
        before = sys.gettrace()
        sys.settrace(self._call)
        try:
            yield
        finally:
            sys.settrace(before)

    def take(self) -> bool:
        """Tell whether the last file reached something new."""
        new = not self._now <= self.seen
        self.seen |= self._now
        return new

    def _call(self, frame: FrameType, _event: str, _argument: object) -> Any:  # noqa: ANN401
        return self._line if frame.f_code.co_filename.startswith(_WATCHED) else None

    def _line(self, frame: FrameType, _event: str, _argument: object) -> Any:  # noqa: ANN401
        self._now.add((frame.f_code.co_filename, frame.f_lineno))
        return self._line


def corpus(name: str) -> list[Path]:
    """The kept files of a reader."""
    return sorted(path for path in (CORPUS / name).glob("*") if path.is_file())


def search(name: str, seconds: float, seed: int) -> Tally:
    """Look for faults of one reader for some time; a process that dies is a fault too."""
    tally = Tally()
    end = time.monotonic() + seconds
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    known: set[str] = set()
    for module in _IMPORTED_LATE:
        importlib.import_module(module)  # once, not by every process, and outside of its limits
    try:
        while (left := end - time.monotonic()) > 0:
            context = multiprocessing.get_context("fork")
            receiving, sending = context.Pipe(duplex=False)
            worker = context.Process(target=_work, args=(name, left, seed, folder, sending, known))
            worker.start()
            sending.close()
            seed += 1
            try:
                part: Tally = receiving.recv()
            except EOFError:  # it died
                part = Tally()
                data = (folder / f"input{TARGETS[name].suffix}").read_bytes()
                worker.join()
                code = -(worker.exitcode or 0)
                what = f"killed by {signal.Signals(code).name}" if code > 0 else "it ended"
                part.findings.append(Finding(name, what, "", data))
            worker.join()
            tally.tried += part.tried
            tally.kept += part.kept
            tally.lines = max(tally.lines, part.lines)
            tally.findings += part.findings
            known |= {one.what + one.where for one in part.findings}
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return tally


def _work(  # noqa: PLR0917 - what a process is given
    name: str,
    seconds: float,
    seed: int,
    folder: Path,
    sending: Any,  # noqa: ANN401 - a connection
    known: set[str],
) -> None:
    warnings.simplefilter("error")
    target = TARGETS[name]
    chance = Random(f"{name} {seed}")  # noqa: S311 - not for secrets
    coverage = Coverage()
    tally = Tally()
    queue = [path.read_bytes() for path in corpus(name)]
    end = time.monotonic() + seconds
    for data in _files(target, queue, chance):
        if time.monotonic() > end:
            break
        tally.tried += 1
        watched = tally.tried <= len(queue) or tally.tried % _WATCHED_ONE_IN == 0
        with coverage.watching() if watched else contextlib.nullcontext():
            error = fault(target, data, folder)
        if watched and coverage.take() and len(data) <= 10 * LARGEST:
            queue.append(data)
            tally.kept += 1
            del queue[: len(queue) - _QUEUE]
        if error is not None:
            finding = Finding(name, _shown(error), _where(error), data)
            if finding.what + finding.where not in known:
                known.add(finding.what + finding.where)
                tally.findings.append(finding)
    tally.lines = len(coverage.seen)
    sending.send(tally)


def _files(target: Target, queue: list[bytes], chance: Random) -> Iterator[bytes]:
    """The kept files as they are, then fresh ones and damaged kept ones in turn."""
    yield from list(queue)
    while True:
        if queue and chance.random() < 0.4:
            yield damage.anywhere(chance.choice(queue), chance)
        else:
            yield target.make(chance)


def _shown(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"[:200]


def _where(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    own = [one for one in frames if one.filename.startswith(str(Path(pipeline.__file__).parent))]
    return " < ".join(f"{Path(one.filename).name}:{one.lineno}" for one in reversed(own[-3:]))


def keep(finding: Finding, folder: Path = CORPUS) -> Path | None:
    """Add a file to the corpus, if it is small enough; named by its digest."""
    if len(finding.data) > LARGEST:
        return None
    digest = hashlib.sha256(finding.data).hexdigest()[:12]
    path = folder / finding.target / f"{digest}{TARGETS[finding.target].suffix}"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(finding.data)
    return path
