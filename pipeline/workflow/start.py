"""Start the engine, follow what it does, and end it when the run is stopped."""

import fcntl
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import pipeline
from pipeline.errors import InputError, Place, Rig2SeaError
from pipeline.journal import VARIABLE, Event, Reader
from pipeline.provenance import unwritable
from pipeline.reader_language import VARIABLE as LANGUAGE
from pipeline.reader_language import current
from pipeline.stopping import stopped_by_sigterm
from pipeline.workflow.progress import Progress

_POLL_S = 0.05
_PATIENCE_S = 5.0
_PATIENCE_ELSEWHERE_S = 30.0
_LOGS_KEPT = 10


class StoppedError(Rig2SeaError):
    """The user (or the system) asked to stop."""


def start(
    config: Path, out: Path, cores: int | None, progress: Progress, *, profile: Path | None = None
) -> bool:
    """Run the workflow to its end, and say whether everything was done.

    `config` is what the Snakefile is told, with logs and journal beside it; `out` the folder of
    ``processed/`` and ``reports/``. Without `cores` all are used that this process may use, without
    the folder of a `profile` the jobs are executed here. `progress` is told every event.

    Raises `StoppedError` when the run was stopped from outside; nothing is at work any more then.
    """
    journal = config.with_name("journal.jsonl")
    log = config.with_name("workflow.log")
    journal.unlink(missing_ok=True)
    forget_engine_state(out)
    arguments = [
        *("--snakefile", str(snakefile())),
        *("--directory", str(out.absolute())),
        *("--configfile", str(config.absolute())),
        *("--keep-going", "--nolock", "--nocolor"),
        # not even a profile that lies in the folder under a name that the engine looks for
        *("--workflow-profile", "none"),
    ]
    if profile is not None:
        arguments += ["--profile", str(profile)]
    if profile is None or cores is not None:
        arguments += ["--cores", str(cores or usable_cores())]
    with log.open("wb") as output:
        code = _engine(arguments, output, journal, progress, elsewhere=profile is not None)
    _prune(out / ".snakemake" / "log")
    for event in progress.running.values():
        progress.failed.append(
            Event("failed", event.vehicle, event.stage, "it ended without a word.", item=event.item)
        )
    progress.running.clear()
    if code != 0 and not progress.failed:
        progress.stopped = f"error: the workflow engine stopped: {_last_words(log)}\nIts log: {log}"
        progress.say(progress.stopped)
    return code == 0


def snakefile() -> Path:
    """Return the workflow that travels with the package."""
    path = Path(pipeline.__file__).resolve().parent / "rules" / "workflow.smk"
    if path.is_file():
        return path
    raise InputError.at(
        Place(str(path)),
        "the workflow is missing from the installation.",
        remedy="Install rig2sea again.",
    )


def _engine(
    arguments: list[str], output: IO[bytes], journal: Path, progress: Progress, *, elsewhere: bool
) -> int:
    """Start the engine in a session of its own and follow it; return its exit code.

    `elsewhere`: its jobs are at work on other machines.
    """
    reading, writing = os.pipe()
    environment = _environment(journal)
    with stopped_by_sigterm():
        engine = subprocess.Popen(  # noqa: S603 - our own module with our own arguments
            [sys.executable, "-P", "-m", "pipeline.workflow.engine", str(reading), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            env=environment,
            pass_fds=(reading,),
            start_new_session=True,
        )
        os.close(reading)
        try:
            return _follow(engine, Reader(journal), progress)
        except KeyboardInterrupt:
            _end(engine, elsewhere=elsewhere)
            progress.close()
            raise StoppedError("stopped. The next run goes on from here.") from None
        finally:
            os.close(writing)


def _environment(journal: Path) -> dict[str, str]:
    """Return the environment of the engine and its jobs.

    Nothing in the working folder is imported or obeyed, nor what another use of the engine has
    set; where the home folder cannot be written, caches go beside the journal.
    """
    kept = {name: value for name, value in os.environ.items() if not name.startswith("SNAKEMAKE")}
    stated = kept.pop("PYTHONPATH", "").split(os.pathsep)
    paths = [part for part in stated if Path(part).is_absolute()]
    if paths:
        kept["PYTHONPATH"] = os.pathsep.join(paths)
    home = Path(kept.get("HOME") or "/nonexistent")
    for variable, usual in (("XDG_CACHE_HOME", ".cache"), ("XDG_CONFIG_HOME", ".config")):
        if not _can_be_made(Path(kept.get(variable) or home / usual)):
            kept[variable] = str(journal.absolute().parent / usual.removeprefix("."))
    return {**kept, "PYTHONSAFEPATH": "1", VARIABLE: str(journal.absolute()), LANGUAGE: current()}


def _can_be_made(folder: Path) -> bool:
    """Tell whether files can be written into a folder, which is made if it is not there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def forget_engine_state(out: Path) -> None:
    """Remove all that the engine remembers but its logs.

    What is to be done is told by our own digests, and what it remembers may be damaged.
    """
    state = out / ".snakemake"
    if state.exists() and not state.is_dir():
        state.unlink(missing_ok=True)
    for room in ("metadata", "incomplete", "locks", "auxiliary", "shadow", "scripts", "storage"):
        shutil.rmtree(state / room, ignore_errors=True)


def _follow(engine: "subprocess.Popen[bytes]", reader: Reader, progress: Progress) -> int:
    while True:
        code = engine.poll()
        events = list(reader.new_events())
        for event in events:
            progress.take(event)
        if code is not None:
            progress.close()
            return code
        time.sleep(_POLL_S)


def _end(engine: "subprocess.Popen[bytes]", *, elsewhere: bool) -> None:
    # an interrupt makes the engine cancel the jobs that it has handed to a cluster
    first = ((signal.SIGINT, _PATIENCE_ELSEWHERE_S),) if elsewhere else ()
    last = ((signal.SIGTERM, _PATIENCE_S), (signal.SIGKILL, _PATIENCE_S))
    for number, patience_s in (*first, *last):
        try:
            os.killpg(engine.pid, number)
            engine.wait(patience_s)
        except ProcessLookupError:
            return
        except subprocess.TimeoutExpired:
            continue
        else:
            return


def usable_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _prune(folder: Path) -> None:
    """Keep the newest logs of the engine; it writes one a run and never removes any."""
    logs = sorted(folder.glob("*.log"), key=lambda path: path.name)
    for path in logs[:-_LOGS_KEPT]:
        path.unlink(missing_ok=True)


def _last_words(log: Path) -> str:
    lines = [line.strip() for line in log.read_text(encoding="utf-8", errors="replace").split("\n")]
    refused = [line.removeprefix("message: ") for line in lines if line.startswith("message: ")]
    if refused:  # why the cluster did not take a job
        return refused[-1]
    errors = [line for line in lines if "Error" in line or "error" in line]
    return (errors or [line for line in lines if line] or ["no reason given"])[-1]


@contextmanager
def only_run(path: Path) -> Iterator[None]:
    """Hold the lock file while the body runs.

    Raises `InputError` when another run holds it, or the place cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise unwritable(path.parent, error) from error
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            holder = os.read(descriptor, 32).decode(errors="replace").strip() or "unknown"
            raise InputError.at(
                Place(str(path.parent.parent)),
                f"another rig2sea is at work here (process {holder}).",
                remedy="Wait until it has ended, or give this one its own folder with --out.",
            ) from None
        except OSError as error:
            raise unwritable(path, error) from error
        try:
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)
        except OSError as error:  # a full disk takes the file and not what is to stand in it
            raise unwritable(path, error) from error
        yield
    finally:
        os.close(descriptor)
