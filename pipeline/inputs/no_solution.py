"""Equations without a solution and results that are no numbers give a reason, no traceback."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from pydantic import ValidationError

from pipeline.errors import CannotComputeError

_MOST_NAMED = 4


@contextmanager
def with_reason(what: str) -> Iterator[None]:
    """Turn what linear algebra and the checks of a record raise into `CannotComputeError`.

    `what` is computed, for the sentence. A file that does not fit its schema is another matter: the
    readers of files say so themselves.
    """
    try:
        yield
    except np.linalg.LinAlgError as error:
        raise CannotComputeError(
            f"{what}: the equations have no solution ({error}). The data tell too little, or model "
            "and data are too far apart: check units and signs of the channels and the vehicle "
            "file."
        ) from None
    except ValidationError as error:
        wrong = [".".join(map(str, one["loc"])) for one in error.errors()]
        names = ", ".join(dict.fromkeys(wrong[:_MOST_NAMED]))
        raise CannotComputeError(
            f"{what}: {names} came out as no finite number. The data tell too little of it: check "
            "units and signs of the channels and the vehicle file."
        ) from None
