"""Names of runs are safe as paths and apart from each other; days come from the log."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from season_cases import FIRST_NS, write_log

from pipeline.ingest.log_files import day_of, is_closed, log_start_ns
from pipeline.plan import VehicleFolder
from pipeline.workflow.pool_runs import (
    PoolLog,
    day_problems,
    pool_logs,
    pool_problems,
    run_name,
)

BOAT = VehicleFolder("boat", "raw/boat")


@given(st.text(min_size=1, max_size=60))
def test_name_is_safe_whatever_the_file_is_called(text: str) -> None:
    name = run_name(text + ".mcap")
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", name)


@given(st.lists(st.text(min_size=1, max_size=20), min_size=2, max_size=20, unique=True))
def test_two_files_never_share_a_name(texts: list[str]) -> None:
    names = [run_name(text + ".mcap") for text in texts]
    assert len(set(names)) == len(names)


def test_endings_that_differ_in_case_are_two_runs() -> None:
    assert run_name("a.mcap") == "a"
    assert run_name("a.MCAP") != "a"


def test_what_lies_in_the_folder(tmp_path: Path) -> None:
    pool = tmp_path / "raw/boat/pool"
    for name in ("b.mcap", "a <i>{x}.mcap", ".hidden.mcap", "c.xlsx", "b.yaml", "readme.txt"):
        write_log(pool / name, FIRST_NS)
    logs = pool_logs(BOAT, tmp_path)
    assert [Path(log.path).name for log in logs] == ["a <i>{x}.mcap", "b.mcap"]
    assert logs[1].notes == "raw/boat/pool/b.yaml"
    (problem,) = pool_problems(BOAT, tmp_path)
    assert "c.xlsx" in str(problem)
    assert "no log by its name" in str(problem)


def test_link_that_leads_nowhere_or_round_is_no_run(tmp_path: Path) -> None:
    """One that leads round stopped the whole run with a fault of the program."""
    pool = tmp_path / "raw/boat/pool"
    write_log(pool / "b.mcap", FIRST_NS)
    (pool / "linked.mcap").symlink_to("b.mcap")
    (pool / "gone.mcap").symlink_to("nothing.mcap")
    (pool / "round.mcap").symlink_to("round.mcap")
    assert [log.run for log in pool_logs(BOAT, tmp_path)] == ["b", "linked"]
    assert pool_problems(BOAT, tmp_path) == ()


@pytest.mark.parametrize(
    ("content", "start"),
    [
        (b"", None),
        (b"hello, this is no log at all........", None),
        (b"\x89MCAP0\r\n", None),
        (b"\x89MCAP0\r\n\x06\x10\x00\x00\x00\x00\x00\x00\x00\x01", None),
        (b"\x89MCAP0\r\n\x05\x16" + bytes(7 + 6) + (7).to_bytes(8, "little"), 7),
        (b"\x89MCAP0\r\n\x06" + (16).to_bytes(8, "little") + b"\xff" * 16, 2**64 - 1),
        (b"\x89MCAP0\r\n\x01" + b"\xff" * 8, None),
    ],
)  # fmt: skip
def test_start_of_a_log_from_its_first_bytes(
    tmp_path: Path, content: bytes, start: int | None
) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    assert log_start_ns(path) == start


def test_day_is_that_of_utc(tmp_path: Path) -> None:
    midnight = 1_777_075_200_000_000_000
    for start, day in ((midnight - 1, "2026-04-24"), (midnight, "2026-04-25")):
        write_log(tmp_path / "a.mcap", start, closed=start == midnight)
        assert day_of(tmp_path / "a.mcap") == day
        assert is_closed(tmp_path / "a.mcap") == (start == midnight)


@pytest.mark.parametrize(
    ("name", "day"),
    [
        ("rosbag2_2026_04_25-08_00_01", "2026-04-25"),  # Vladivostok, UTC+10
        ("20260425 pitch", "2026-04-25"),
        ("2026-04-24", "2026-04-24"),
        ("2026-04-23", "2026-04-24"),  # no time zone has that date any more
        ("2026-04-26", "2026-04-24"),
        ("2026-13-40", "2026-04-24"),
        ("trial 3 of 20260425123", "2026-04-24"),  # a number that is no date
    ],
)
def test_the_local_date_in_the_name_is_the_day_where_the_time_agrees(
    tmp_path: Path, name: str, day: str
) -> None:
    """A working day of UTC+10 from 8 to 18 h begins on the day before in UTC."""
    at_22_utc = 1_777_075_200_000_000_000 - 2 * 3600 * 10**9
    write_log(tmp_path / f"{name}.mcap", at_22_utc)
    assert day_of(tmp_path / f"{name}.mcap") == day


def test_the_date_in_the_name_is_the_day_where_the_clock_was_not_set(tmp_path: Path) -> None:
    write_log(tmp_path / "2026-04-25 run.mcap", 40 * 10**9)
    write_log(tmp_path / "run.mcap", 40 * 10**9)
    assert day_of(tmp_path / "2026-04-25 run.mcap") == "2026-04-25"
    assert day_of(tmp_path / "run.mcap") == "undated"


def test_two_logs_whose_names_make_one_run_are_kept_apart(tmp_path: Path) -> None:
    pool = tmp_path / "raw/boat/pool"
    other = run_name("dive 1?.mcap")
    for name in ("dive 1?.mcap", f"{other}.mcap"):
        write_log(pool / name, FIRST_NS)
    runs = [log.run for log in pool_logs(BOAT, tmp_path)]
    assert len(runs) == 2
    assert len(set(runs)) == 2
    assert other in runs


def test_a_name_that_says_another_day_than_the_log_is_told() -> None:
    logs = [PoolLog("a", "raw/boat/pool/2026-05-04-a.mcap"), PoolLog("b", "raw/boat/pool/b.mcap")]
    assert day_problems("boat", logs, {"a": "2026-05-04", "b": "2026-05-09"}) == []
    (told,) = day_problems("boat", logs, {"a": "2026-05-09", "b": "2026-05-09"})
    assert told.severity == "warning"
    assert "says 2026-05-04, the times in the log say 2026-05-09" in told.what
