r"""Two cables of known shape: under a uniform load, and neutral in a uniform flow.

Both have the same shape. With the load (or the flow) as the downward direction, span h across it,
rise v against it and length L,

.. math:: \frac{\sinh x}{x} = \frac{\sqrt{L^2 - v^2}}{h}, \qquad c = \frac{h}{2 x},

and the arc length from the lowest point is :math:`c \tan\vartheta`. They differ in tension. Under a
load of w newtons a metre the component across the load is constant, :math:`H = w c`, and the
tension is :math:`\sqrt{H^2 + w^2 s^2}`. In a flow V with only normal drag,
:math:`k V^2 \sin^2\alpha` a metre at an angle alpha between tangent and flow, nothing pulls along
the cable: the tension T is constant, and :math:`T\,d\alpha/ds = k V^2 \sin^2\alpha` integrates to
:math:`\cot\alpha = -s / c` with :math:`T = k V^2 c` (s = 0 at the point furthest downstream).
"""

import numpy as np
from scipy.optimize import brentq

from pipeline.errors import CannotComputeError
from pipeline.types import ArrayLike, FloatArray


def catenary_parameter(span_m: float, rise_m: float, length_m: float) -> float:
    r"""Return x = h / (2 c) of :math:`\sinh(x) / x = \sqrt{L^2 - v^2} / h`. [-].

    The ends are h = `span_m` above zero apart across the load and v = `rise_m` of either sign along
    it; the length L is above their distance. [m]

    Raises
    ------
    CannotComputeError
        The cable does not reach, or there is no span.

    >>> x = catenary_parameter(2.0, 0.0, 2.0 * np.sinh(1.0))
    >>> round(x, 9)
    1.0
    """
    distance = float(np.hypot(span_m, rise_m))
    if not (np.isfinite([span_m, rise_m, length_m]).all() and span_m > 0 and length_m > distance):
        raise CannotComputeError(
            f"No catenary of {length_m:g} m between ends {span_m:g} m apart across the load and "
            f"{rise_m:g} m along it.\nExpected a span above zero and a cable longer than the "
            f"distance of {distance:.6g} m."
        )
    # (L - D)(L + D) keeps the digits of a cable that is hardly longer than the distance
    target = 0.5 * np.log1p((length_m - distance) * (length_m + distance) / span_m**2)

    def excess(x: float) -> float:
        if x < 0.01:
            return float(x**2 / 6 - x**4 / 180 - target)
        return float(x + np.log(-np.expm1(-2 * x) / (2 * x)) - target)

    upper = 1.0
    while excess(upper) < 0:
        upper *= 2
    return float(brentq(excess, 0.0, upper, xtol=1e-300, rtol=1e-14))


def uniform_load_cable(
    arc_length_m: ArrayLike,
    *,
    length_m: float,
    start_m: FloatArray,
    end_m: FloatArray,
    load_npm: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return shape and tension of an inextensible cable under a uniform load: the catenary.

    Parameters
    ----------
    arc_length_m : array_like, shape (n,)
        Distances along the cable from its start. [m]
    length_m, start_m, end_m : float, ndarray of shape (3,)
        Length and ends. [m]
    load_npm : ndarray, shape (3,)
        Force on a metre of cable, e.g. (0, 0, wet weight) in NED. [N/m]

    Returns
    -------
    position_m, tension_n : ndarray, shape (n, 3)
        Places [m]; tension times the tangent that points from start to end [N].

    Raises
    ------
    CannotComputeError
        As `catenary_parameter`.

    Examples
    --------
    A chain of 2 sinh(1) m and 1 N/m over a span of 2 m has H = w c = 1 N.

    >>> places, tension = uniform_load_cable([0.0], length_m=2 * np.sinh(1.0),
    ...     start_m=np.zeros(3), end_m=np.array([2.0, 0, 0]), load_npm=np.array([0, 0, 1.0]))
    >>> tension.round(6).tolist()  # cosh(1) N at the end, steeply down at first
    [[1.0, 0.0, 1.175201]]
    """
    load = float(np.linalg.norm(load_npm))
    places, across, along, c = _catenary_points(
        arc_length_m, length_m, start_m, end_m, load_npm / load if load > 0 else load_npm
    )
    return places, load * (c * across + along)


def _catenary_points(
    arc_length_m: ArrayLike, length: float, start: FloatArray, end: FloatArray, down: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Return points, the direction across, arc length from the lowest point (upward), and c."""
    chord = np.asarray(end, float) - np.asarray(start, float)
    rise = float(-chord @ down)
    sideways = chord + rise * down
    span = float(np.linalg.norm(sideways))
    x = catenary_parameter(span, rise, length)
    across = sideways / span
    c = span / (2 * x)
    first = (rise / np.tanh(x) - length) / 2
    s = first + np.asarray(arc_length_m, float)[:, None]
    sag = np.hypot(c, s) - np.hypot(c, first)
    places = start + across * c * (np.arcsinh(s / c) - np.arcsinh(first / c)) - down * sag
    return np.asarray(places, dtype=float), across, -s * down, c
