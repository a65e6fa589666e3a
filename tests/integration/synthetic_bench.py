"""A synthetic bench: one small vehicle with every kind of raw file, and the workflow run on it."""

import hashlib
import json
import math
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import openpyxl
import pytest
from shared_runs import once

VEHICLE = """\
name: boat
title: a boat that exists on paper only
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {screw: {diameter_m: 0.14}}
drives: {drive: {code_min: -127, code_max: 127}}
thrusters:
  - {name: upper, propeller: screw, drive: drive, position_m: [-0.9, 0, 0], direction: [0.92388, 0, -0.38268]}
  - {name: lower, propeller: screw, drive: drive, position_m: [-0.9, 0, 0], direction: [0.92388, 0, 0.38268]}
  - {name: left, propeller: screw, drive: drive, position_m: [-0.9, 0, 0], direction: [0.92388, -0.38268, 0]}
  - {name: right, propeller: screw, drive: drive, position_m: [-0.9, 0, 0], direction: [0.92388, 0.38268, 0]}
allocator:
  {delta_deg: 22.5, stern_arm_m: 0.9, upper: upper, lower: lower, left: left, right: right,
   portions: {surge: 0.7, heading: 0.3, pitch: 0.3}}
tables: {propeller: screw, drive: drive}
"""  # noqa: E501 - one thruster a line reads best
#: K_T(J) and K_M(J) of the screw, and M(n, N) = M_0 N / 127 - b n of the drive.
KT, KM = (0.139, -0.155, -0.061), (0.0171, -0.0164, -0.0055)
TORQUE_AT_REST_NM, TORQUE_PER_RPS_NM = 1.6, 0.03


def polynomial(coefficients: tuple[float, ...], x: float) -> float:
    return sum(c * x**i for i, c in enumerate(coefficients))


def ripple(i: int) -> float:
    """Stand for noise: the same on every machine, and of mean about zero."""
    return ((i * 37) % 19 - 9) / 9


def write_open_water(path: Path, scale: float = 1.0) -> None:
    lines = ["J,KT,KM"]
    for i in range(31):
        j = i * 0.02
        thrust = scale * polynomial(KT, j) + 2e-4 * ripple(i)
        lines.append(f"{j:.3f},{thrust:.6f},{polynomial(KM, j) + 2e-5 * ripple(i + 7):.7f}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_load_test(path: Path) -> None:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for code in (20, 40, 60, 80, 100, 120, 127):
        sheet = book.create_sheet(f"Code {code}")
        sheet.append(["Speed (rpm)", "Torque (N m)", "Current (A)", "Voltage (V)"])
        stall = TORQUE_AT_REST_NM * code / 127
        loads = [*range(2, 11), *range(10, 1, -1)]
        for i, tenths in enumerate(loads):
            torque = stall * tenths / 12
            speed_rps = (stall - torque) / TORQUE_PER_RPS_NM
            current = round(0.5 + 1.3 * torque * speed_rps * 2 * math.pi / 48.0, 3)
            reading = torque * (1 + 0.003 * ripple(i + code))
            sheet.append([round(speed_rps * 60, 1), round(reading, 5), current, 48.0])
    book.save(path)


def write_mooring(path: Path) -> None:
    codes = [*range(0, 121, 10), 127]
    sweep = [*codes, *reversed(codes), *(-c for c in codes), *(-c for c in reversed(codes))]
    lines = ["code,thrust (N)"]
    for i, code in enumerate(sweep):
        thrust = 0.0 if abs(code) < 20 else code * abs(code) * 0.0022 + 0.05 * ripple(i)
        lines.append(f"{code},{thrust:.3f}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def make_vehicle(folder: Path) -> None:
    """Write a vehicle folder with one raw file of each kind."""
    for kind in ("load_test", "mooring", "open_water"):
        (folder / kind).mkdir(parents=True)
    (folder / "vehicle.yaml").write_text(VEHICLE, encoding="utf-8")
    write_open_water(folder / "open_water/screw.csv")
    write_load_test(folder / "load_test/drive 1.xlsx")
    write_mooring(folder / "mooring/bollard.csv")


def make_moored(folder: Path) -> None:
    """Write a vehicle folder with a mooring test alone: every stage runs, and none for long."""
    make_vehicle(folder)
    for kind in ("load_test", "open_water"):
        shutil.rmtree(folder / kind)


@dataclass(frozen=True)
class Bench:
    """A working folder with ``raw/`` in which the workflow is run."""

    root: Path

    def run(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        """Run ``rig2sea run`` here and wait for its end."""
        return subprocess.run(
            [sys.executable, "-m", "pipeline", "run", *arguments],
            cwd=self.root,
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )

    def stages_run(self) -> list[tuple[str, str]]:
        """Return (vehicle, stage) of every stage that the last run finished, sorted."""
        journal = self.root / "processed/.rig2sea/journal.jsonl"
        lines = journal.read_text().splitlines() if journal.exists() else []
        events = [json.loads(line) for line in lines]
        return sorted((e["vehicle"], e["stage"]) for e in events if e["what"] == "done")

    def results(self) -> dict[str, tuple[int, str]]:
        """Return time and digest of every result."""
        return {
            path.relative_to(self.root).as_posix(): (path.stat().st_mtime_ns, digest(path))
            for top in ("processed", "reports")
            for path in sorted((self.root / top).rglob("*"))
            if path.is_file() and ".rig2sea" not in path.parts and "logs" not in path.parts
        }

    def contents(self) -> dict[str, str]:
        """Return the digest of every result."""
        return {name: content for name, (_, content) in self.results().items()}

    def raw_contents(self) -> dict[str, str]:
        """Return the digest of every raw file."""
        return {
            path.relative_to(self.root).as_posix(): digest(path)
            for path in sorted((self.root / "raw").rglob("*"))
            if path.is_file()
        }

    def envelope(self, stage: str, vehicle: str = "boat") -> dict[str, object]:
        """Read a processed file."""
        path = self.root / "processed" / vehicle / f"{stage}.json"
        body: dict[str, object] = json.loads(path.read_text(encoding="utf-8"))
        return body


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def run_bench(
    factory: pytest.TempPathFactory, name: str, make: Callable[[Path], None]
) -> tuple[Path, str]:
    """Run the workflow on a vehicle once for all tests; return the bench and what was printed."""

    def build(folder: Path) -> None:
        make(folder / "bench/raw/boat")
        done = Bench(folder / "bench").run()
        assert done.returncode == 0, done.stdout + done.stderr
        (folder / "printed.txt").write_text(done.stdout, encoding="utf-8")

    folder = once(factory, name, build)
    return folder / "bench", (folder / "printed.txt").read_text(encoding="utf-8")


def moored_bench(factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Run the workflow once on a mooring test alone."""
    return run_bench(factory, "moored", make_moored)
