"""Long series for drawing: fewer points, every peak kept."""

from itertools import pairwise

import numpy as np

from pipeline.types import FloatArray

#: A figure is drawn some 320 points wide; twice that shows all that can be seen.
BUCKETS = 400


def thinned(x: FloatArray, values: FloatArray, buckets: int) -> tuple[FloatArray, FloatArray]:
    """Keep the lowest and the highest value of each stretch, and the breaks between a few pieces.

    Parameters
    ----------
    x, values : ndarray, shape (k,)
        x rising; values not a number break the line, of many pieces where a stretch has no other.
    buckets : int
        Number of stretches; series of up to twice as many points are kept as they are.

    Returns
    -------
    tuple of ndarray
        At most some three points for each stretch.

    Examples
    --------
    >>> x = np.arange(10_000) / 100
    >>> values = np.sin(x); values[5_000], values[7_000] = 9.0, np.nan
    >>> shown_x, shown = thinned(x, values, 50)
    >>> len(shown) <= 150, float(np.nanmax(shown)), float(shown_x[np.nanargmax(shown)])
    (True, 9.0, 50.0)
    >>> int(np.isnan(shown).sum())
    1
    """
    finite = np.isfinite(values)
    starts = np.flatnonzero(finite & ~np.concatenate([[False], finite[:-1]]))
    if finite.sum() <= 2 * buckets or len(starts) > buckets // 4:
        return _peaks(x, values, buckets)
    ends = np.flatnonzero(finite & ~np.concatenate([finite[1:], [False]])) + 1
    pieces: list[tuple[FloatArray, FloatArray]] = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        if pieces:
            pieces.append((x[start : start + 1], np.array([np.nan])))
        share = max(round(buckets * (end - start) / finite.sum()), 2)
        pieces.append(_peaks(x[start:end], values[start:end], share))
    return np.concatenate([one for one, _ in pieces]), np.concatenate([one for _, one in pieces])


def _peaks(x: FloatArray, values: FloatArray, buckets: int) -> tuple[FloatArray, FloatArray]:
    """Keep the lowest and the highest value of each stretch, in their order."""
    finite = np.isfinite(values)
    if finite.sum() <= 2 * buckets:
        kept = finite | np.concatenate([[False], finite[:-1]])
        return x[kept], values[kept]
    span = float(x[-1] - x[0]) or 1.0
    bucket = np.minimum(((x - x[0]) / span * buckets).astype(int), buckets - 1)
    kept_rows: list[int] = []
    edges = np.searchsorted(bucket, np.arange(buckets + 1))
    for begin, end in pairwise(edges.tolist()):
        rows = np.arange(begin, end)[finite[begin:end]]
        if rows.size:
            own = values[rows]
            kept_rows += sorted({int(rows[own.argmin()]), int(rows[own.argmax()])})
        elif end > begin:
            kept_rows.append(begin)  # an empty stretch breaks the line
    return x[kept_rows], values[kept_rows]
