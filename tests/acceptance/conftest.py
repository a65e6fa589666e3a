"""A measured workbook that several modules read."""

import shutil
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent


@pytest.fixture(scope="session")
def t200_workbook(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The measured mooring workbook of the T200 in a raw folder of its own."""
    found = sorted((shared_data / "t200_bollard").glob("*.xlsx"))
    if not found:
        pytest.skip(f"no T200 workbook in {shared_data}")
    folder = tmp_path_factory.mktemp("raw") / "t200"
    (folder / "mooring").mkdir(parents=True)
    shutil.copy(HERE / "t200/vehicle.yaml", folder)
    return Path(shutil.copy(found[0], folder / "mooring" / "t200.xlsx"))
