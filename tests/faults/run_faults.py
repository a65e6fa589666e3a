"""``python tests/faults/run_faults.py``: every fault of the machine, one after the other.

Needs a few minutes; as a superuser it also fills a real disk and makes a folder read-only.
"""

import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path

import click

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "integration")]

import fault_cases as faults  # noqa: E402 - the folders above are needed for it
from synthetic_bench import Bench  # noqa: E402


class Campaign:
    """Counts what held and what did not."""

    def __init__(self, work: Path, make: Callable[[Path], Bench]) -> None:
        self.work = work
        self.make = make
        self.failed = 0
        self.done = 0
        self.points = faults.kill_points(make, work / "clean", work / "hook")
        clean = Bench(work / "clean")
        self.clean, self.raw = clean.contents(), clean.raw_contents()

    def check(self, name: str, case: Callable[[Path], None]) -> None:
        """Run a case in a folder of its own and say how it ended."""
        root = self.work / "root"
        shutil.rmtree(root, ignore_errors=True)
        root.mkdir()
        started = time.monotonic()
        try:
            case(root)
            end = "held"
        except OSError as error:
            end = f"not tried: {error}"
        except Exception as error:  # noqa: BLE001 - the others are tried all the same
            self.failed += 1
            end = f"FAILED: {str(error)[:2000] or traceback.format_exc()}"
        self.done += not end.startswith("not tried")
        print(f"{name}: {end} ({time.monotonic() - started:.0f} s)", flush=True)

    def killed(self, point: str, root: Path) -> None:
        bench = faults.kill_at(self.make, root, self.work / "hook", point)
        faults.repaired(bench, self.raw, self.clean)

    def limited(self, size: int, root: Path) -> None:
        bench = self.make(root)
        done = faults.full_at(bench, size)
        if done.returncode == 0:
            assert bench.contents() == self.clean
            return
        faults.said_once(done.stdout + done.stderr, "")
        faults.repaired(bench, self.raw, self.clean)

    def full_disk(self, size: str, root: Path) -> None:
        with faults.mounted(root, f"size={size}"):
            bench = self.make(root)
            done = bench.run("--cores", "1")
            if done.returncode == 0:
                assert bench.contents() == self.clean
                return
            faults.said_once(done.stdout + done.stderr, "")
            faults.remount(root, "size=100m")
            faults.repaired(bench, self.raw, self.clean)

    def read_only(self, root: Path) -> None:
        bench = self.make(root)
        with faults.mounted(root / "reports", "ro"):
            done = bench.run("--cores", "1")
            assert done.returncode == 1
            faults.said_once(done.stdout + done.stderr, "reports: cannot be written: Read-only")
        faults.repaired(bench, self.raw, self.clean)

    def two_at_once(self, root: Path) -> None:
        bench = self.make(root)
        runs = [
            subprocess.Popen(
                [sys.executable, "-m", "pipeline", "run", "--cores", "1"],
                cwd=root,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            for _ in range(3)
        ]
        said = [(run.communicate(timeout=300)[0], run.returncode) for run in runs]
        assert sorted(code for _, code in said) == [0, 1, 1], said
        assert all("another rig2sea is at work" in text for text, code in said if code)
        assert bench.contents() == self.clean

    def clock_back(self, root: Path) -> None:
        bench = self.make(root)
        assert bench.run("--cores", "1").returncode == 0
        faults.set_clock_back(root, 30)
        assert bench.run("--cores", "1").returncode == 0
        assert bench.contents() == self.clean
        file = root / "raw/boat/mooring/bollard.csv"
        text = file.read_text(encoding="utf-8")
        file.write_text(text + "60,9.0\n", encoding="utf-8")
        assert bench.run("--cores", "1").returncode == 0
        assert bench.contents() != self.clean
        file.write_text(text, encoding="utf-8")
        faults.repaired(bench, self.raw, self.clean)


@click.command()
@click.option("--all-tests/--mooring-alone", default=False, help="The vehicle's bench tests.")
@click.option("--only", default="", help="Cases whose name holds this text.")
def main(all_tests: bool, only: str) -> None:
    """Try every fault; exit code 1 when anything was lost or believed half-written."""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        campaign = Campaign(Path(folder), faults.whole if all_tests else faults.small)
        cases: dict[str, Callable[[Path], None]] = {
            f"killed before {point} has its name": partial(campaign.killed, point)
            for point in campaign.points
        }
        sizes = (1_000, 4_000, 20_000, 60_000, 150_000, 400_000)
        cases |= {f"no file above {n} bytes": partial(campaign.limited, n) for n in sizes}
        cases |= {
            f"a disk of {size}": partial(campaign.full_disk, size)
            for size in ("64k", "128k", "256k", "512k", "1m", "2m")
        }
        cases["reports/ is read-only"] = campaign.read_only
        cases["three runs at once"] = campaign.two_at_once
        cases["the clock was set back"] = campaign.clock_back
        for name, case in cases.items():
            if only in name:
                campaign.check(name, case)
        print(f"{campaign.done} cases, {campaign.failed} failed")
        sys.exit(1 if campaign.failed else 0)


if __name__ == "__main__":
    main()
