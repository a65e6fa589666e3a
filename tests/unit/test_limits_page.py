"""The page of limits says what the readers hold to."""

import re
from pathlib import Path

import pytest

from pipeline.ingest import (
    cells,
    log_times,
    mcap_file,
    mcap_records,
    message_definitions,
    pool_run_codec,
    pool_run_extract,
)
from pipeline.ingest.cells import Limits
from pipeline.records import pool_schema
from pipeline.vehicle import run_notes, yaml_text
from pipeline.vehicle.schema import Vehicle

_MB, _MIB = 1e6, 1024 * 1024
_SHEET = Limits()
STATED = {
    "size": ("50 MB", _SHEET.max_bytes / _MB),
    "sheets": ("200", _SHEET.max_sheets),
    "rows of a sheet": ("200 000", _SHEET.max_rows),
    "columns": ("500", _SHEET.max_columns),
    "cells of a file": ("5 000 000", _SHEET.max_cells),
    "text of all cells": ("300 MB", _SHEET.max_text_bytes / _MB),
    "unpacked": ("300 MB", _SHEET.max_unpacked_bytes / _MB),
    "unpacked to packed size, of one part above 4 MB": ("200", _SHEET.max_ratio),
    "size of a number": ("1e30", cells.MOST),
    "keys and values": ("20 000", yaml_text.MAX_NODES),
    "levels of nesting": ("12", yaml_text.MAX_DEPTH),
    "elements that a `field` of `pool:` names": ("10 000", pool_schema._MOST_ELEMENTS),
    "unpacked chunk": ("256 MB", mcap_records.MAX_CHUNK_BYTES / _MIB),
    "all chunks unpacked": (
        "64 MB and 200 times the size of the log",
        mcap_records.MAX_UNPACKED_BYTES / _MIB,
    ),
    "summary, message index of a chunk": ("64 MB each", mcap_file._MAX_SUMMARY_BYTES / _MIB),
    "topics": ("20 000", mcap_records._MOST_CHANNELS),
    "a definition, a metadata record": ("1 MB each", mcap_records.MAX_RECORD_BYTES / _MB),
    "elements of an array in a definition": ("10 000 000", message_definitions._MAX_LENGTH),
    "characters of a ROS definition": ("200 000", message_definitions._MOST_CHARACTERS),
    "numbers of a protobuf message, sent or not": ("200 000", pool_run_codec._MOST_NUMBERS),
    "JSON message": ("16 MB", pool_run_extract._MAX_MESSAGE_BYTES / _MB),
    "log times that count for the length of the run": (
        "7 days from the median",
        log_times.LONGEST_RUN_NS / 86_400e9,
    ),
}


@pytest.fixture(scope="module")
def rows(repository: Path) -> list[list[str]]:
    text = (repository / "docs/limits.md").read_text(encoding="utf-8")
    return [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text.splitlines()
        if line.startswith("|") and not line.startswith("|---")
    ][1:]


@pytest.mark.parametrize("what", STATED)
def test_the_page_states_the_constant(rows: list[list[str]], what: str) -> None:
    shown, constant = STATED[what]
    assert shown in [row[2] for row in rows if row[1] == what]
    number = re.match(r"[0-9][0-9 ]*(e[0-9]+)?", shown)
    assert number is not None
    assert float(number[0].replace(" ", "")) == pytest.approx(constant)


def test_the_constants_that_share_a_row() -> None:
    assert mcap_file._MAX_INDEX_BYTES == mcap_file._MAX_SUMMARY_BYTES
    assert mcap_records.MAX_RATIO == 200
    assert message_definitions._MOST == pool_schema._MOST_ELEMENTS
    assert yaml_text.MAX_BYTES == 1e6
    assert run_notes._MAX_BYTES == 1e5
    assert Vehicle.model_json_schema()["properties"]["thrusters"]["maxItems"] == 12
