"""Run the real command once for many tests, and read what it left."""

import html
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from shared_runs import digests, once, rig2sea

FloatArray = npt.NDArray[np.float64]

_CELL = re.compile(r"<t[dh][^>]*>(.*?)</t[dh]>", re.DOTALL)
_ROW = re.compile(r"<tr[^>]*>(.*?)</tr>", re.DOTALL)


@dataclass(frozen=True)
class Finished:
    """A working folder in which ``rig2sea run`` has ended."""

    root: Path

    @cached_property
    def said(self) -> dict[str, Any]:
        """Exit code, what was printed, and the digests of the raw files before the run."""
        body: dict[str, Any] = json.loads((self.root / "said.json").read_text(encoding="utf-8"))
        return body

    def record(self, vehicle: str, stage: str) -> Any:  # noqa: ANN401 - JSON
        """Return the record of a processed file."""
        return self.envelope(vehicle, stage)["record"]

    def envelope(self, vehicle: str, stage: str) -> Any:  # noqa: ANN401 - JSON
        """Return a processed file."""
        path = self.root / "processed" / vehicle / f"{stage}.json"
        return json.loads(path.read_text(encoding="utf-8"))

    def report(self, vehicle: str) -> "Page":
        """Return a vehicle's report."""
        return Page((self.root / "reports" / vehicle / "index.html").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Page:
    """A report as a reader sees it."""

    source: str

    @cached_property
    def text(self) -> str:
        """All words, without pictures."""
        return _plain(re.sub(r"<(svg|style|script).*?</\1>", " ", self.source, flags=re.DOTALL))

    @cached_property
    def rows(self) -> tuple[tuple[str, ...], ...]:
        """Cells of every table row."""
        return tuple(
            tuple(_plain(cell) for cell in _CELL.findall(row)) for row in _ROW.findall(self.source)
        )

    def table(self, caption: str) -> tuple[tuple[str, ...], ...]:
        """Return the rows of the one table whose caption begins so."""
        tables = re.findall(r"<table.*?</table>", self.source, flags=re.DOTALL)
        (found,) = [t for t in tables if _plain(t.partition("<thead")[0]).startswith(caption)]
        return Page(found).rows

    def rows_of(self, first_cell: str) -> Iterator[tuple[str, ...]]:
        """Yield the rows that begin with a cell."""
        return (row for row in self.rows if row and row[0] == first_cell)


def _plain(markup: str) -> str:
    text = html.unescape(re.sub(r"<[^>]+>", "", markup)).replace("\N{MINUS SIGN}", "-")
    return re.sub(r"\s+", " ", text).strip()


def run_once(factory: pytest.TempPathFactory, name: str, fill: Callable[[Path], None]) -> Finished:
    """Fill a folder's ``raw/`` and run the workflow in it, once for all test processes."""

    def build(root: Path) -> None:
        (root / "raw").mkdir()
        fill(root / "raw")
        before = digests(root / "raw")
        done = rig2sea(root, "run", "--cores", "1")  # the other core has its own tests
        said = {"code": done.returncode, "out": done.stdout, "err": done.stderr, "raw": before}
        (root / "said.json").write_text(json.dumps(said), encoding="utf-8")

    return Finished(once(factory, name, build))


def firmware_code(firmware: dict[str, Any], thrust_n: FloatArray, speed_mps: float) -> FloatArray:
    """Evaluate N(T, V) of a firmware characteristic as docs/firmware.md describes it.

    Written for the tests alone, from the description: speed along the thrust (none against it),
    T_max and rows linear in speed, code linear in the fraction of T_max, zero in the dead band.
    """
    code = np.zeros_like(thrust_n)
    for sign, branch in ((1.0, firmware["positive"]), (-1.0, firmware["negative"])):
        speed = max(sign * speed_mps, 0.0)
        largest = np.interp(speed, branch["speed_mps"], branch["thrust_max_n"])
        row = [
            np.interp(speed, branch["speed_mps"], column) for column in np.array(branch["code"]).T
        ]
        mine = sign * thrust_n > firmware["thrust_dead_n"]
        code[mine] = sign * np.interp(sign * thrust_n[mine] / largest, branch["fraction"], row)
    return code


def firmware_thrust(firmware: dict[str, Any], code: FloatArray, speed_mps: float) -> FloatArray:
    """Evaluate T(N, V), the way back of `firmware_code`."""
    thrust = np.zeros_like(code)
    for sign, branch in ((1.0, firmware["positive"]), (-1.0, firmware["negative"])):
        speed = max(sign * speed_mps, 0.0)
        largest = np.interp(speed, branch["speed_mps"], branch["thrust_max_n"])
        row = [
            np.interp(speed, branch["speed_mps"], column) for column in np.array(branch["code"]).T
        ]
        mine = sign * code > 0
        thrust[mine] = sign * largest * np.interp(sign * code[mine], row, branch["fraction"])
    return thrust
