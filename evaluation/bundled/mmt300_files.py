"""Write the rig files of `mmt300`: ``python -m evaluation.bundled.mmt300_files --to raw/mmt300``.

The same bytes come out every time; ``vehicle.yaml`` and ``README.md`` are written by hand and
left alone.
"""

import argparse
from pathlib import Path

from evaluation.bundled.mmt300_load_test import load_test_files
from evaluation.bundled.mmt300_mooring import mooring_files
from evaluation.bundled.mmt300_open_water import open_water_files


def rig_files() -> dict[str, bytes]:
    """Path relative to the vehicle's raw folder -> contents."""
    folders = {
        "load_test": load_test_files(),
        "mooring": mooring_files(),
        "open_water": open_water_files(),
    }
    return {
        f"{folder}/{name}": data
        for folder, files in folders.items()
        for name, data in files.items()
    }


def main(arguments: list[str] | None = None) -> None:
    """Write the files into a folder and name each."""
    parser = argparse.ArgumentParser(prog="python -m evaluation.bundled.mmt300_files")
    parser.add_argument("--to", type=Path, required=True, help="folder, e.g. raw/mmt300")
    folder: Path = parser.parse_args(arguments).to
    for name, data in rig_files().items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        print(path)


if __name__ == "__main__":
    main()
