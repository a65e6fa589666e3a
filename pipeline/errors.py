"""What can go wrong, said so that the engineer at the bench can mend it.

Every problem names the place (file, sheet, row, column), what is wrong, what was expected and what
to do. A problem that stops the work on a file is raised as `InputError`; one that does not is
collected as a `Problem` in the record of that file and shown by ``rig2sea check`` and the report.

What is asked for may end in one of three ways, and a docstring speaks of it only where there is
more to say: `plan.UsageError` where what a person named is not there, `InputError` where a file or
a place cannot be used, `CannotComputeError` where the files are good and no result follows.
"""

import errno
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal


@dataclass(frozen=True)
class Place:
    """Where in the engineer's files: as much of it as is known.

    `row` is the row number that a spreadsheet program or an editor shows (first row is 1);
    `column` is the spreadsheet letter or the column's name.
    """

    file: str
    sheet: str | None = None
    row: int | None = None
    column: str | None = None

    def __str__(self) -> str:
        """Return e.g. ``raw/a/load_test/drive.xlsx, sheet "Code 90", row 14, column C``."""
        parts = [self.file]
        if self.sheet is not None:
            parts.append(f'sheet "{self.sheet}"')
        if self.row is not None:
            parts.append(f"row {self.row}")
        if self.column is not None:
            parts.append(f"column {self.column}")
        return ", ".join(parts)

    def error(self, what: str, expected: str = "", remedy: str = "") -> "Problem":
        """Return a problem here that leaves the file, sheet or table out."""
        return Problem("error", self, what, expected, remedy)

    def warning(self, what: str, expected: str = "", remedy: str = "") -> "Problem":
        """Return a problem here that leaves points out or makes a result doubtful."""
        return Problem("warning", self, what, expected, remedy)

    def note(self, what: str, expected: str = "", remedy: str = "") -> "Problem":
        """Return what was assumed here."""
        return Problem("note", self, what, expected, remedy)


def reason(error: BaseException, most: int = 200) -> str:
    """Return what a library says of an error, for a sentence of ours: a line without a full stop.

    >>> reason(ValueError("File magic is invalid.")), reason(KeyError())
    ('File magic is invalid', 'KeyError')
    """
    said = " ".join(str(error).split())[:most].rstrip(" .")
    return said or type(error).__name__


@dataclass(frozen=True)
class Problem:
    """One thing wrong in the input.

    `severity`: "error" means the file (or sheet) was left out; "warning" means that points were
    left out or a result is doubtful; "note" says what was assumed.
    """

    severity: Literal["error", "warning", "note"]
    place: Place
    what: str
    expected: str = ""
    remedy: str = ""

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> "Problem":
        """Return a problem that a file keeps."""
        more = {key: plain.get(key, "") for key in ("expected", "remedy")}
        return cls(plain["severity"], Place(**plain["place"]), plain["what"], **more)

    def shown_as(self, file: str) -> "Problem":
        """Return the same problem, of a file that is shown otherwise."""
        return replace(self, place=replace(self.place, file=file))

    def __str__(self) -> str:
        """Return the message a person reads: place and fault, then expectation, then remedy."""
        lines = [f"{self.place}: {self.what}"]
        if self.expected:
            lines.append(f"Expected {self.expected}")
        if self.remedy:
            lines.append(self.remedy)
        return "\n".join(lines)


def by_severity(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    """Put errors first, notes last, else keep the order."""
    rank = {"error": 0, "warning": 1, "note": 2}
    return tuple(sorted(problems, key=lambda problem: rank[problem.severity]))


class Rig2SeaError(Exception):
    """Base of every error that a user is meant to read; its text is the whole message."""


class InputError(Rig2SeaError):
    """A file from outside cannot be used."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(str(problem))
        self.problem = problem

    @classmethod
    def at(cls, place: Place, what: str, *, expected: str = "", remedy: str = "") -> "InputError":
        """Build the error from its parts."""
        return cls(Problem("error", place, what, expected, remedy))


class CannotComputeError(Rig2SeaError):
    """The input is readable, but the wanted result does not follow from it; the text says why."""


_OF_THE_MACHINE = frozenset(
    {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.ENOMEM}
)


def is_of_the_machine(error: BaseException) -> bool:
    """Tell whether a full, broken or read-only disk stands behind an error.

    Such an error says nothing of the input: it must not become a result that is believed when there
    is room again.

    >>> is_of_the_machine(OSError(errno.ENOSPC, "No space left")), is_of_the_machine(ValueError())
    (True, False)
    """
    behind: BaseException | None = error
    for _ in range(20):  # a chain may be a ring
        if behind is None:
            return False
        if isinstance(behind, OSError) and behind.errno in _OF_THE_MACHINE:
            return True
        behind = behind.__cause__ or behind.__context__
    return False


def writing_remedy(error: OSError, otherwise: str) -> str:
    """Return what to do about a place that cannot be written; a full disk has a remedy of its own.

    >>> writing_remedy(PermissionError(errno.EACCES, "Permission denied"), "Make it writable.")
    'Make it writable.'
    """
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return "The disk is full: free some space and run again. What is finished is kept."
    return otherwise
