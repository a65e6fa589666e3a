"""What lies in a folder of raw files and is not read: broken links, folders within."""

import os
from collections.abc import Collection, Iterator
from pathlib import Path

from pipeline.errors import Place, Problem
from pipeline.plan import POOL, RAW_KINDS, is_data, is_raw, printable
from pipeline.vehicle.run_notes import BAG_FILE

_MOST_LOOKED_AT = 10_000


def ignored_file_problems(
    folder: Path, shown_as: str = "", types: Collection[str] = ()
) -> list[Problem]:
    """Return a problem for each entry of a folder of raw files that nothing reads.

    The folder, ``mooring``, say, may be missing. Folders of the vehicle's `types` of thruster are
    read. An error is a link that leads nowhere, a warning a folder with raw files in it or with the
    name of one.
    """
    if not folder.is_dir():
        return []
    found: list[Problem] = []
    shown = shown_as or str(folder)
    for path in sorted(folder.iterdir()):
        if not is_raw(path.name) or path.is_file() or (path.name in types and path.is_dir()):
            continue
        at = Place(f"{shown}/{printable(path.name)}")
        if not path.is_dir():
            what = "this is no file, or a link to one that is not there; it was not read."
            remedy = "Copy the file here, or delete the link."
            found.append(at.error(what, "raw files.", remedy))
            continue
        if folder.name == POOL and (path / BAG_FILE).is_file():
            continue  # a bag of ROS 2, which is a run
        count = sum(1 for _ in _data_below(path))
        if count:
            what = f"holds raw files ({count}) that are not read: folders are not looked into."
            remedy = f"Move them into {folder.name}/ itself."
            if folder.name == POOL and any(path.glob("*.db3")):
                remedy = f"If it is a bag of ROS 2: ros2 bag reindex {path.name}, which writes "
                remedy += f"its {BAG_FILE}."
            if folder.name in RAW_KINDS:
                remedy += " Files of a further type of thruster: name it in tables.types."
            expected = f"raw files in {folder.name}/."
            found.append(at.warning(what, expected, remedy))
        elif is_data(path.name):
            what = "this is a folder, named like a file; nothing was read."
            remedy = "Copy the file here again, and delete the folder."
            found.append(at.warning(what, "raw files.", remedy))
    return found


def _data_below(folder: Path) -> Iterator[Path]:
    """Yield the raw files in a folder and those within; links are not followed."""
    looked_at = 0
    for inner, _, names in os.walk(folder):
        for name in names:
            looked_at += 1
            if looked_at > _MOST_LOOKED_AT:
                return
            if is_data(name):
                yield Path(inner, name)
