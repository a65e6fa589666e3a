"""Whether the index of the reports is that of the pages there are; of all else the envelopes tell.

What the index was made from goes into one digest, kept after an execution that did everything.
Where nothing else is to do either, the engine, which takes seconds to start, is not asked.
"""

import hashlib
from collections.abc import Sequence
from pathlib import Path

from pipeline.plan import processed_file
from pipeline.provenance import code_digest, file_digest, write_atomically
from pipeline.workflow.engine_jobs import INDEX


def index_digest(vehicles: Sequence[str], others: Sequence[str], out: Path) -> str:
    """Digest of the index and of all that it was made from.

    Parameters
    ----------
    vehicles, others : sequence of str
        The vehicles of this execution, and those with results from before.
    out : Path
        The folder of ``processed/`` and ``reports/``.
    """
    receipts = [(name, out / processed_file(name, "vehicle_page")) for name in (*vehicles, *others)]
    lines = [code_digest("pipeline.stages.index_page"), file_digest(out / INDEX)]
    lines += [f"{name} {file_digest(path)}" for name, path in receipts]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def is_settled(memory: Path, digest: str) -> bool:
    """Whether an execution that did everything left this state."""
    try:
        return memory.read_text(encoding="utf-8").strip() == digest
    except (OSError, ValueError):
        return False


def keep(memory: Path, digest: str) -> None:
    """Remember the state after an execution that did everything."""
    write_atomically(memory, f"{digest}\n")
