"""Compile a function and keep the code in a folder that is named by a digest of its sources.

Numba finds kept code by where the source lies and by its time, so every copy of the same sources
would be compiled anew. Here the folder says what the code is made of, and that is enough.

One process compiles a function, others that need it wait and load it. What the function calls is
compiled under its lock: locks are taken from callers to callees, and none waits in a ring.
"""

import fcntl
import os
import stat
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import IO, Any, TypeVar, cast

import numba
from numba.core import caching

Function = TypeVar("Function", bound=Callable[..., Any])

#: How often a process looks whether another has compiled, before it does it itself: for a minute.
_LOOKS, _PAUSE_S = 3000, 0.02
_Code: Any = caching.CompileResultCacheImpl  # numba has no types
_Cache: Any = caching.FunctionCache


class _InFolder(_Code):  # type: ignore[misc]  # a base without types
    """Where the code of a function is kept; files of two folders may have one name."""

    def __init__(self, folder: Path, function: Callable[..., Any]) -> None:
        code = function.__code__
        self._locator, self._lineno = self, code.co_firstlineno
        self._folder = folder / Path(code.co_filename).parent.name
        self._filename_base = f"{Path(code.co_filename).stem}.{function.__name__}-{self._lineno}"
        self.get_cache_path = partial(str, self._folder)
        self.get_source_stamp = partial(str, "by folder")  # other sources have another folder
        self.ensure_cache_path = partial(self._folder.mkdir, parents=True, exist_ok=True)


class _CompiledOnce(_Cache):  # type: ignore[misc]  # a base without types
    """The kept code of a function, which one process at a time compiles."""

    _lock: IO[bytes] | None = None

    def __init__(self, folder: Path, function: Callable[..., Any]) -> None:
        self._impl_class = partial(_InFolder, folder)
        super().__init__(function)

    def load_overload(self, sig: object, target_context: object) -> object:
        """Return the code; None to whoever is to compile it."""
        found = super().load_overload(sig, target_context)
        if found is None and self._lock is None:
            self._lock = _locked(Path(self.cache_path, f"{self._impl.filename_base}.lock"))
            found = super().load_overload(sig, target_context)
            if found is not None:
                self._unlock()
        return found

    def save_overload(self, sig: object, data: object) -> None:
        """Keep the code, and let the others have it."""
        super().save_overload(sig, data)
        self._unlock()

    def _unlock(self) -> None:
        if self._lock is not None:
            self._lock.close()
        self._lock = None


def _locked(path: Path) -> IO[bytes] | None:
    """Wait for the lock; None where files cannot be locked, or it takes too long."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        file = path.open("wb")
        for _ in range(_LOOKS):
            with suppress(BlockingIOError):
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return file
            time.sleep(_PAUSE_S)
        file.close()
    return None


def cache_root() -> Path:
    """Folder of all caches: ``RIG2SEA_CACHE``, else one in the user's cache folder.

    Where nothing can be written there, a folder among the temporary files takes its place, and a
    line on standard error says so.
    """
    base = os.environ.get("RIG2SEA_CACHE")
    try:
        root = (
            Path(base)
            if base
            else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "rig2sea"
        )
        root.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=root):
            return root
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home
        root = _temporary_root()
        print(
            f"note: compiled code cannot be kept in the cache folder ({error}); it is kept in "
            f"{root}. Set RIG2SEA_CACHE to a folder that can be written.",
            file=sys.stderr,
        )
        return root


def _temporary_root() -> Path:
    """Return a folder of ours alone among the temporary files: code is loaded from it."""
    root = Path(tempfile.gettempdir()) / f"rig2sea-{os.getuid()}"
    try:
        root.mkdir(mode=0o700, exist_ok=True)
        state = root.lstat()
    except OSError:
        return Path(tempfile.mkdtemp(prefix="rig2sea-"))
    ours = stat.S_ISDIR(state.st_mode) and state.st_uid == os.getuid()
    return root if ours and not state.st_mode & 0o022 else Path(tempfile.mkdtemp(prefix="rig2sea-"))


def kept_in(folder: Path, function: Function, **settings: Any) -> Function:  # noqa: ANN401
    """Compile a function, without fast-math and without the GIL; keep the code in a folder.

    The folder's name holds a digest of all sources that the function is made of; `settings` are
    more of numba's.
    """
    found: Any = numba.njit(nogil=True, error_model="numpy", **settings)(function)
    found._cache = _CompiledOnce(folder, function)  # noqa: SLF001 - as cache=True does
    return cast("Function", found)
