"""Array types used in signatures throughout."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
#: What a physics function accepts where it broadcasts: a number or an array of numbers.
ArrayLike = float | Sequence[float] | npt.NDArray[np.floating[Any]]
