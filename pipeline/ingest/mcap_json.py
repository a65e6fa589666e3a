"""Decode one JSON message."""

import json
from typing import Any

from pipeline.ingest.mcap_types import BrokenMessageError

_MAX_BYTES = 16_000_000


def decode_json(data: memoryview | bytes) -> dict[str, Any]:
    """Decode a message.

    Raises
    ------
    BrokenMessageError
        If it is not a JSON object. ``NaN`` and ``Infinity`` are understood.

    Examples
    --------
    >>> decode_json(b'{"depth": 1.5}')
    {'depth': 1.5}
    """
    if len(data) > _MAX_BYTES:
        raise BrokenMessageError(f"it has {len(data)} bytes; at most {_MAX_BYTES} are read")
    try:
        found = json.loads(bytes(data))
    except (ValueError, RecursionError) as error:
        raise BrokenMessageError(f"it is not JSON ({str(error)[:80]})") from None
    if not isinstance(found, dict):
        raise BrokenMessageError(f"it is a JSON {type(found).__name__}, not an object")
    return found
