"""Words, units and usual channels of the readers: data files that stand beside this module."""

import functools
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any


@functools.cache
def data_of(name: str) -> Mapping[str, Any]:
    """Return what ``<name>.toml`` holds, read once.

    >>> next(iter(data_of("units")["force"]))
    'newton'
    """
    return tomllib.loads(Path(__file__).with_name(f"{name}.toml").read_text(encoding="utf-8"))
