"""Compile the truth's kernel; the cache folder is named by a digest of its sources.

Numba notices a change in the file of a function alone, not in the files of what it calls.
"""

import hashlib
import os
import platform
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from pipeline.code_cache import kept_in

Function = TypeVar("Function", bound=Callable[..., Any])

_HERE = Path(__file__).resolve().parent


@cache
def cache_folder() -> Path:
    """Folder of the compiled code for these sources; among temporary files where none is kept."""
    import numba
    import numpy as np

    digest = hashlib.sha256()
    for version in (platform.python_version(), np.__version__, numba.__version__):
        digest.update(f"{version}\n".encode())
    for path in sorted((*_HERE.glob("kernel*.py"), _HERE / "compiled.py")):
        digest.update(path.name.encode() + path.read_bytes())
    base = os.environ.get("RIG2SEA_CACHE")
    home = os.environ.get("XDG_CACHE_HOME")
    try:
        root = Path(base) if base else (Path(home) if home else Path.home() / ".cache") / "rig2sea"
        folder = root / f"truth-{digest.hexdigest()[:16]}"
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, RuntimeError):  # RuntimeError: there is no home
        return Path(tempfile.mkdtemp(prefix="rig2sea-truth-"))


def _compile(function: Function, **settings: Any) -> Function:  # noqa: ANN401 (numba's settings)
    return kept_in(cache_folder(), function, **settings)


def compiled(function: Function) -> Function:
    """Compile a function: no fast-math, no GIL, kept on disk."""
    return _compile(function, no_cfunc_wrapper=True)


def inlined(function: Function) -> Function:
    """Compile a function that makes no arrays into its callers, without counting references."""
    return _compile(
        function, forceinline=True, _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True
    )
