"""The workflow on the bundled vehicle and on measured data, run once each."""

import shutil
from pathlib import Path

import pytest
from workflow_runs import Finished, run_once

HERE = Path(__file__).parent
#: Vehicle -> folder of raw files -> files under the folder of measured data.
MEASURED = {
    "t200": {"mooring": ["t200_bollard/T200-Public-Performance-Data-10-20V-September-2019.xlsx"]},
    "motor_dyno": {
        "load_test": [
            "motor_dyno/odrive_data.csv",
            "motor_dyno/Motor_efficiency_data_handler.xlsx",
        ]
    },
    "pptc": {
        "open_water": ["propeller_open_water/pptc_vp1304/pptc_vp1304_open_water_measured.csv"]
    },
    "uiuc": {"open_water": ["propeller_open_water/uiuc_air/volume2_exp.csv"]},
}


@pytest.fixture(scope="session")
def bundled(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """The bundled vehicle, run."""

    def fill(raw: Path) -> None:
        shutil.copytree(repository / "raw/mmt300", raw / "mmt300")

    return run_once(tmp_path_factory, "bundled", fill)


@pytest.fixture(scope="session")
def measured(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """The measured data, each with nothing but a vehicle.yaml, run."""
    missing = [
        file
        for folders in MEASURED.values()
        for files in folders.values()
        for file in files
        if not (shared_data / file).is_file()
    ]
    if missing:
        pytest.skip(f"not in {shared_data}: {', '.join(missing)}")

    def fill(raw: Path) -> None:
        for vehicle, folders in MEASURED.items():
            (raw / vehicle).mkdir()
            shutil.copy(HERE / vehicle / "vehicle.yaml", raw / vehicle)
            for folder, files in folders.items():
                (raw / vehicle / folder).mkdir()
                for file in files:
                    shutil.copy(shared_data / file, raw / vehicle / folder)

    return run_once(tmp_path_factory, "measured", fill)
