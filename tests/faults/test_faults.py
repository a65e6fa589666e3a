"""The disk is full, the clock goes back, the run is killed: the next run repairs it all.

One case, with all three in turn; ``make faults`` tries every point of a run.
"""

from pathlib import Path

import fault_cases as faults
import pytest
from fault_hook import renamed, run_with_hook
from synthetic_bench import Bench, moored_bench

POINT = "processed/boat/vehicle_page.json"


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    """What an undisturbed run leaves; other tests share it."""
    return Bench(moored_bench(tmp_path_factory)[0])


@pytest.mark.slow
def test_full_disk_then_the_clock_set_back_then_killed_and_still_repaired(
    clean: Bench, tmp_path: Path
) -> None:
    root, hook = tmp_path / "bench", tmp_path / "hook"
    bench = faults.small(root)
    done = faults.full_at(bench, 20_000)
    assert done.returncode == 1
    faults.said_once(done.stdout + done.stderr, "cannot be written: File too large")
    assert faults.half_written(root) == []
    faults.set_clock_back(root, days=30)
    # the page is in its place, and nothing says yet that it is whole
    assert run_with_hook(root, hook, kill_at=POINT) == -9
    faults.settle(root)
    put = renamed(hook)
    assert put[-1] == POINT
    assert "reports/boat/index.html" in put, "a page gets its name in one piece"
    assert (root / "reports/boat/index.html").is_file()
    assert not (root / POINT).exists()
    faults.repaired(bench, clean.raw_contents(), clean.contents())
