"""Every reader, and what of any file it may do: read it, or raise the project's own error.

Time and memory are bounded too: a file of a few kilobytes must not take a reader far.
"""

import contextlib
import json
import resource
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from random import Random
from types import FrameType

import fuzz_damage as damage
from bench_workbooks import vehicle as bench_vehicle
from pool_logs import rov

from pipeline.design.balance_input import BalanceInput
from pipeline.design.propeller_input import PropellerInput
from pipeline.design.tether_input import TetherInput
from pipeline.errors import Rig2SeaError
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.log_files import day_of, is_closed
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.ingest.pool_run import read_pool_run, summarize
from pipeline.provenance import read_raw_envelope, read_tables
from pipeline.vehicle.load import load_checked, load_vehicle
from pipeline.vehicle.run_notes import read_run_notes
from pipeline.workflow.known_files import KnownFiles

CPU_S = 20.0
"""Processor time that a reader may take for one small file. [s]"""
MEMORY_BYTES = 2_000_000_000
"""Address space that it may take beyond what the process has. [bytes]"""


class TooSlowError(BaseException):
    """No reader may catch it."""


@contextmanager
def bounded(cpu_s: float = CPU_S, memory_bytes: int = MEMORY_BYTES) -> Iterator[None]:
    """Run the body with so much processor time and memory, and no more."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise TooSlowError(f"more than {cpu_s} s of processor time")

    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(
        resource.RLIMIT_AS, (pages * resource.getpagesize() + memory_bytes, before[1])
    )
    handler = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, cpu_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, handler)
        resource.setrlimit(resource.RLIMIT_AS, before)


@dataclass(frozen=True)
class Target:
    """A reader: `read` is given a file, `make` makes one out of chance."""

    suffix: str
    read: Callable[[Path], object]
    make: Callable[[Random], bytes]


def _log(path: Path) -> object:
    day_of(path)
    is_closed(path)
    return summarize(read_pool_run(path, _ROV, path.parent))


def _envelope(path: Path) -> object:
    with contextlib.suppress(Rig2SeaError):
        read_tables(path)
    KnownFiles.load(path)
    return read_raw_envelope(path, "drive")


def _json(chance: Random) -> bytes:
    body = {
        "schema": "rig2sea/drive/1",
        "record": {"a": [1, 2]},
        "record_sha256": "",
        "digests": {},
    }
    text = damage.in_text(json.dumps(body), "yaml", chance)
    if chance.random() < 0.2:
        text = "[" * chance.choice((10, 100_000)) + text
    return damage.anywhere(text.encode("utf-8", errors="surrogatepass"), chance)


def _design(model: type[BalanceInput | PropellerInput | TetherInput]) -> Callable[[Path], object]:
    return lambda path: load_checked(path, model, expected="a file.", remedy="Write one.")


def _bench(reader: Callable[..., object]) -> Callable[[Path], object]:
    return lambda path: reader([path], _BENCH, path.parent)


def _any_yaml(*names: str) -> Callable[[Random], bytes]:
    return lambda chance: damage.yaml(chance.choice(names), chance)


def _workbook(kind: str) -> Callable[[Random], bytes]:
    return lambda chance: damage.workbook(kind, chance)


def _text(kind: str) -> Callable[[Random], bytes]:
    return lambda chance: damage.table_text(kind, chance)


_BENCH = bench_vehicle()
_ROV = rov(
    channels=[
        {"quantity": "shaft_speed", "topic": "/codes", "field": "data", "unit": "rpm"},
        {"quantity": "velocity", "topic": "/depth_idl", "field": "at", "unit": "m/s",
         "body_axes": "frd", "clock": "log"},
        {"quantity": "position", "topic": "/depth_idl", "field": "spread", "clock": "log",
         "earth_axes": "ned"},
        {"quantity": "pressure", "topic": "/depth_pb", "field": "depth", "unit": "bar"},
    ]
)  # fmt: skip
_READERS = {
    "load_test": read_load_tests,
    "mooring": read_mooring_tables,
    "open_water": read_open_water,
}
TARGETS: dict[str, Target] = {
    **{
        f"{kind}_xlsx": Target(".xlsx", _bench(read), _workbook(kind))
        for kind, read in _READERS.items()
    },
    **{f"{kind}_csv": Target(".csv", _bench(read), _text(kind)) for kind, read in _READERS.items()},
    "pool_log": Target(".mcap", _log, damage.log),
    "vehicle_yaml": Target(".yaml", load_vehicle, _any_yaml("vehicle", "new_vehicle", "small")),
    "notes_yaml": Target(".yaml", lambda path: read_run_notes(path, path.name), _any_yaml("notes")),
    "balance_yaml": Target(".yaml", _design(BalanceInput), _any_yaml("balance")),
    "propeller_yaml": Target(".yaml", _design(PropellerInput), _any_yaml("propeller")),
    "tether_yaml": Target(".yaml", _design(TetherInput), _any_yaml("tether")),
    "processed_json": Target(".json", _envelope, _json),
}


def fault(target: Target, data: bytes, folder: Path) -> BaseException | None:
    """Let a reader read a file; return what it must not have raised, None where all is well."""
    path = folder / f"input{target.suffix}"
    path.write_bytes(data)
    try:
        with bounded():
            target.read(path)
    except Rig2SeaError as error:
        text = str(error)
        if not text.strip() or "Traceback" in text or len(text) > 20_000:
            return error
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # noqa: BLE001 - a panic of compiled code is no Exception
        return error
    return None
