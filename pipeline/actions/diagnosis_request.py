"""What a diagnosis is asked of, pool runs or mooring tables, and where its answer lies."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.ingest.workbook import TEXT_SUFFIXES, WORKBOOK_SUFFIXES
from pipeline.plan import UsageError
from pipeline.records.diagnosis import DiagnosisRecord

TABLE_SUFFIXES = WORKBOOK_SUFFIXES | TEXT_SUFFIXES
RESULT_FILE = "diagnosis.json"


@dataclass(frozen=True)
class DiagnosisRequest:
    """What the user asked for; `to` None: ``processed/<vehicle>/diagnosis``.

    Of mooring tables ``bench_diagnosis`` there.
    """

    vehicle: str
    runs: tuple[str, ...]
    holdout: tuple[str, ...] = ()
    healthy: tuple[str, ...] = ()
    to: Path | None = None
    raw: Path = Path("raw")
    out: Path = Path()


@dataclass(frozen=True)
class DiagnosisFiles:
    """The result and where it lies; `corrected` is None where nothing of the file changes."""

    record: DiagnosisRecord
    result: Path
    corrected: Path | None
    page: Path
    overlays: tuple[Path, ...] = ()
    """One log a run: everything that was recorded, and the simulation with the effect beside it."""
    without_overlay: tuple[str, ...] = ()
    """Logs of which none could be made, each with the reason."""


def are_tables(runs: Sequence[str]) -> bool:
    """Tell whether the runs are mooring tables.

    Raises
    ------
    UsageError
        When some are and some are not.

    Examples
    --------
    >>> are_tables(["new.xlsx"]), are_tables(["new.tsv"]), are_tables(["surge-steps"])
    (True, True, False)
    """
    tables = [run for run in runs if Path(run).suffix.lower() in TABLE_SUFFIXES]
    if tables and len(tables) < len(runs):
        other = next(run for run in runs if run not in tables)
        raise UsageError(
            f"{tables[0]} is a mooring table and {other} is not: give tables or pool runs."
        )
    return bool(tables)
