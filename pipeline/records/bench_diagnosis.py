"""Schema of ``diagnosis.json`` of a mooring table: the diagnosis, and its curves by code."""

from pipeline.records.base import Record
from pipeline.records.diagnosis import DiagnosisRecord


class CodeSeries(Record):
    """One channel by control code: measured, the model before, the model with the answer."""

    channel: str
    unit: str
    code: tuple[float, ...]
    measured: tuple[float, ...]
    before: tuple[float, ...]
    after: tuple[float, ...]
    held_out: tuple[bool, ...]


class BenchDiagnosisRecord(DiagnosisRecord):
    """The answer for a mooring table; what only a pool run has is empty."""

    by_code: tuple[CodeSeries, ...]
    """Takes the place of `series`, which is over time."""
