"""The two ways an effect changes the vector: add to a slot, or scale it.

Both leave every bit alone at the neutral value: adding 0.0 would turn a -0.0 into 0.0, so an entry
whose departure is zero is not touched; a product with 1.0 is exact.
"""

from types import EllipsisType

import numpy as np

from pipeline.physics.parameters import read
from pipeline.types import FloatArray

Where = slice | EllipsisType


def add(vector: FloatArray, name: str, departure: float | FloatArray, where: Where = ...) -> None:
    """Add a departure to a slot, or to some of its entries, in place.

    Parameters
    ----------
    vector : ndarray
        The parameter vector; changed.
    name : str
        The slot.
    departure : float or ndarray
        In the slot's unit; broadcast to its shape.
    where : slice, optional
        Entries along the first axis of the slot; all without it.
    """
    target = read(vector, name)[where]
    departure = np.asarray(departure, dtype=np.float64)
    np.add(target, departure, out=target, where=departure != 0.0)


def scale(vector: FloatArray, name: str, factor: float | FloatArray, where: Where = ...) -> None:
    """Multiply a slot, or some of its entries, in place; parameters as `add`, factor [1]."""
    target = read(vector, name)[where]
    np.multiply(target, factor, out=target)
