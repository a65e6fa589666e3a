"""One run at a time in a folder. The kernel ends the lock with the process that holds it."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pipeline.errors import InputError, Place
from pipeline.provenance import unwritable


@contextmanager
def only_run(path: Path) -> Iterator[None]:
    """Hold the lock file while the body runs.

    Raises
    ------
    InputError
        When another run holds it, or the place cannot be written.
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
