"""Where a result came from: digests of its inputs and of the code, and the file that holds both.

Every stage writes one JSON file, the envelope::

    {"schema": "rig2sea/<kind>/1", "vehicle": ..., "version": ..., "inputs": {path: sha256},
     "code": digest, "record": {...} or null, "why_not": reason or null, "problems": [...],
     "record_sha256": digest of the record}

It appears whole or not at all, holds no time and no absolute path, and is byte for byte the same
for the same inputs and code. A file that is half-written, edited or foreign is refused.
"""

import hashlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pipeline import __version__
from pipeline.errors import InputError, Place, Problem, writing_remedy
from pipeline.reader_language import ENGLISH, current
from pipeline.whole_file import whole_file

if TYPE_CHECKING:
    from pipeline.records.base import Record

R = TypeVar("R", bound="Record")

PACKAGE = Path(__file__).resolve().parent
#: Whatever is made of this translates.
LANGUAGE_MODULE = PACKAGE / "language" / "catalogue.py"
#: A digest that no file has: stands for one that cannot be read, so that its return is noticed.
UNREADABLE = "unreadable"
_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]+))",
    re.MULTILINE,
)
_COMMENT = re.compile(r"#[^\n]*")
#: Import name -> name of the distribution, where they differ.
_DISTRIBUTION = {"ruamel": "ruamel.yaml"}


def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes, or `UNREADABLE`."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return UNREADABLE


def code_digest(*modules: str) -> str:
    """Digest of all the code that these modules of the package are made of, 16 hexadecimal digits.

    Follows the imports inside the package (also those within functions), takes in the data files
    (templates, styles) of every sub-package met, and the versions of the third-party packages. Code
    that writes in the reader's language (a page) has another digest in each language.
    Imports are found by their text, which takes milliseconds; an import that stands in a comment
    or a string can only add a file too many, which costs a re-run and never a stale result.
    """
    for name in modules:
        if _module_file(name) is None:
            raise ModuleNotFoundError(f"{name} is not a module of rig2sea")
    members, outside = _closure(modules)
    digest = hashlib.sha256()
    for member in sorted(members):
        own = _digest_of(member, _state(member))
        digest.update(f"{member.relative_to(PACKAGE).as_posix()} {own}\n".encode())
    for package in sorted(outside):
        digest.update(f"{package} {_installed_version(package)}\n".encode())
    if LANGUAGE_MODULE in members and current() != ENGLISH:
        digest.update(f"language {current()}\n".encode())
    return digest.hexdigest()[:16]


def _closure(modules: Iterable[str]) -> tuple[set[Path], set[str]]:
    """Return the package's files that the modules are made of, and the other packages imported."""
    members: set[Path] = set()
    outside: set[str] = set()
    seen: set[str] = set()
    folders = {PACKAGE}
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        path = _module_file(name)
        if path is None:
            continue
        members.add(path)
        if path.parent not in folders:
            folders.add(path.parent)
            members.update(_data_files(path.parent))
        waiting.append(name.rpartition(".")[0])
        for imported in _imports(path, _state(path)):
            top = imported.partition(".")[0]
            if top == PACKAGE.name:
                waiting.append(imported)
            else:
                outside.add(top)
    return members, outside


def _module_file(name: str) -> Path | None:
    parts = name.split(".")
    if parts[0] != PACKAGE.name:
        return None
    # thousands are asked for: as texts, in a tenth of the time of paths
    base = os.path.join(PACKAGE, *parts[1:])  # noqa: PTH118
    for candidate in (f"{base}/__init__.py", f"{base}.py" if parts[1:] else ""):
        if os.path.isfile(candidate):  # noqa: PTH113
            return Path(candidate)
    return None


def _data_files(package: Path) -> Iterable[Path]:
    for folder, folders, files in os.walk(package):
        folders[:] = [one for one in folders if one != "__pycache__"]
        yield from (Path(folder, one) for one in files if not one.endswith(".py"))


