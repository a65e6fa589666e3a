"""mmt300 run by the real command, once for all tests: with a pool run, or the bench alone.

A module of the tests.
"""

import json
import shutil
from pathlib import Path

import pytest
from shared_runs import digests, once, rig2sea

#: What a pool run leaves, in ``processed/mmt300`` and ``reports/mmt300``.
_OF_RUNS = (
    "pool", "run_trials", "run_pages", "trial_days", "day_tables", "trial_pages", "runs", "trials",
    "run_diagnoses", "day_diagnoses",
)  # fmt: skip


def run_of_mmt300(repository: Path, factory: pytest.TempPathFactory) -> Path:
    """Run the bundled vehicle; ``said.json`` holds what was printed and the raw files' digests."""

    def build(root: Path) -> None:
        # one of its pool runs is enough
        rest = shutil.ignore_patterns("2024-05-15-*", "*-surge-*", "*-heave-*")
        shutil.copytree(repository / "raw/mmt300", root / "raw/mmt300", ignore=rest)
        before = digests(root / "raw")
        done = rig2sea(root, "run")
        said = {"code": done.returncode, "out": done.stdout, "err": done.stderr, "raw": before}
        (root / "said.json").write_text(json.dumps(said), encoding="utf-8")

    return once(factory, "bundled", build)


def bench_of_mmt300(repository: Path, factory: pytest.TempPathFactory) -> Path:
    """Return the same folder as if there had never been a pool run."""

    def build(folder: Path) -> None:
        whole = run_of_mmt300(repository, factory)
        for top in ("raw", "processed", "reports", ".snakemake"):
            shutil.copytree(whole / top, folder / top, ignore=shutil.ignore_patterns(*_OF_RUNS))
        done = rig2sea(folder, "run", "mmt300")
        assert done.returncode == 0, done.stdout + done.stderr

    return once(factory, "bundled_bench", build)
