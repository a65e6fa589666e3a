"""A blind check of many cases: stoppable, resumable, on several processes, with a page at the end.

``cases.jsonl`` has a line for each case that is done, ``campaign.json`` what the campaign is; the
sealed labels and the verdicts lie beside them.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pipeline.blind.score import CampaignScore, score_campaign
from pipeline.blind.verdict_score import CaseScore
from pipeline.campaign.blind_case import BlindPlace, run_case, subjects_of
from pipeline.campaign.campaign_folder import HEADER_FILE, claim_folder, read_header
from pipeline.campaign.many_cases import lines_of_cases
from pipeline.effects.discovery import module_names
from pipeline.provenance import code_digest

SCHEMA = "rig2sea/blind/1"
_MODULES = ("pipeline.campaign.blind_case",)


@dataclass(frozen=True)
class BlindRequest:
    """What is asked for; `place.to` is the folder of the campaign.

    `only` names some cases by number, which need not be among the first `cases`.
    """

    cases: int
    place: BlindPlace
    resume: bool = False
    processes: int = 2
    only: tuple[int, ...] = ()

    @property
    def numbers(self) -> Sequence[int]:
        """Numbers of the cases that are asked for."""
        return sorted(set(self.only)) or range(self.cases)


@dataclass(frozen=True)
class BlindResult:
    """A campaign, finished or stopped."""

    score: CampaignScore
    done: int
    wanted: int
    not_made: int
    to: Path
    code: str
    """Digest of the program that made the cases; see `code_digest`."""

    def to_json(self) -> dict[str, Any]:
        """Return what ``rig2sea blind --json`` prints."""
        return {
            "schema": SCHEMA,
            "cases": self.done,
            "wanted": self.wanted,
            "not_made": self.not_made,
            "to": str(self.to),
            "code": self.code,
            "score": self.score.model_dump(mode="json"),
        }


def run_campaign(
    request: BlindRequest, said: Callable[[int, int, str], None] = lambda *_: None
) -> BlindResult:
    """Run the cases that are not done yet, and score all that are.

    Parameters
    ----------
    request : BlindRequest
        The campaign.
    said : callable
        Told of every case: how many are done, how many there are, one line.

    Raises
    ------
    InputError
        When the folder holds a campaign and `resume` is not set, or another campaign.
    """
    place = request.place
    subjects_of(place)  # a vehicle that cannot be read is found before any case is made
    lines_file = place.to / "cases.jsonl"
    _claim(request, lines_file)
    run = partial(run_case, place=place)
    lines = lines_of_cases(
        lines_file, request.numbers, run, said, _line_text, processes=request.processes
    )
    return summary(lines, request)


def summary(lines: list[dict[str, Any]], request: BlindRequest) -> BlindResult:
    """Score the lines of a campaign."""
    numbers = frozenset(request.numbers)
    asked = [line for line in lines if line["number"] in numbers]
    scored = [line["score"] for line in asked if "score" in line]
    scores = [CaseScore.model_validate_json(json.dumps(score)) for score in scored]
    return BlindResult(
        score_campaign(scores),
        len(asked),
        len(numbers),
        sum("not_made" in line for line in asked),
        request.place.to,
        str(read_header(request.place.to / HEADER_FILE, SCHEMA).get("code", "")),
    )


def _claim(request: BlindRequest, lines_file: Path) -> None:
    """Write what the campaign is, or check that the folder holds this one."""
    place = request.place
    header = {
        "schema": SCHEMA,
        "seed": place.seed,
        "vehicles": list(place.vehicles),
        "calibration": place.calibration,
        "run_s": place.run_s,
        "code": code_digest(*_MODULES, *module_names()),
    }
    claim_folder(lines_file, header, resume=request.resume)


def _line_text(line: dict[str, Any]) -> str:
    """One line for a person; the truth is told, since the case is over."""
    if "not_made" in line:
        return f"case {line['number']}: not made: {line['not_made']}"
    score = line["score"]
    told = "+".join(score["verdict"])
    if score["ambiguous_with"]:
        told += f" (or {', '.join(score['ambiguous_with'])})"
    return (
        f"case {line['number']}: {score['vehicle']}, {'+'.join(score['truth'])} at "
        f"{score['gap_ratio']:.1f} x floor: {told}, {score['elapsed_s']:.1f} s"
    )
