"""Run the real command for the tests, and share what is slow between test processes."""

import fcntl
import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

_DONE = ".done"


def rig2sea(folder: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run the command in a folder and wait for its end."""
    return subprocess.run(
        [sys.executable, "-m", "pipeline", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=900,
    )


def digests(folder: Path) -> dict[str, str]:
    """Digest of every file under a folder."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def once(factory: pytest.TempPathFactory, name: str, build: Callable[[Path], None]) -> Path:
    """Build a folder once, however many test processes want it.

    Parameters
    ----------
    factory : pytest.TempPathFactory
        Gives the place; with several test processes they share one.
    name : str
        Name of the folder.
    build : callable
        Is given the empty folder and fills it.
    """
    base = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        base = base.parent
    folder = base / name
    with (base / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (base / f"{name}{_DONE}").exists():
            folder.mkdir()
            build(folder)
            (base / f"{name}{_DONE}").touch()
    return folder
