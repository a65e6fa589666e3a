"""What several models of the same runs say is averaged."""

import numpy as np
import pytest

from pipeline.diagnose.regression.change import Change
from pipeline.diagnose.regression.weigh import NONE, pooled


def change(name: str, probability: float, mean: float, which: tuple[int, ...] = (0,)) -> Change:
    return Change(name, which, (0,), 1.0, probability, np.array([mean]), np.array([0.1]))


def nothing(probability: float) -> Change:
    return Change(NONE, (), (), 0.0, probability, np.zeros(0), np.zeros(0))


def test_probabilities_are_averaged_and_add_up() -> None:
    found = pooled(
        [[change("lift", 0.9, 1.0), nothing(0.1)], [nothing(0.8), change("tether", 0.2, 1.0)]]
    )
    assert {one.name: pytest.approx(one.probability) for one in found} == {
        "lift": 0.45,
        NONE: 0.45,
        "tether": 0.1,
    }


def test_models_that_differ_widen_the_interval() -> None:
    first = pooled([[change("lift", 0.5, 1.0)], [change("lift", 0.5, 2.0)]])[0]
    assert first.mean == pytest.approx(1.5)
    assert first.std == pytest.approx(np.hypot(0.1, 0.5))


def test_a_size_is_that_of_the_parameters_shown() -> None:
    found = pooled([[change("lift", 0.6, 1.0, (1,))], [change("lift", 0.4, 5.0, (2,))]])
    assert found[0].which == (1,)
    assert found[0].mean == pytest.approx(1.0)
