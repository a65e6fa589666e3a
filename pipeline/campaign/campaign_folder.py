"""The folder of a campaign: ``campaign.json`` says which it is, so that only that one goes on."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pipeline.errors import InputError, Place
from pipeline.provenance import write_atomically

HEADER_FILE = "campaign.json"


def claim_folder(lines_file: Path, header: Mapping[str, Any], *, resume: bool) -> None:
    """Write what a campaign is, or check that the folder holds this one.

    Parameters
    ----------
    lines_file : Path
        Lines of its cases.
    header : mapping
        What makes its cases what they are.
    resume : bool
        Whether it may be there already.

    Raises
    ------
    InputError
        When the folder holds a campaign and `resume` is not set, or another campaign.
    """
    file = lines_file.with_name(HEADER_FILE)
    if lines_file.is_file() and not resume:
        raise InputError.at(
            Place(str(lines_file)),
            "there is a campaign in this folder already.",
            remedy="Give --resume to go on with it, or another folder with --to.",
        )
    if lines_file.is_file() and file.is_file():
        before = read_header(file, header["schema"])
        differ = [key for key in header if before.get(key) != header[key]]
        if differ:
            raise InputError.at(
                Place(str(file)),
                f"the campaign in this folder has another {', '.join(differ)}.",
                expected="the same seed, vehicles and program: its cases would not be alike.",
                remedy="Begin a new campaign in another folder with --to.",
            )
    try:
        write_atomically(file, json.dumps(header, indent=1))
    except InputError as error:
        # the folder of a campaign has an option of its own
        remedy = error.problem.remedy.replace("--out", "--to")
        raise InputError(replace(error.problem, remedy=remedy)) from None


def read_header(file: Path, schema: str) -> dict[str, Any]:
    """Read what a campaign is.

    Raises
    ------
    InputError
        When the file is not there or something else.
    """
    fault = "is not the header of a campaign."
    try:
        header = json.loads(file.read_text(encoding="utf-8"))
        if isinstance(header, dict):
            return header
    except OSError as error:
        fault = f"cannot be read: {error.strerror}."
    except (ValueError, RecursionError):
        pass
    raise InputError.at(
        Place(str(file)),
        fault,
        expected=f'a JSON object with "schema": "{schema}".',
        remedy="Put the file back that was there, or begin in another folder with --to.",
    )
