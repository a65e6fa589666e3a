"""The workflow run on a synthetic bench."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from synthetic_bench import Bench, make_vehicle


@pytest.fixture(scope="session")
def _finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """One complete run; what it printed beside it."""
    root = tmp_path_factory.mktemp("bench")
    make_vehicle(root / "raw/boat")
    done = Bench(root).run()
    assert done.returncode == 0, done.stdout + done.stderr
    return root, done.stdout


@pytest.fixture
def finished(_finished: tuple[Path, str], tmp_path: Path) -> Bench:
    """A bench on which everything is up to date; a copy, to be spoilt freely."""
    root = tmp_path / "finished"
    shutil.copytree(_finished[0], root)
    return Bench(root)


@pytest.fixture
def printed(_finished: tuple[Path, str]) -> str:
    """What the complete run printed."""
    return _finished[1]


@pytest.fixture
def fresh(_finished: tuple[Path, str], tmp_path: Path) -> Bench:
    """A bench with the same raw files on which nothing was run."""
    shutil.copytree(_finished[0] / "raw", tmp_path / "fresh/raw")
    return Bench(tmp_path / "fresh")


@pytest.fixture
def age() -> Callable[[Path], None]:
    """Give a file a time long ago, as an unpacked archive or a clock set back does."""

    def set_back(path: Path) -> None:
        os.utime(path, (946684800, 946684800))

    return set_back
