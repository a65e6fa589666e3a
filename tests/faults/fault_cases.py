"""What may happen to a machine while rig2sea runs, and what must hold after; used by the tests.

After every fault: the raw files are as they were, the command named the fault in one message and
without a traceback, and the next run leaves what an undisturbed one leaves.
"""

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fault_hook import renamed, run_with_hook
from synthetic_bench import Bench, make_moored, make_vehicle

_DAY_S = 86_400


def small(root: Path) -> Bench:
    """A vehicle whose run takes a few seconds: a mooring test alone."""
    make_moored(root / "raw/boat")
    return Bench(root)


def whole(root: Path) -> Bench:
    """A vehicle with every kind of bench test."""
    make_vehicle(root / "raw/boat")
    return Bench(root)


def settle(root: Path) -> None:
    """Wait until no process of a killed run is at work in a folder."""
    end = time.monotonic() + 30
    while time.monotonic() < end:
        if not at_work(root):
            return
        time.sleep(0.05)
    raise AssertionError("processes of a killed run are still at work")


def at_work(folder: Path) -> list[int]:
    """Processes whose working folder is this one."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").resolve(strict=True) == folder.resolve():
                found.append(int(process.name))
        except OSError:
            continue
    return found


def half_written(root: Path) -> list[str]:
    """Results that are not whole: JSON that cannot be read, pages without an end, left pieces."""
    bad = []
    for top in ("processed", "reports"):
        for path in sorted((root / top).rglob("*")):
            name = path.relative_to(root).as_posix()
            if not path.is_file() or ".rig2sea" in path.parts:
                continue
            if path.name.startswith("."):
                bad.append(name)
            elif path.suffix == ".json":
                try:
                    json.loads(path.read_text(encoding="utf-8"))
                except ValueError:
                    bad.append(name)
            elif path.suffix == ".html" and not path.read_text("utf-8").rstrip().endswith(
                "</html>"
            ):
                bad.append(name)
    return bad


def repaired(bench: Bench, raw: dict[str, str], clean: dict[str, str]) -> None:
    """The next run leaves what an undisturbed one leaves."""
    done = bench.run("--cores", "1")
    assert done.returncode == 0, done.stdout + done.stderr
    assert bench.raw_contents() == raw
    assert half_written(bench.root) == []
    assert bench.contents() == clean


def kill_points(make: Callable[[Path], Bench], root: Path, work: Path) -> list[str]:
    """Every file that an undisturbed run puts in its place, as points to kill it at."""
    make(root)
    assert run_with_hook(root, work) == 0
    return renamed(work)


def kill_at(make: Callable[[Path], Bench], root: Path, work: Path, point: str) -> Bench:
    """Kill a run, all of it, just before a file gets its name."""
    bench = make(root)
    code = run_with_hook(root, work, kill_at=point)
    assert code == -9, f"the run was not killed at {point}: exit code {code}"
    settle(root)
    assert not (root / point).exists() or ".snakemake" in point or ".rig2sea" in point
    return bench


def full_at(bench: Bench, largest_bytes: int) -> "subprocess.CompletedProcess[str]":
    """Run where no file may grow beyond a size, as on a disk or under a quota that is full."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest_bytes, largest_bytes))

    return subprocess.run(
        [sys.executable, "-m", "pipeline", "run", "--cores", "1"],
        cwd=bench.root,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        preexec_fn=limit,
    )


@contextmanager
def mounted(folder: Path, options: str) -> Iterator[None]:
    """A disk of its own at a folder; raises `OSError` where that is not allowed."""
    folder.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise OSError(done.stderr.strip())
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=False, capture_output=True)


def remount(folder: Path, options: str) -> None:
    """Change the disk at a folder."""
    subprocess.run(["mount", "-o", f"remount,{options}", str(folder)], check=True)


def set_clock_back(root: Path, days: float) -> None:
    """Let all files there be from the future, as after the clock was set back."""
    then = time.time() + days * _DAY_S
    for path in root.rglob("*"):
        if path.is_file():
            os.utime(path, (then, then))


def said_once(text: str, about: str) -> None:
    """The printed text names the fault and shows no traceback."""
    assert "Traceback" not in text, text
    assert "error: " in text, text
    assert about in text, text
