"""A file that is there complete, or not at all."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Give a stream whose content takes the place of a file at the end; its folder is made.

    Raises OSError where the place cannot be written; the file of before is there then.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    # a name of its own: stages that run side by side may all write it
    beside = path.with_name(f".{path.name[:40]}.{secrets.token_hex(8)}.part")
    try:
        with beside.open("wb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
