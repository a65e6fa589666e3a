"""Compile the truth's kernel; the cache folder is named by a digest of its sources.

Numba notices a change in the file of a function alone, not in the files of what it calls.
"""

import hashlib
import platform
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
import numpy as np

from pipeline.code_cache import cache_root, kept_in

Function = TypeVar("Function", bound=Callable[..., Any])

_HERE = Path(__file__).resolve().parent


@cache
def cache_folder() -> Path:
    """Folder of the compiled code for these sources."""
    versions = (platform.python_version(), np.__version__, numba.__version__)
    digest = hashlib.sha256("\n".join(versions).encode())
    for path in sorted((*_HERE.glob("kernel*.py"), _HERE / "compiled.py")):
        digest.update(path.name.encode() + path.read_bytes())
    folder = cache_root() / f"truth-{digest.hexdigest()[:16]}"
    folder.mkdir(exist_ok=True)
    return folder


def compiled(function: Function) -> Function:
    """Compile a function: no fast-math, no GIL, kept on disk."""
    return kept_in(cache_folder(), function, no_cfunc_wrapper=True)


def inlined(function: Function) -> Function:
    """Compile a function that makes no arrays into its callers, without counting references."""
    return kept_in(
        cache_folder(),
        function,
        forceinline=True,
        _nrt=False,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )
