r"""A tether at rest between two points in a flow: the quasi-static cable.

Equilibrium of a piece of cable, in three dimensions, s from start to end:

.. math::

    \frac{d r}{d s} = \left(1 + \frac{T}{EA}\right) t, \qquad
    \frac{d (T t)}{d s} = -q, \qquad
    q = w\,e_z + \tfrac{1}{2} \rho d \left(C_n |V_n| V_n + C_t |V_t| V_t\right)

with V the velocity of the water past the cable at that place, V_t = (V . t) t, V_n = V - V_t and w the
wet weight of a metre (e_z down). In the plane of a uniform flow, with w = 0 and the angle alpha
between t and V, this is

.. math:: \frac{dT}{ds} = -R_\tau, \qquad T \frac{d\alpha}{ds} = R_n

where the sign of the second follows from t = (cos a, sin a): a flow along +x bends a cable that
climbs towards it away from it. Kostenko and Mokeeva 2009, eq. (1), is this, with w = 0.

C_t is referred to the diameter d, as in that paper, not to the girth pi d: a coefficient on the
girth (MoorPy, MoorDyn) is C_t / pi. Drag and weight are those of the unstretched metre.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_bvp

from pipeline.errors import CannotComputeError
from pipeline.physics.catenary import uniform_load_cable
from pipeline.types import FloatArray

#: Velocity of the water past the cable [m/s], shape (n, 3), at positions [m], shape (n, 3).
FlowField = Callable[[FloatArray], FloatArray]
