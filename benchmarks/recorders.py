"""Logs of recorders against their own libraries, in one run: time of the processor.

python -m benchmarks.recorders VEHICLE LOG [LOG ...]

"library" is what pymavlink (*.BIN, *.tlog) or pyulog (*.ulg) take to read every message of the log;
"open" is the way from the file to tables of numbers, "whole" is `read_pool_run`, which also chooses
channels, aligns clocks and compares them with each other. The smallest of three rounds by turns.
"""

import argparse
import contextlib
import io
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from pymavlink import DFReader, mavutil
from pyulog import ULog

from pipeline import load_vehicle
from pipeline.ingest.log_source import open_log
from pipeline.ingest.pool_run import read_pool_run

ROUNDS = 3


def _messages(reader: Any) -> None:  # noqa: ANN401 - of pymavlink
    while reader.recv_msg() is not None:
        pass


def _bin(path: Path) -> None:
    _messages(DFReader.DFReader_binary(str(path)))


def _tlog(path: Path) -> None:
    _messages(mavutil.mavlink_connection(str(path)))


def _ulg(path: Path) -> None:
    ULog(str(path))


LIBRARIES: dict[str, Callable[[Path], None]] = {".bin": _bin, ".tlog": _tlog, ".ulg": _ulg}


def _seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        work()
    return time.process_time() - begin


def main(arguments: list[str] | None = None) -> None:
    """Measure each log and print a line of it."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.recorders")
    parser.add_argument("vehicle", help="name, folder or bundled")
    parser.add_argument("logs", nargs="+", type=Path)
    given = parser.parse_args(arguments)
    vehicle = load_vehicle(given.vehicle)
    for path in given.logs:
        library = LIBRARIES[path.suffix.lower()]
        works: tuple[Callable[[], object], ...] = (
            partial(library, path),
            partial(open_log, path, path.name),
            partial(read_pool_run, path, vehicle, path.parent),
        )
        rounds = [[_seconds(work) for work in works] for _ in range(ROUNDS)]
        parse_s, open_s, whole_s = (min(times) for times in zip(*rounds, strict=True))
        print(
            f"{path.name}: library {parse_s:.3f} s, open {open_s:.3f} s ({open_s / parse_s:.2f}), "
            f"whole {whole_s:.3f} s ({whole_s / parse_s:.2f})"
        )


if __name__ == "__main__":
    main()
