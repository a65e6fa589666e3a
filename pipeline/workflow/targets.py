"""What the Snakefile asks: inputs that depend on the vehicle, and digests that make it re-run."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.plan import (
    RECEIPT_STAGES,
    RECORD_STAGES,
    VehicleFolder,
    discover,
    processed_file,
    report_file,
)
from pipeline.provenance import file_digest


@dataclass(frozen=True)
class Targets:
    """The vehicles of this run, and those whose earlier results the index also leads to."""

    vehicles: Mapping[str, VehicleFolder]
    others: tuple[str, ...] = ()

    @classmethod
    def from_config(cls, config: Mapping[str, Any]) -> "Targets":
        """Take the vehicles that ``rig2sea run`` chose, or find them under ``raw/``."""
        here = Path.cwd()
        if "vehicles" in config:
            folders = {name: VehicleFolder(name, path) for name, path in config["vehicles"].items()}
            return cls(folders, tuple(config.get("others", ())))
        found, _ = discover(Path(config.get("raw", "raw")), here)
        return cls({vehicle.name: vehicle for vehicle in found})

    def all_files(self) -> list[str]:
        """Return every file of the workflow.

        All of them, because the engine does not miss an intermediate file that is gone as long as
        what was made from it is there.
        """
        files = ["reports/index.html"]
        for name in self.vehicles:
            stages = (*RECORD_STAGES, "tables", *RECEIPT_STAGES)
            files += [report_file(name), *(processed_file(name, stage) for stage in stages)]
        return files

    def receipts(self) -> list[str]:
        """Return the receipts of the pages of this run's vehicles."""
        return [processed_file(name, "vehicle_page") for name in self.vehicles]

    def other_receipts(self) -> list[str]:
        """Return those of the vehicles that are not part of this run."""
        return [processed_file(name, "vehicle_page") for name in self.others]

    def vehicle_file(self, vehicle: str) -> str:
        """Return the path of a vehicle's description."""
        return self.vehicles[vehicle].vehicle_file

    def raw_files(self, vehicle: str, kind: str) -> list[str]:
        """Return a vehicle's raw files of one kind."""
        return list(self.vehicles[vehicle].raw_files(kind))

    def content(self, vehicle: str, kind: str | None = None) -> str:
        """Return a digest of the vehicle file and of the raw files of one kind.

        Times of files lie (an archive unpacked, a clock set back); names and contents do not.
        """
        folder = self.vehicles[vehicle]
        digest = hashlib.sha256(file_digest(Path(folder.vehicle_file)).encode())
        for path in folder.raw_files(kind) if kind else ():
            digest.update(f"{Path(path).name}\n{file_digest(Path(path))}\n".encode())
        for name in folder.misnamed_files(kind) if kind else ():
            digest.update(f"{name}\n".encode())
        return digest.hexdigest()[:16]

    def others_content(self) -> str:
        """Return a digest of the results of the vehicles that are not part of this run."""
        parts = [f"{path} {file_digest(Path(path))}" for path in self.other_receipts()]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]
