"""Which vehicles there are, where their raw files lie, and which file each stage reads and writes.

Light on purpose: the Snakefile and the command line both start with it.
"""

import difflib
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.log_files import LOG_SUFFIXES, is_log_anywhere
from pipeline.stage_table import STAGES, stages_of

VEHICLE_FILE = "vehicle.yaml"
#: Kinds of test of a bench, each a folder of raw files: the stages that read no other's result.
RAW_KINDS = tuple(name for name in stages_of("vehicle") if not STAGES[name].needs)
#: Folder of the pool runs' logs.
POOL = "pool"
#: How the names of files end that a test bench or a vehicle writes.
_DATA = frozenset({".xlsx", ".xlsm", ".xls", ".ods", ".csv", ".tsv", *LOG_SUFFIXES})
#: Stages of a vehicle by what their envelope holds, a record or a receipt for other files.
RECORD_STAGES, RECEIPT_STAGES = (
    tuple(name for name in stages_of("vehicle") if STAGES[name].leaves == leaves)
    for leaves in ("record", "receipt")
)
#: What a stage's result is called in messages.
TITLES = {name: stage.title for name, stage in STAGES.items()}
#: What is wrong with a raw file that the workflow cannot handle.
MISNAMED = 'the file\'s name holds a brace, "<", ">" or a character that cannot be printed.'
#: How the reason begins when an earlier result is missing; that result's name and reason follow.
MISSING = "There is no "
#: A vehicle's name becomes a file name and a C identifier.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,47}")
NAME_EXPECTED = (
    'a letter, then letters, digits, "_" or "-", at most 48 in all: it becomes part of file names '
    'and of C names. "assets" and "design" are folders of reports/ already.'
)
#: Folders of ``reports/`` that are no vehicle's; some file systems take "Design" for the same.
_TAKEN = frozenset({"assets", "design"})
#: Notes may lie beside the raw files; everything else is read, or refused with a message.
_NOTES = frozenset({".md", ".yaml", ".yml", ".pdf", ".png", ".jpg", ".jpeg"})


class UsageError(ValueError):
    """The command was given something that does not exist; the text says what does."""


