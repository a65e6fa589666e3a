"""The label of a case: what was done to the vehicle. Sealed until the verdict is on disk.

A sealed file holds the label compressed, with its digest: it cannot be read in passing, and one
that was changed is noticed.
"""

import base64
import hashlib
import json
import zlib
from pathlib import Path

from pydantic import Field

from pipeline.errors import InputError, Place
from pipeline.records.base import Record
from pipeline.whole_file import whole_file

_MOST_BYTES = 1_000_000


class TrueEffect(Record):
    """An effect at work, with its parameters in the units of the library."""

    effect: str
    parameters: dict[str, float]
    thruster: str | None = None
    axes: tuple[str, ...] = ()


class CaseLabel(Record):
    """The truth of a case.

    `gap_ratio` is what the fault opens on the runs given, over the healthy floor, in its worst
    channel; `own_ratios` what each effect of a pair adds to the other one, likewise; `times_s` says
    by run when a trouble outside the library is there.
    """

    vehicle: str
    kind: str
    effects: tuple[TrueEffect, ...] = ()
    trouble: str | None = None
    trouble_thruster: str | None = None
    overlaps: tuple[str, ...] = ()
    times_s: dict[str, tuple[tuple[float, float], ...]] = Field(default_factory=dict)
    wanted_ratio: float
    gap_ratio: float
    own_ratios: dict[str, float] = Field(default_factory=dict)
    channel_ratios: dict[str, float]
    healthy_floor: dict[str, float]
    regimes: dict[str, float] = Field(default_factory=dict)
    """Rank correlation of the gap in a window with speed, command, turning, depth, wall, time."""
    manoeuvres: str
    healthy_runs: int
    missing: tuple[str, ...] = ()
    seed: int

    @property
    def truth(self) -> tuple[str, ...]:
        """The right answer: effects in alphabetical order, or none, or unknown."""
        if self.trouble is not None or self.kind == "leave_one_out":
            return ("unknown",)
        return tuple(sorted(one.effect for one in self.effects)) or ("none",)


def seal(label: CaseLabel, path: Path) -> None:
    """Write a label to a sealed file, whole or not at all."""
    content = label.model_dump_json().encode()
    document = {
        "schema": "rig2sea/sealed_label/1",
        "sha256": hashlib.sha256(content).hexdigest(),
        "sealed": base64.b64encode(zlib.compress(content, 9)).decode(),
    }
    with whole_file(path) as stream:
        stream.write(json.dumps(document).encode())


def open_label(path: Path, verdict: Path) -> CaseLabel:
    """Open a sealed label, but only after the verdict, its ``diagnosis.json``, is there.

    Raises `InputError` when there is no verdict yet, or the sealed file is not what was written.
    """
    if not verdict.is_file():
        raise InputError.at(
            Place(str(verdict)),
            "there is no verdict, so the label stays sealed.",
            expected="the diagnosis.json of the case.",
            remedy="Run the diagnosis first.",
        )
    try:
        with path.open("rb") as stream:
            document = json.loads(stream.read(_MOST_BYTES))
        opener = zlib.decompressobj()
        content = opener.decompress(base64.b64decode(document["sealed"]), _MOST_BYTES)
        _check_digest(content, document["sha256"])
        return CaseLabel.model_validate_json(content)
    except (OSError, ValueError, KeyError, TypeError, zlib.error) as error:
        raise InputError.at(
            Place(str(path)),
            f"the sealed label cannot be opened: {error}.",
            expected="a file written by the blind check.",
            remedy="Make the case again from its seed.",
        ) from None


def _check_digest(content: bytes, digest: str) -> None:
    if hashlib.sha256(content).hexdigest() != digest:
        raise ValueError("its digest does not fit")
