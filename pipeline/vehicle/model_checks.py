"""Can a body be like this? Inertia tensor and added-mass matrix of the vehicle file.

Each function returns what is wrong in words, or None.
"""

from collections.abc import Sequence

#: Largest relative asymmetry of an added-mass matrix, and slack of the other checks.
_TOLERANCE = 1e-6


def inertia_fault(inertia_kgm2: Sequence[float]) -> str | None:
    r"""Return the fault of an inertia tensor about the centre of mass, or None.

    The principal moments must be positive, and none larger than the other two together: :math:`I_1
    + I_2 - I_3 = 2 \int z_3^2\, dm \ge 0`. Given are I_xx, I_yy, I_zz and the integrals of xy, xz,
    yz over the mass. [kg m^2]

    >>> inertia_fault((1.0, 1.0, 2.0, 0.0, 0.0, 0.0)) is None  # a thin disc
    True
    >>> inertia_fault((1.0, 1.0, 2.1, 0.0, 0.0, 0.0))[:42]
    'no body has the principal moments 1, 1, 2.'
    """
    # Imported here: the command line answers --help without it.
    import numpy as np

    xx, yy, zz, xy, xz, yz = inertia_kgm2
    principal = np.linalg.eigvalsh(np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]]))
    named = ", ".join(f"{moment:.6g}" for moment in principal)
    if principal[0] <= _TOLERANCE * abs(principal).max():
        return (
            f"the principal moments are {named} kg m^2, all must be positive; the order is xx, "
            "yy, zz, xy, xz, yz"
        )
    if principal[2] > (principal[0] + principal[1]) * (1 + _TOLERANCE):
        return (
            f"no body has the principal moments {named} kg m^2: the largest exceeds the sum of "
            "the other two"
        )
    return None


def added_mass_fault(matrix: Sequence[Sequence[float]]) -> str | None:
    """Return the fault of an added-mass matrix that has one: symmetric, positive semidefinite.

    The kinetic energy of the water, half of nu' A nu, is never negative, and A is symmetric in an
    ideal fluid. Symmetry is asked for to 1e-6 of the geometric mean of the two diagonal entries or
    of the entry itself, whichever is larger. [kg, kg m, kg m^2]

    >>> rows = [[float(i == j) for j in range(6)] for i in range(6)]
    >>> added_mass_fault(rows) is None
    True
    >>> rows[1][5] = 0.2
    >>> added_mass_fault(rows)
    'not symmetric: row 2, column 6 is 0.2, row 6, column 2 is 0'
    """
    import numpy as np

    a = np.array(matrix, float)
    size = np.sqrt(np.abs(np.outer(np.diag(a), np.diag(a))))
    size = np.maximum(size, np.maximum(np.abs(a), np.abs(a.T)))
    wrong = np.argwhere(np.triu(np.abs(a - a.T) > _TOLERANCE * size))
    if wrong.size:
        i, j = (int(k) for k in wrong[0])
        return (
            f"not symmetric: row {i + 1}, column {j + 1} is {a[i, j]:g}, "
            f"row {j + 1}, column {i + 1} is {a[j, i]:g}"
        )
    # Masses and inertias have different units: scale the diagonal to 1 before asking for the sign.
    diagonal = np.diag(a)
    if diagonal.min() < 0:
        i = int(diagonal.argmin())
        return (
            f"row {i + 1}, column {i + 1} is {diagonal[i]:g}; added masses are positive numbers "
            "here (the force carries the minus sign)"
        )
    scale = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    smallest = float(np.linalg.eigvalsh((a + a.T) / 2 / np.outer(scale, scale))[0])
    if smallest < -_TOLERANCE:
        return (
            f"not positive semidefinite (smallest eigenvalue, diagonal scaled to 1: "
            f"{smallest:.3g}): some motion would take energy out of the water; an off-diagonal "
            "entry is too large or has the wrong place"
        )
    return None
