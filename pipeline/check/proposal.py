"""What a check understood, as `columns:` lines for vehicle.yaml, and how they get into it."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.check.findings import FileFinding, Findings
from pipeline.errors import CannotComputeError
from pipeline.provenance import write_atomically
from pipeline.vehicle.load import validated
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.write_back import with_columns
from pipeline.vehicle.yaml_text import parse

#: Key and value, as YAML, of each quantity.
Lines = Mapping[str, str]


@dataclass(frozen=True)
class Proposal:
    """The text of a vehicle file as it is and with the columns stated."""

    file: Path
    before: str
    after: str

    def difference(self) -> str:
        """Return the lines that change, as `diff -u` shows them."""
        before, after = (text.splitlines(keepends=True) for text in (self.before, self.after))
        name = str(self.file)
        return "".join(difflib.unified_diff(before, after, name, name, n=2))


def lines_of(files: Sequence[FileFinding]) -> dict[str, str]:
    """Return the columns on which all tables of these files agree, by quantity.

    A quantity that stands under different names in different tables cannot be stated for all.
    """
    found: dict[str, set[str]] = {}
    for file in files:
        for sheet in file.sheets:
            for key, line in sheet.stated_as:
                found.setdefault(key, set()).add(line)
    return {key: lines.pop() for key, lines in found.items() if len(lines) == 1}


def as_lines(kind: str, lines: Lines) -> list[str]:
    """Return them as they stand in vehicle.yaml."""
    return ["columns:", f"  {kind}:", *(f"    {key}: {line}" for key, line in lines.items())]


def proposals(findings: Findings, vehicle_file: Path | None = None) -> list[Proposal]:
    """Put what was understood of all files into the text of their vehicle files, or `vehicle_file`.

    Returns a proposal for each that changes; what it states already stays as it is.
    """
    by_file: dict[Path, dict[str, list[FileFinding]]] = {}
    for file in findings.files:
        path = vehicle_file or Path(file.file).parent.parent / "vehicle.yaml"
        if path.is_file() and file.points:
            by_file.setdefault(path, {}).setdefault(file.kind, []).append(file)
    done: list[Proposal] = []
    for path, kinds in by_file.items():
        before = path.read_text(encoding="utf-8")
        after = with_columns(before, {kind: lines_of(files) for kind, files in kinds.items()})
        if after != before:
            done.append(Proposal(path, before, after))
    return done


def write(proposal: Proposal) -> None:
    """Replace a vehicle file by its new text, whole or not at all.

    Raises `CannotComputeError` when the file has changed since, or the new text is no vehicle file.
    """
    path = proposal.file
    if path.read_text(encoding="utf-8") != proposal.before:
        raise CannotComputeError(f"{path} has changed in the meantime; nothing was written.")
    validated(Vehicle, parse(proposal.after.encode(), str(path)), str(path))
    mode = path.stat().st_mode & 0o777
    write_atomically(path, proposal.after)
    path.chmod(mode)
