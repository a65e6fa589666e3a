"""The compiler's settings, and where compiled code is kept.

Numba keys its cache by the file of the compiled function alone: a change in another file that the
kernel is made of would go unnoticed and run stale physics. So the cache folder carries a digest of
every source file that takes part, and each state of the sources has a cache of its own.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])

#: Packages and files whose text the kernel is made of.
_PACKAGE = Path(__file__).resolve().parent.parent
KERNEL_SOURCES = (
    _PACKAGE / "physics" / "parameters.py",
    *sorted((_PACKAGE / "simulate").glob("kernel*.py")),
    Path(__file__),
)


def sources_digest() -> str:
    """Digest of the kernel's sources, 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for path in KERNEL_SOURCES:
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Folder of the compiled code for these sources.

    ``RIG2SEA_CACHE`` overrides the place; else the user's cache folder (``XDG_CACHE_HOME``).
    """
    base = os.environ.get("RIG2SEA_CACHE")
    root = (
        Path(base)
        if base
        else Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "rig2sea"
    )
    return root / f"kernel-{sources_digest()}"


def compiled(function: Function) -> Function:
    """Compile a function with the project's settings: no fast-math, no GIL, cached on disk.

    Without fast-math a run is the same bit for bit on one machine, and a NaN stays a NaN.
    """
    import numba

    # the stubs do not know the setting, which numba reads when a function is compiled
    numba.config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]
    return cast("Function", numba.njit(cache=True, nogil=True, error_model="numpy")(function))
