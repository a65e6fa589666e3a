"""What tests of every kind share."""

import gc
import os
import sys
from pathlib import Path

import pytest
from hypothesis import settings
from quick_tests import SLOW_FIXTURES, is_quick

# The same examples every time, and no deadline: a loaded machine is no fault of the code. To look
# for new counterexamples: HYPOTHESIS_PROFILE=thorough make test
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=20)
settings.register_profile("quick", settings.get_profile("repeatable"), max_examples=10)
settings.register_profile("thorough", deadline=None, max_examples=200)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

# Messages are compared as they are written, whatever the language of whoever runs the tests.
os.environ["RIG2SEA_LANGUAGE"] = "en"

# Workbooks are compared byte by byte, whether lxml is installed or not.
os.environ.setdefault("OPENPYXL_LXML", "False")

# Where nothing may be kept, every process would compile every module anew, this one too.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Two test processes share the cores: BLAS threads beside them would only wait for each other.
for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_variable, "1")


def pytest_collection_finish() -> None:
    """Keep what collection left from being searched for garbage again and again.

    Modules and thousands of collected tests live until the end. Looking through them at every
    collection took 5.6 of the 32 s of tests/unit/report.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


REPOSITORY = Path(__file__).resolve().parent.parent


def pytest_configure(config: pytest.Config) -> None:
    """Look at fewer examples where the tests are to be quick."""
    if config.option.markexpr == "quick" and "HYPOTHESIS_PROFILE" not in os.environ:
        settings.load_profile("quick")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Do not even import what `-m quick` would leave out: that takes as long as the tests."""
    if config.option.markexpr != "quick" or collection_path.suffix != ".py":
        return None
    return True if not is_quick(collection_path, REPOSITORY) else None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark the tests that need no simulation and no diagnosis, where that is asked for."""
    if "quick" not in config.option.markexpr:
        return
    for item in items:
        slow = SLOW_FIXTURES.intersection(getattr(item, "fixturenames", ()))
        slow |= {mark.name for mark in item.iter_markers("slow")}
        if not slow and is_quick(item.path, REPOSITORY):
            item.add_marker(pytest.mark.quick)


@pytest.fixture(scope="session")
def repository() -> Path:
    """The root of the source tree."""
    return REPOSITORY


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of measured public data, which is not part of the repository."""
    stated = os.environ.get("RIG2SEA_SHARED_DATA")
    folder = Path(stated) if stated else REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"no measured data at {folder}; RIG2SEA_SHARED_DATA may name their folder")
    return folder