def _state(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_mtime_ns, status.st_size


@cache
def _digest_of(path: Path, _version: tuple[int, int]) -> str:
    return file_digest(path)


@cache
def _imports(path: Path, _version: tuple[int, int]) -> frozenset[str]:
    """Return every module that the file may import; ``from a import b`` gives a and a.b."""
    found: set[str] = set()
    for source, names, plain in _IMPORT.findall(path.read_text(encoding="utf-8")):
        if source:
            found.add(source)
            listed = _COMMENT.sub("", names).strip().strip("()")
            found.update(
                f"{source}.{part.split()[0]}" for part in listed.split(",") if part.split()
            )
        else:
            found.update(p.split()[0] for p in _COMMENT.sub("", plain).split(",") if p.split())
    return frozenset(found)


@cache
def _installed_version(package: str) -> str:
    try:
        return metadata.version(_DISTRIBUTION.get(package, package))
    except metadata.PackageNotFoundError:
        return ""


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file so that readers see the old one or the whole new one; text as UTF-8."""
    try:
        with whole_file(path) as file:
            file.write(content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise unwritable(path, error) from error


def unwritable(path: Path, error: OSError) -> InputError:
    """Return the message for a place that cannot be written."""
    return InputError.at(
        Place(str(path)),
        f"cannot be written: {error.strerror or error}.",
        expected="a folder with write permission and free space.",
        remedy=writing_remedy(
            error, "Mend that or choose another folder with --out, then run again."
        ),
    )


def canonical_json(value: object) -> str:
    """Return JSON that is the same for the same value: sorted keys, no infinities."""
    return json.dumps(value, sort_keys=True, ensure_ascii=False, allow_nan=False, indent=1)


@dataclass(frozen=True)
class Envelope(Generic[R]):
    """One processed file: a record, or the reason why there is none, with its provenance.

    `problems` holds what made the whole record impossible; problems of single files stand in the
    records of the ingest stages.
    """

    kind: str
    vehicle: str
    inputs: Mapping[str, str]
    code: str
    record: R | None
    why_not: str | None = None
    problems: tuple[Problem, ...] = ()
    version: str = field(default=__version__)

    def to_json(self) -> str:
        """Return the file's text."""
        record = None if self.record is None else self.record.model_dump(mode="json")
        body = {
            "schema": schema_of(self.kind),
            "vehicle": self.vehicle,
            "version": self.version,
            "inputs": dict(self.inputs),
            "code": self.code,
            "record": record,
            "record_sha256": content_digest(record),
            "why_not": self.why_not,
            "problems": [asdict(problem) for problem in self.problems],
        }
        return canonical_json(body) + "\n"


def schema_of(kind: str) -> str:
    """Return the schema name of a kind of processed file."""
    return f"rig2sea/{kind}/1"


def content_digest(value: object) -> str:
    """SHA-256 of a JSON value, the same whatever the order of its keys."""
    return hashlib.sha256(canonical_json(value).encode()).hexdigest()


def write_record(path: Path, record: "Record") -> None:
    """Write a record by itself as JSON, as `write_atomically`."""
    write_atomically(path, canonical_json(record.model_dump(mode="json")) + "\n")


def write_envelope(path: Path, envelope: Envelope[Any]) -> None:
    """Write a processed file atomically; see `write_atomically` for what it raises."""
    write_atomically(path, envelope.to_json())


def read_raw_envelope(path: Path, kind: str) -> dict[str, Any]:
    """Read a processed file as plain JSON after checking its schema and its digest.

    Raises `InputError` when the file is absent, half-written, edited by hand, or something else.
    """
    place = Place(str(path))
    remedy = "Delete it and run again: rig2sea run"
    expected = f"a processed file with the schema {schema_of(kind)}."
    try:
        body = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError.at(place, "does not exist.", expected=expected) from None
    except OSError as error:
        raise InputError.at(place, f"cannot be read: {error.strerror}.") from None
    except (ValueError, RecursionError):
        raise InputError.at(
            place, "is half-written or not JSON.", expected=expected, remedy=remedy
        ) from None
    if not isinstance(body, dict) or body.get("schema") != schema_of(kind):
        found = body.get("schema") if isinstance(body, dict) else type(body).__name__
        raise InputError.at(place, f"has the schema {found!r}.", expected=expected, remedy=remedy)
    if body.get("record_sha256") != content_digest(body.get("record")):
        raise InputError.at(
            place,
            "was changed after it was written: the digest of its record does not fit.",
            expected=expected,
            remedy=remedy,
        )
    return body


def read_envelope(path: Path, kind: str, model: type[R]) -> Envelope[R]:
    """Read and check a processed file of a kind, which is the stage's name: ``"drive"``."""
    from pydantic import ValidationError

    body = read_raw_envelope(path, kind)
    try:
        record = None if body["record"] is None else model.model_validate(body["record"])
        return Envelope(
            kind=kind,
            vehicle=body["vehicle"],
            inputs=body["inputs"],
            code=body["code"],
            record=record,
            why_not=body["why_not"],
            problems=tuple(map(Problem.of, body["problems"])),
            version=body["version"],
        )
    except (KeyError, TypeError, ValidationError) as error:
        first = str(error).splitlines()[0]
        raise InputError.at(
            Place(str(path)),
            f"does not hold what the schema {schema_of(kind)} asks for ({first}).",
            remedy="Delete it and run again: rig2sea run",
        ) from None


def tables_text(body: Mapping[str, Any], *, inputs: Mapping[str, str], code: str) -> str:
    """Return the text of ``tables.json``: the tables as others read them, and ``provenance``."""
    plain = json.loads(canonical_json(body))
    provenance = {
        "schema": schema_of("tables"),
        "version": __version__,
        "inputs": dict(inputs),
        "code": code,
        "tables_sha256": content_digest(plain),
    }
    return canonical_json({**plain, "provenance": provenance}) + "\n"


def read_tables(path: Path) -> dict[str, Any]:
    """Read ``tables.json`` after checking its digest; the tables stay plain JSON.

    Raises `InputError` when the file is absent, half-written, edited by hand, or something else.
    """
    fault = "is not a whole tables.json."
    try:
        body: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        plain = {key: value for key, value in body.items() if key != "provenance"}
        if body["provenance"]["tables_sha256"] == content_digest(plain):
            return body
        fault = "was changed after it was written: its digest does not fit."
    except OSError as error:
        fault = f"cannot be read: {error.strerror}."
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    raise InputError.at(Place(str(path)), fault, remedy="Delete it and run again: rig2sea run")
