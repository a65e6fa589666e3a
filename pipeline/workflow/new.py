"""``rig2sea new``: the raw folder of a vehicle: blank forms, like a bundled one, or the example."""

import difflib
import re
import shutil
from pathlib import Path

import pipeline
from pipeline.bundled.new_vehicle import LIKE_HEAD, new_vehicle_files
from pipeline.bundled.vehicles import bundled_vehicle, bundled_vehicles
from pipeline.errors import InputError, Place
from pipeline.plan import NAME_EXPECTED, VEHICLE_FILE, UsageError, is_vehicle_name, printable

#: Vehicles that travel with the program, data and all.
EXAMPLES = ("mmt300",)


#: Keys of a bundled vehicle file that hold for that vehicle alone.
_ITS_OWN = ("name", "title", "data_note", "columns", "published")


def write_new_vehicle(
    name: str, raw: Path, *, example: bool = False, like: str | None = None
) -> list[Path]:
    """Write a vehicle's folder into the raw folder; nothing that is there is touched.

    Returns the files written: forms, or with `example` the example vehicle of that name with its
    raw files. `like`: begin with the model, sensors and channels of this bundled vehicle.
    """
    if not is_vehicle_name(name):
        shown = printable(name[:80])
        raise UsageError(f'"{shown}" cannot be the name of a vehicle. Expected {NAME_EXPECTED}')
    folder = raw / name
    files = example_files(name) if example else new_vehicle_files(name)
    if like is not None:
        files[VEHICLE_FILE] = _file_like(like, name).encode()
    written = []
    made = False
    try:
        raw.mkdir(parents=True, exist_ok=True)
        folder.mkdir()
        made = True
        for file, content in files.items():
            path = folder / file
            path.parent.mkdir(exist_ok=True)
            with path.open("xb") as stream:
                stream.write(content)
            written.append(path)
    except FileExistsError:
        raise InputError.at(
            Place(str(folder if folder.exists() or folder.is_symlink() else raw)),
            "is there already; nothing was written.",
            expected="a name that is not taken.",
            remedy="Choose another name, or move what is there away.",
        ) from None
    except OSError as error:
        if made:  # a half of it would be in the way of the next try
            shutil.rmtree(folder, ignore_errors=True)
        raise InputError.at(
            Place(str(folder)),
            f"cannot be written: {error.strerror or error}.",
            expected="a folder with write permission and free space.",
            remedy="Mend that or choose another folder with --raw.",
        ) from error
    return written


def vehicles_to_begin_with() -> tuple[str, ...]:
    """Names of the vehicles that a new one can be like."""
    return tuple(sorted([*EXAMPLES, *bundled_vehicles()]))


def _file_like(like: str, name: str) -> str:
    """Return the vehicle file of a bundled vehicle under another name, without what is its own."""
    names = vehicles_to_begin_with()
    if like not in names:
        near = difflib.get_close_matches(like, names, n=1)
        hint = f' Did you mean "{near[0]}"?' if near else ""
        there = ", ".join(names)
        raise UsageError(f'no bundled vehicle is called "{like}".{hint} There are {there}.')
    if like in EXAMPLES:
        text = example_files(like)[VEHICLE_FILE].decode()
    else:
        text = (bundled_vehicle(like) / VEHICLE_FILE).read_text(encoding="utf-8")
    # a block: comments that stand on it, its key, and what is indented below
    for key in _ITS_OWN:
        text = re.sub(rf"(?m)^(?:#.*\n)*{key}:.*\n(?:(?:[ \t].*)?\n)*?(?=\S|\Z)", "", text)
    return LIKE_HEAD.replace("@NAME@", name).replace("@LIKE@", like) + text


def example_files(name: str) -> dict[str, bytes]:
    """Return the files of one of the `EXAMPLES`: path within its folder -> contents."""
    if name not in EXAMPLES:
        raise UsageError(f'there is no example vehicle "{name}". There is: {", ".join(EXAMPLES)}.')
    package = Path(pipeline.__file__).resolve().parent
    for room in (package / "examples", package.parent / "raw"):  # installed; source tree
        folder = room / name
        if (folder / VEHICLE_FILE).is_file():
            return {
                path.relative_to(folder).as_posix(): path.read_bytes()
                for path in sorted(folder.rglob("*"))
                if path.is_file()
            }
    raise InputError.at(
        Place(str(package / "examples" / name)),
        "the example vehicle is missing from the installation.",
        remedy="Install rig2sea again.",
    )
