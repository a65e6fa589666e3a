"""What lies in a folder of raw files and is not read: broken links, folders within."""

import os
from collections.abc import Iterator
from pathlib import Path

from pipeline.errors import Place, Problem
from pipeline.ingest.log_names import LOG_SUFFIX
from pipeline.ingest.workbook import WORKBOOK_SUFFIXES
from pipeline.plan import VehicleFolder, is_raw

_DATA = WORKBOOK_SUFFIXES | {".csv", ".tsv", ".xls", LOG_SUFFIX}
_MOST_LOOKED_AT = 10_000


def raw_files(folder: VehicleFolder, kind: str) -> tuple[tuple[str, ...], tuple[Problem, ...]]:
    """Return the raw files of one kind, and a problem for each name that cannot be one.

    Parameters
    ----------
    folder : VehicleFolder
        The vehicle.
    kind : str
        Folder of a test, or of the pool runs.
    """
    try:
        problems = folder.misnamed_problems(kind, f"{folder.folder}/{kind}")
        return folder.raw_files(kind), problems
    except OSError:  # a link that leads round in a circle; the others are read
        inner = Path(folder.folder, kind)
        names = sorted(path.name for path in inner.iterdir() if path.is_file())
        return tuple(f"{folder.folder}/{kind}/{name}" for name in names if is_raw(name)), ()


def passed_over(folder: Path) -> list[Problem]:
    """Return a problem for each entry of a folder of raw files that nothing reads.

    Parameters
    ----------
    folder : Path
        ``mooring``, say; it may be missing.

    Returns
    -------
    list of Problem
        An error for a link that leads nowhere, a warning for a folder with raw files in it.
    """
    if not folder.is_dir():
        return []
    found: list[Problem] = []
    for path in sorted(folder.iterdir()):
        if not is_raw(path.name) or path.is_file():
            continue
        if not path.is_dir():
            what = "this is no file, or a link to one that is not there; it was not read."
            remedy = "Copy the file here, or delete the link."
            found.append(Problem("error", Place(str(path)), what, "raw files.", remedy))
            continue
        count = sum(1 for _ in _data_below(path))
        if count:
            what = f"holds raw files ({count}) that are not read: folders are not looked into."
            remedy = f"Move them into {folder.name}/ itself."
            expected = f"raw files in {folder.name}/."
            found.append(Problem("warning", Place(str(path)), what, expected, remedy))
    return found


def _data_below(folder: Path) -> Iterator[Path]:
    """Yield the raw files in a folder and those within; links are not followed."""
    looked_at = 0
    for inner, _, names in os.walk(folder):
        for name in names:
            looked_at += 1
            if looked_at > _MOST_LOOKED_AT:
                return
            if is_raw(name) and Path(name).suffix.lower() in _DATA:
                yield Path(inner, name)
