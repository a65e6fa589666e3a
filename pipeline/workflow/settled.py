"""Whether there is nothing to do: then the engine, which takes seconds to start, is not asked.

The sweep and the plan of the pool runs compare every result with what it was made from. What else
the engine would look at goes into one digest, kept after an execution that did everything: what it
is told, the code of every stage and the rules, the raw files, and the results themselves.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.plan import RAW_KINDS, RECEIPT_STAGES, RECORD_STAGES, VehicleFolder
from pipeline.provenance import code_digest, write_atomically
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.start import snakefile
from pipeline.workflow.targets import Targets

_STAGES = (*RECORD_STAGES, "tables", *RECEIPT_STAGES, "index_page")


def state_digest(
    config: Mapping[str, Any], vehicles: Sequence[VehicleFolder], out: Path, known: KnownFiles
) -> str:
    """Digest of all that decides whether there is something to do.

    Parameters
    ----------
    config : mapping
        What the engine is told.
    vehicles : sequence of VehicleFolder
        The vehicles of this execution.
    out : Path
        The folder of ``processed/`` and ``reports/``.
    known : KnownFiles
        Digests from earlier executions.
    """
    digest = hashlib.sha256(json.dumps(config, sort_keys=True).encode())
    for line in _lines(config, vehicles, out, known):
        digest.update(f"{line}\n".encode(errors="backslashreplace"))
    return digest.hexdigest()


def _lines(
    config: Mapping[str, Any], vehicles: Sequence[VehicleFolder], out: Path, known: KnownFiles
) -> Iterator[str]:
    for stage in _STAGES:
        yield f"{stage} {code_digest(f'pipeline.stages.{stage}')}"
    for rules in sorted(snakefile().parent.glob("*.smk")):
        yield f"{rules.name} {known.digest(rules)}"
    for vehicle in vehicles:
        yield f"{vehicle.name} {known.digest(out / vehicle.vehicle_file)}"
        for kind in RAW_KINDS:
            for file in vehicle.raw_files(kind, out):
                yield f"{file} {known.digest(out / file)}"
            yield from vehicle.misnamed_files(kind, out)
    targets = Targets.from_config(config)
    for file in (*targets.all_files(), *targets.other_receipts()):
        yield f"{file} {known.digest(out / file)}"


def is_settled(memory: Path, digest: str) -> bool:
    """Whether an execution that did everything left this state."""
    try:
        return memory.read_text(encoding="utf-8").strip() == digest
    except (OSError, ValueError):
        return False


def keep(memory: Path, digest: str) -> None:
    """Remember the state after an execution that did everything."""
    write_atomically(memory, f"{digest}\n")
