"""The compiler's settings, and where compiled code is kept.

Numba keys its cache by the file of the compiled function alone: a change in another file that the
kernel is made of would go unnoticed and run stale physics. So the cache folder carries a digest of
every source file that takes part, and of the versions that compile it; each state has a cache of
its own. (The processor is part of numba's own key.)
"""

import contextlib
import hashlib
import os
import platform
import re
import shutil
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
import numpy as np

from pipeline.code_cache import cache_root, kept_in

Function = TypeVar("Function", bound=Callable[..., Any])

_PACKAGE = Path(__file__).resolve().parent.parent
_IMPORT = re.compile(
    r"^\s*(?:from\s+pipeline([\w.]*)\s+import\s+\(?([^\n#]*)|import\s+pipeline([\w.]*))",
    re.MULTILINE,
)
#: Caches of other states of the sources: so many stay, and any that was used so short a time ago.
KEPT_CACHES = 4
KEPT_SECONDS = 86400.0


def kernel_sources(package: Path = _PACKAGE) -> tuple[Path, ...]:
    """Files whose text the kernel is made of: ``simulate/kernel*.py`` and all that they import."""
    found: dict[Path, None] = {}
    waiting = [package / "simulate" / "compiled.py", *(package / "simulate").glob("kernel*.py")]
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found[path] = None
        for base, names, plain in _IMPORT.findall(path.read_text(encoding="utf-8")):
            parts = [part for part in (base or plain).split(".") if part]
            module = package.joinpath(*parts)
            # what is imported from a package can be a module of it
            inside = [module / f"{name.strip()}.py" for name in names.split(",") if name.strip()]
            candidates = (module.with_suffix(".py"), module / "__init__.py", *inside)
            waiting.extend(candidate for candidate in candidates if candidate.is_file())
    return tuple(sorted(found))


def kernel_digest(package: Path = _PACKAGE) -> str:
    """Digest of the kernel's sources and of what compiles them, 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for version in (platform.python_version(), np.__version__, numba.__version__):
        digest.update(f"{version}\n".encode())
    for path in kernel_sources(package):
        digest.update(f"{path.relative_to(package).as_posix()}\n".encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


def prune(root: Path, now_s: float) -> list[Path]:
    """Delete caches of states that are gone, and return them.

    The newest `KEPT_CACHES` stay, and so does any used within `KEPT_SECONDS` of `now_s`: another
    process may be at work in it.
    """
    caches = []
    for path in root.glob("kernel-*"):
        if re.fullmatch(r"kernel-[0-9a-f]{16}", path.name) and not path.is_symlink():
            with contextlib.suppress(OSError):  # another process was faster
                caches.append((path.stat().st_mtime, path))
    caches.sort(reverse=True)
    old = [path for used_s, path in caches[KEPT_CACHES:] if now_s - used_s > KEPT_SECONDS]
    for path in old:
        shutil.rmtree(path, ignore_errors=True)
    return old


@cache
def cache_folder() -> Path:
    """Folder of the compiled code for these sources; made, marked as used, and old ones deleted."""
    root = cache_root()
    folder = root / f"kernel-{kernel_digest()}"
    if folder.is_dir():
        with contextlib.suppress(OSError):  # another user's stays while its owner uses it
            os.utime(folder)
    else:
        folder.mkdir(exist_ok=True)
        prune(root, time.time())
    return folder


_KNOWN_SOURCES = frozenset(kernel_sources())


def _compile(function: Function, **settings: Any) -> Function:  # noqa: ANN401 (numba's settings)
    source = Path(function.__code__.co_filename).resolve()
    if source not in _KNOWN_SOURCES:
        raise RuntimeError(
            f"{source} is compiled but not among the kernel's sources, so its changes would go "
            "unnoticed: name the file kernel_*.py, or import it in one"
        )
    return kept_in(cache_folder(), function, **settings)


def compiled(function: Function) -> Function:
    """Compile a function with the project's settings: no fast-math, no GIL, cached on disk.

    Without fast-math a run is the same bit for bit on one machine, and a NaN stays a NaN.
    """
    return _compile(function, no_cfunc_wrapper=True)


def within(function: Function) -> Function:
    """Compile a function that is called from compiled code alone; it may make arrays.

    What Python would need to call it, and to take its tuples of arrays, took a third of compiling.
    """
    return _compile(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def inlined(function: Function) -> Function:
    """Compile a function that makes no arrays, into its callers.

    As `compiled`; besides, the arrays' reference counts are left alone, which in a function of a
    few dozen multiplications take longer than the multiplications, and the function's body takes
    the place of a call. Such a function works on arrays that its caller made. Like one of `within`
    it cannot be called from Python (`kernel_alone`).
    """
    return _compile(
        function, forceinline=True, _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True
    )
