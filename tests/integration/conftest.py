"""The workflow run on a synthetic bench."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from bundled_bench import bench_of_mmt300
from headless_browser import find_browser
from shared_runs import once
from synthetic_bench import Bench, make_vehicle, moored_bench, run_bench


@pytest.fixture(scope="session")
def _finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """One complete run; what it printed beside it."""
    return run_bench(tmp_path_factory, "finished", make_vehicle)


@pytest.fixture
def finished(_finished: tuple[Path, str], tmp_path: Path) -> Bench:
    """A bench on which everything is up to date; a copy, to be spoilt freely."""
    root = tmp_path / "finished"
    shutil.copytree(_finished[0], root)
    return Bench(root)


@pytest.fixture(scope="session")
def _moored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """One complete run of a mooring test alone; what it printed beside it."""
    return moored_bench(tmp_path_factory)


@pytest.fixture
def moored(_moored: tuple[Path, str], tmp_path: Path) -> Bench:
    """A bench with a mooring test alone, up to date; a copy, to be spoilt freely."""
    root = tmp_path / "moored"
    shutil.copytree(_moored[0], root)
    return Bench(root)


@pytest.fixture
def moored_printed(_moored: tuple[Path, str]) -> str:
    """What its complete run printed."""
    return _moored[1]


@pytest.fixture
def fresh_moored(_moored: tuple[Path, str], tmp_path: Path) -> Bench:
    """A bench with a mooring test alone on which nothing was run."""
    shutil.copytree(_moored[0] / "raw", tmp_path / "fresh_moored/raw")
    return Bench(tmp_path / "fresh_moored")


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


@pytest.fixture(scope="session")
def bench_folder(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which mmt300 was run without its pool runs; not to be changed."""
    return bench_of_mmt300(repository, tmp_path_factory)


@pytest.fixture(scope="session")
def browser() -> str:
    """The browser of this machine."""
    found = find_browser()
    if found is None:
        pytest.skip("no chromium on this machine: the report was not looked at in a browser")
    return found


@pytest.fixture(scope="session")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A page of every kind, from small records."""
    from report_site import PLACES, write_site

    reports = once(tmp_path_factory, "report_site", write_site)
    return {kind: reports / place for kind, place in PLACES.items()}
