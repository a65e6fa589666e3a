"""Long series for drawing: fewer points, every peak kept."""

from itertools import pairwise

import numpy as np

from pipeline.types import FloatArray

#: A figure is drawn some 320 points wide; twice that shows all that can be seen.
BUCKETS = 400


def decimated(
    time_s: FloatArray, values: FloatArray, buckets: int = BUCKETS
) -> tuple[FloatArray, FloatArray]:
    """Keep the lowest and the highest value of each stretch of time, in their order.

    Parameters
    ----------
    time_s : ndarray, shape (n,)
        Rising. [s]
    values : ndarray, shape (n,)
        Not a number in gaps: a gap wider than a stretch stays one.
    buckets : int
        Number of stretches; series of up to twice as many points are kept as they are.

    Returns
    -------
    tuple of ndarray
        Times and values, at most ``3 * buckets``.

    Examples
    --------
    >>> time_s = np.arange(10_000) / 100
    >>> values = np.sin(time_s); values[5_000] = 9.0
    >>> shown_s, shown = decimated(time_s, values, 50)
    >>> len(shown) <= 150, float(shown.max()), float(shown_s[shown.argmax()])
    (True, 9.0, 50.0)
    """
    finite = np.isfinite(values)
    if finite.sum() <= 2 * buckets:
        return _with_breaks(time_s, values, finite)
    span = float(time_s[-1] - time_s[0]) or 1.0
    bucket = np.minimum(((time_s - time_s[0]) / span * buckets).astype(int), buckets - 1)
    kept: list[int] = []
    edges = np.searchsorted(bucket, np.arange(buckets + 1))
    for begin, end in pairwise(edges.tolist()):
        rows = np.arange(begin, end)[finite[begin:end]]
        if rows.size:
            own = values[rows]
            kept += sorted({int(rows[own.argmin()]), int(rows[own.argmax()])})
        elif end > begin:
            kept.append(begin)  # an empty stretch breaks the line
    index = np.array(kept, int)
    return time_s[index], values[index]


def thinned(x: FloatArray, values: FloatArray, buckets: int) -> tuple[FloatArray, FloatArray]:
    """Keep peaks, and the breaks of a line that is made of a few pieces.

    Parameters
    ----------
    x, values : ndarray, shape (k,)
        x rising; values not a number break the line.
    buckets : int
        Stretches that keep their lowest and highest value.

    Returns
    -------
    tuple of ndarray
        At most some three points for each stretch.

    Examples
    --------
    >>> x = np.linspace(0.0, 9.0, 2000)
    >>> values = np.where(np.arange(2000) == 900, np.nan, x)
    >>> [int(np.isnan(f(x, values, 50)[1]).sum()) for f in (thinned, decimated)]
    [1, 0]
    """
    finite = np.isfinite(values)
    starts = np.flatnonzero(finite & ~np.concatenate([[False], finite[:-1]]))
    if finite.sum() <= 2 * buckets or len(starts) > buckets // 4:
        return decimated(x, values, buckets)
    ends = np.flatnonzero(finite & ~np.concatenate([finite[1:], [False]])) + 1
    pieces: list[tuple[FloatArray, FloatArray]] = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        if pieces:
            pieces.append((x[start : start + 1], np.array([np.nan])))
        share = max(round(buckets * (end - start) / finite.sum()), 2)
        pieces.append(decimated(x[start:end], values[start:end], share))
    return np.concatenate([one for one, _ in pieces]), np.concatenate([one for _, one in pieces])


def _with_breaks(
    time_s: FloatArray, values: FloatArray, finite: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
) -> tuple[FloatArray, FloatArray]:
    """Keep all finite values, and one of each gap between them."""
    before = np.concatenate([[False], finite[:-1]])
    kept = finite | before
    return time_s[kept], np.where(finite, values, np.nan)[kept]
