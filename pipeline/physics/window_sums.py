"""Sums over windows of rows, each in one subtraction."""

import numpy as np

from pipeline.types import FloatArray, IntArray


def sums_over(values: FloatArray, first: IntArray, end: IntArray) -> FloatArray:
    """Add up values (m, ...) from rows `first` (k,) to before `end` (k,): shape (k, ...).

    >>> import numpy as np
    >>> sums_over(np.array([1.0, 2.0, 4.0]), np.array([0, 1]), np.array([2, 3])).tolist()
    [3.0, 6.0]
    """
    total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    return np.asarray(total[end] - total[first])


def means_over(values: FloatArray, first: IntArray, end: IntArray) -> FloatArray:
    """Mean (k, ...) of the rows from `first` to before `end`; see `sums_over`."""
    count = (end - first).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(sums_over(values, first, end) / count)