@dataclass(frozen=True)
class VehicleFolder:
    """A vehicle and the folder that holds its ``vehicle.yaml``, as seen from the output folder.

    With `thruster_type` it stands for one more type of thruster of that vehicle, whose raw files
    lie in folders of that name within those of the tests; `of_type` makes one.
    """

    name: str
    folder: str
    thruster_type: str = ""

    def of_type(self, thruster_type: str) -> "VehicleFolder":
        """Return what stands for a further type of thruster: results as of a vehicle of its own."""
        return VehicleFolder(typed_name(self.name, thruster_type), self.folder, thruster_type)

    @property
    def vehicle_file(self) -> str:
        """Path of ``vehicle.yaml``."""
        return f"{self.folder}/{VEHICLE_FILE}"

    def raw_files(self, kind: str, base: Path | None = None) -> tuple[str, ...]:
        """Return the raw files of one kind, sorted; `base` is what `folder` is relative to.

        Hidden files, the lock files of spreadsheet programs and written notes are not raw data.
        """
        names = self._names(kind, base)
        room = f"{self.folder}/{self._room(kind)}"
        return tuple(f"{room}/{name}" for name in names if _is_usable(name))

    @property
    def digest_prefix(self) -> str:
        """How the names of its raw files begin in results: ``raw/<vehicle>/``."""
        return f"raw/{self.name.removesuffix(f'-{self.thruster_type}')}/"

    def names_in_results(self, files: Iterable[str]) -> set[str]:
        """Return what results call files, of which some lie in the vehicle's folder."""
        own = f"{self.folder}/"
        return {
            f"{self.digest_prefix}{one.removeprefix(own)}" if one.startswith(own) else one
            for one in files
        }

    def place_of(self, out: Path, name: str) -> Path:
        """Return where the file lies that results call by a name."""
        inside = name.removeprefix(self.digest_prefix)
        return out / name if inside == name else out / self.folder / inside

    def _room(self, kind: str) -> str:
        """Return the folder of a kind of test, within the vehicle's."""
        return f"{kind}/{self.thruster_type}" if self.thruster_type else kind

    def misnamed_files(self, kind: str, base: Path | None = None) -> tuple[str, ...]:
        """Return the names of raw files that the workflow cannot handle, made printable."""
        names = [name for name in self._names(kind, base) if not _is_usable(name)]
        return tuple(printable(name) for name in names)

    def misnamed_problems(self, kind: str, shown_as: str) -> tuple[Problem, ...]:
        """Return a problem for each of these files; `shown_as` is their folder in messages."""
        return tuple(
            Place(f"{shown_as}/{name}").error(
                MISNAMED, remedy="Rename the file. The others were read."
            )
            for name in self.misnamed_files(kind)
        )

    def misplaced_problems(self, base: Path | None = None) -> tuple[Problem, ...]:
        """Return a warning for raw data beside the folders of the tests, where nothing reads it.

        That is a file next to ``vehicle.yaml``, or a folder of another name.
        """
        if self.thruster_type:
            return ()
        where = Path(self.folder) if base is None else base / self.folder
        kinds = (*RAW_KINDS, POOL)
        said: list[tuple[str, str, str]] = []
        for path in sorted(where.iterdir()) if where.is_dir() else ():
            if path.is_file() and is_data(path.name):
                is_log = is_log_anywhere(path.name)
                what = "lies beside the folders of the tests, so it was not read."
                remedy = "Move it into pool/." if is_log else "Move it into the folder of its test."
                said.append((path.name, what, remedy))
            elif path.is_dir() and path.name not in kinds and not path.name.startswith("."):
                data = [one for one in path.iterdir() if one.is_file() and is_data(one.name)]
                near = difflib.get_close_matches(path.name.lower(), kinds, n=1, cutoff=0.5)
                if data and all(is_log_anywhere(one.name) for one in data):
                    near = [POOL]
                what = (
                    f"holds raw files ({len(data)}) that are not read: no test has such a folder."
                )
                remedy = f"Rename it to {near[0]}." if near else "Rename it."
                said += [(path.name, what, remedy)] if data else []
        expected = f"raw files in {', '.join(f'{kind}/' for kind in kinds)}."
        return tuple(
            Place(f"{self.name}/{printable(name)}").warning(what, expected, remedy)
            for name, what, remedy in said
        )

    def _names(self, kind: str, base: Path | None) -> list[str]:
        room = self._room(kind)
        where = Path(self.folder, room) if base is None else base / self.folder / room
        try:
            with os.scandir(where) as entries:
                return sorted(e.name for e in entries if _is_file(e) and is_raw(e.name))
        except (FileNotFoundError, NotADirectoryError):
            return []


def _is_file(entry: os.DirEntry[str]) -> bool:
    """Tell a file, also behind a link; a link that leads round in a circle is none."""
    try:
        return entry.is_file()
    except OSError:
        return False


def _is_usable(name: str) -> bool:
    """Tell whether the engine takes a file by this name: it reads {x} and <x> as its own."""
    return name.isprintable() and not set("{}<>") & set(name)


def is_raw(name: str) -> bool:
    """Tell raw data from hidden files, lock files and notes by the file's name."""
    if name.lower().startswith((".", "~$", "readme")):
        return False
    return Path(name).suffix.lower() not in _NOTES


def printable(name: str) -> str:
    """Return a file's name as it can be shown, with "?" for what cannot be printed."""
    return "".join(c if c.isprintable() else "?" for c in name)


def is_data(name: str) -> bool:
    """Tell measured data from anything else by the file's name."""
    return is_raw(name) and Path(name).suffix.lower() in _DATA


def typed_name(vehicle: str, thruster_type: str) -> str:
    """Return the name under which results of a further type of thruster are kept.

    >>> typed_name("boat", "tunnel"), typed_name("boat", "")
    ('boat-tunnel', 'boat')
    """
    return f"{vehicle}-{thruster_type}" if thruster_type else vehicle


def processed_file(vehicle: str, stage: str) -> str:
    """Path of a stage's file, from the output folder."""
    return f"processed/{vehicle}/{stage}.json"


def stage_log(vehicle: str, stage: str, item: str = "") -> str:
    """Path of what a stage printed, of a run or a day where there is one, from the output folder.

    >>> stage_log("boat", "run_page", "dive"), stage_log("boat", "static")
    ('processed/boat/logs/run_page/dive.log', 'processed/boat/logs/static.log')
    """
    parts = ("processed", vehicle, "logs", stage, item)
    return "/".join(part for part in parts if part) + ".log"


def report_file(vehicle: str) -> str:
    """Path of a vehicle's page, from the output folder."""
    return f"reports/{vehicle}/index.html"


