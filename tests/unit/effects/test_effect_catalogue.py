"""The library of effects for machines."""

import json

from pipeline.effects.library import effects, records


def test_records_are_json() -> None:
    """Strict JSON: a limit that is not there is null, not Infinity."""
    back = json.loads(json.dumps(records(), allow_nan=False))
    assert [entry["id"] for entry in back] == list(effects())
    dead_zone = next(entry for entry in back if entry["id"] == "dead_zone")
    assert dead_zone["parameters"][0]["possible"] == [0.0, None]
    assert dead_zone["parameters"][0]["unit"] == "code"
