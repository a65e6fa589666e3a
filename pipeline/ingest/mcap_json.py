"""Decode one JSON message."""

import json
from typing import Any

from pipeline.ingest.mcap_types import BrokenMessageError

_MAX_BYTES = 16_000_000
_MAX_DEPTH = 50


def decode_json(data: memoryview | bytes) -> dict[str, Any]:
    """Decode a message.

    Raises
    ------
    BrokenMessageError
        If it is not a JSON object, or nested deeper than 50 levels. ``NaN`` and ``Infinity`` are
        understood.

    Examples
    --------
    >>> decode_json(b'{"depth": 1.5}')
    {'depth': 1.5}
    """
    data = bytes(data)
    if len(data) > _MAX_BYTES:
        raise BrokenMessageError(f"it has {len(data)} bytes; at most {_MAX_BYTES} are read")
    try:
        found = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise BrokenMessageError(f"it is not JSON ({str(error)[:80]})") from None
    if not isinstance(found, dict):
        raise BrokenMessageError(f"it is a JSON {type(found).__name__}, not an object")
    # brackets in texts count here, too: whether it is deep the walk decides
    if data.count(b"{") + data.count(b"[") > _MAX_DEPTH and _is_too_deep(found):
        raise BrokenMessageError("it is nested deeper than 50 levels")
    return found


def _is_too_deep(tree: dict[str, Any]) -> bool:
    level: list[Any] = [tree]
    for _ in range(_MAX_DEPTH):
        level = [
            part
            for node in level
            for part in (node.values() if isinstance(node, dict) else node)
            if isinstance(part, dict | list)
        ]
    return bool(level)