def seen_from(path: Path, out: Path) -> str:
    """Return `path` relative to the output folder when it lies within, absolute otherwise.

    A relative path keeps the workflow's memory valid when the whole folder is moved.
    """
    absolute = _absolute(path)
    base = _absolute(out)
    if absolute != base and absolute.is_relative_to(base):
        return absolute.relative_to(base).as_posix()
    return absolute.as_posix()


def _absolute(path: Path) -> Path:
    """Make absolute without following links: a vehicle keeps the name that the user sees."""
    return Path(os.path.normpath(path.absolute()))


def discover(raw: Path, out: Path) -> tuple[tuple[VehicleFolder, ...], tuple[Problem, ...]]:
    """Find every vehicle under the raw folder, by name.

    Also returns a problem for each folder that looks like one and is not; `out` holds
    ``processed/`` and ``reports/``.
    """
    vehicles: list[VehicleFolder] = []
    problems: list[Problem] = []
    for folder in sorted(raw.iterdir()) if raw.is_dir() else ():
        if not folder.is_dir() or folder.name.startswith("."):
            continue
        if not (folder / VEHICLE_FILE).exists():
            kinds = [kind for kind in (*RAW_KINDS, POOL) if (folder / kind).is_dir()]
            if kinds:
                problems.append(
                    Place(str(folder)).error(
                        f"has {', '.join(kinds)} but no {VEHICLE_FILE}.",
                        remedy=f"Write {folder / VEHICLE_FILE}; docs/bench_data.md shows one.",
                    )
                )
            continue
        try:
            vehicles.append(vehicle_at(folder, out))
        except InputError as error:
            problems.append(error.problem)
    return tuple(vehicles), tuple(problems)


def is_vehicle_name(text: str) -> bool:
    """Tell whether a text can be the name of a vehicle, and so of its folder.

    >>> is_vehicle_name("mmt300"), is_vehicle_name("../mmt300"), is_vehicle_name("")
    (True, False, False)
    """
    return _NAME.fullmatch(text) is not None and text.lower() not in _TAKEN


def vehicle_at(folder: Path, out: Path) -> VehicleFolder:
    """Return the vehicle of a folder."""
    name = _absolute(folder).name
    if not is_vehicle_name(name):
        raise InputError.at(
            Place(str(folder)),
            f'the folder\'s name "{name}" cannot be the name of a vehicle.',
            expected=NAME_EXPECTED,
            remedy="Rename the folder.",
        )
    path = seen_from(folder, out)
    if not _is_usable(path):
        raise InputError.at(
            Place(str(folder)),
            'the path holds a brace, "<", ">" or a character that cannot be printed.',
            remedy="Rename that folder.",
        )
    return VehicleFolder(name, path)


def choose(
    wanted: Sequence[str], raw: Path, out: Path
) -> tuple[tuple[VehicleFolder, ...], tuple[Problem, ...]]:
    """Return the vehicles that the user asked for; all under `raw` when nothing was asked.

    Each is a name under the raw folder, or a path to a folder that holds ``vehicle.yaml``.
    """
    known, problems = discover(raw, out)
    if not wanted:
        return known, problems
    by_name = {vehicle.name: vehicle for vehicle in known}
    chosen: dict[str, VehicleFolder] = {}
    refused: list[Problem] = []
    for text in wanted:
        try:
            vehicle = by_name.get(text) or _by_path(text, raw, out, by_name)
        except InputError as error:
            refused.append(error.problem)
            continue
        before = chosen.setdefault(vehicle.name, vehicle)
        if before != vehicle:
            raise UsageError(
                f"{before.folder} and {vehicle.folder} have the same name; their results would "
                "overwrite each other. Rename one, or give them different --out folders."
            )
    return tuple(chosen[name] for name in sorted(chosen)), tuple(refused)


def _by_path(text: str, raw: Path, out: Path, known: dict[str, VehicleFolder]) -> VehicleFolder:
    for path in (Path(text), raw / text):
        folder = path.parent if path.name == VEHICLE_FILE else path
        if (folder / VEHICLE_FILE).exists():
            return vehicle_at(folder, out)
    near = difflib.get_close_matches(text, known, n=1)
    hint = f' Did you mean "{near[0]}"?' if near else ""
    there = ", ".join(sorted(known)) or "none"
    raise UsageError(
        f'there is no vehicle "{text}": neither a folder under {raw} nor a path to one that holds '
        f"{VEHICLE_FILE}.{hint} Under {raw}: {there}."
    )
