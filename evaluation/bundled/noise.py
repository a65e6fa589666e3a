"""Bench noise that is the same on every machine and with every version of the libraries."""

import random


class Noise:
    """Normal-like noise from a named seed.

    The sum of twelve uniform numbers less six has mean 0 and standard deviation 1; it needs
    nothing but additions, so no mathematical library can round it otherwise. Python guarantees
    the sequence of ``random()`` for a given seed. The tails end at 6 standard deviations.

    Examples
    --------
    >>> Noise("a").normal(1.0) == Noise("a").normal(1.0)
    True
    """

    def __init__(self, seed: str) -> None:
        self._random = random.Random(seed)  # noqa: S311 - noise, not a secret

    def normal(self, standard_deviation: float) -> float:
        """Draw one number with mean 0 and the given standard deviation."""
        return standard_deviation * (sum(self._random.random() for _ in range(12)) - 6.0)
