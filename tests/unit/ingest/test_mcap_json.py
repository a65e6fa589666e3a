"""JSON messages: how deep they may be nested."""

from pathlib import Path

import pytest
from pool_logs import json_topic, rov, ticks, write_log

from pipeline.ingest.message_definitions import BrokenMessageError
from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_codec import decode_json


def nested(levels: int) -> bytes:
    """An object in which objects and arrays take turns, so many levels in all."""
    opened = ['{"a": ' if level % 2 == 0 else "[" for level in range(levels)]
    closed = ["}" if level % 2 == 0 else "]" for level in range(levels)]
    return "".join([*opened, "1.5", *reversed(closed)]).encode()


@pytest.mark.parametrize("levels", [1, 2, 49, 50])
def test_a_message_of_fifty_levels_is_read(levels: int) -> None:
    assert isinstance(decode_json(nested(levels)), dict)


@pytest.mark.parametrize("levels", [51, 52, 900, 100_000])
def test_a_message_that_is_nested_deeper_is_refused(levels: int) -> None:
    with pytest.raises(BrokenMessageError):
        decode_json(nested(levels))


def test_any_other_bracket_counts_for_nothing() -> None:
    wide = b'{"a": [' + b"[1]," * 500 + b'[2]], "b": "' + b"[{" * 500 + b'"}'
    assert decode_json(wide)["a"][-1] == [2]
    for encoding in ("utf-16", "utf-32"):
        assert decode_json(wide.decode().encode(encoding)) == decode_json(wide)
        with pytest.raises(BrokenMessageError, match="50 levels"):
            decode_json(nested(60).decode().encode(encoding))


@pytest.mark.parametrize("field", [None, "a"])
def test_a_log_of_deep_messages_is_read(tmp_path: Path, field: str | None) -> None:
    """Paths into a message are found by going down into it, level by level."""
    deep = json_topic("/deep", ticks(5, 10.0), [{}] * 5)
    deep.messages = [nested(900)] * 5
    depth = json_topic("/depth", ticks(5, 10.0), [{"depth": 1.0 + k} for k in range(5)])
    path = write_log(tmp_path / "run.mcap", [deep, depth])
    asked = {"quantity": "depth", "topic": "/deep"} | ({} if field is None else {"field": field})
    run = read_pool_run(
        path, rov(channels=[asked, {"quantity": "voltage", "topic": "/depth", "field": "depth"}]),
        tmp_path,
    )  # fmt: skip
    assert set(run.channels) == {"voltage"}
    assert "nested deeper than 50 levels" in "\n".join(map(str, run.problems))
