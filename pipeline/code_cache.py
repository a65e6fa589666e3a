"""Compile a function and keep the code in a folder that is named by a digest of its sources.

Numba finds kept code by where the source lies and by its time, so every copy of the same sources
would be compiled anew. Here the folder says what the code is made of, and that is enough.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])


class ByFolder:
    """Says where numba keeps the code of a function: its interface, told by the name below."""

    def __init__(self, folder: Path, line: int) -> None:
        self._folder = folder
        self._line = line

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> "ByFolder":
        """Return the place of a function of a file; files of two folders may have one name."""
        import numba

        stated = Path(numba.config.CACHE_DIR)  # type: ignore[attr-defined]  # set below
        return cls(stated / Path(file).parent.name, function.__code__.co_firstlineno)

    def ensure_cache_path(self) -> None:
        """Make the folder and see that it can be written."""
        self._folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=self._folder).close()

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return the same for all: other sources have another folder."""
        return "by folder"

    def get_disambiguator(self) -> str:
        """Return the line, for functions of one name."""
        return str(self._line)


def kept_in(folder: Path, function: Function, **settings: Any) -> Function:  # noqa: ANN401
    """Compile a function, without fast-math and without the GIL; keep the code in a folder.

    Parameters
    ----------
    folder : Path
        Its name holds a digest of all sources that the function is made of.
    function : callable
        What to compile.
    **settings
        More of numba's.
    """
    import numba

    # where kept code is looked for is settled when a function is decorated
    config: Any = numba.config
    before = config.CACHE_LOCATOR_CLASSES
    config.CACHE_DIR = str(folder)
    config.CACHE_LOCATOR_CLASSES = f"{__name__}.{ByFolder.__name__}"
    try:
        return cast(
            "Function",
            numba.njit(cache=True, nogil=True, error_model="numpy", **settings)(function),
        )
    finally:
        config.CACHE_LOCATOR_CLASSES = before
