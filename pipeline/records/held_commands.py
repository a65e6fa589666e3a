"""Commands that are held until the next one, on the time base of a table."""

import numpy as np

from pipeline.types import FloatArray

#: Times that agree to this are the same: stamps are rounded, and so are steps. [s]
_SAME_S = 1e-6
#: Decimals of a mean: what differences of long sums leave beyond them is round-off.
_DIGITS = 9


def mean_held(
    sent_s: FloatArray, values: FloatArray, time_s: FloatArray, step_s: float
) -> FloatArray:
    """Mean of the commands that hold over the step which begins at each row.

    A simulation takes one command a step. Where a new one comes in mid-step, either of the two
    alone would be up to a step early or late: a tenth of the lag of many drives, and plain to see
    for an accelerometer. The mean leaves a lagging drive where the two in turn leave it, but for
    what the lag forgets within a step.

    Parameters
    ----------
    sent_s : ndarray, shape (n,)
        When each command was sent, ascending. [s]
    values : ndarray, shape (n, k)
        The commands; the first is taken to have held before, too.
    time_s : ndarray, shape (m,)
        Begins of the steps. [s]
    step_s : float
        Their length. [s]

    Returns
    -------
    ndarray, shape (m, k)

    Examples
    --------
    >>> import numpy as np
    >>> sent_s, codes = np.array([0.0, 0.05]), np.array([[10.0], [20.0]])
    >>> mean_held(sent_s, codes, np.array([0.02, 0.04, 0.06]), 0.02).ravel().tolist()
    [10.0, 15.0, 20.0]
    """
    reached = np.concatenate(
        [np.zeros((1, values.shape[1])), np.cumsum(values[:-1] * np.diff(sent_s)[:, None], axis=0)]
    )

    def held_at(at_s: FloatArray) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], FloatArray]:
        index = np.clip(np.searchsorted(sent_s, at_s, side="right") - 1, 0, None)
        return index, reached[index] + values[index] * (at_s - sent_s[index])[:, None]

    first, begun = held_at(time_s + _SAME_S)
    last, ended = held_at(time_s + step_s - _SAME_S)
    mean = (ended - begun) / (step_s - 2.0 * _SAME_S)
    # one command alone is that command, not nearly so: thrusts have kinks at whole codes
    return np.where((first == last)[:, None], values[first], np.round(mean, _DIGITS))
