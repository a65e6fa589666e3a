"""One posterior, and what is said of it."""

from dataclasses import dataclass
from typing import cast

import pytest

from pipeline.diagnose.asking.answer import Answer
from pipeline.diagnose.asking.decide import Posterior, decide, posterior_of

EFFECTS = 24


@dataclass(frozen=True)
class Seen:
    """An answer as far as its evidence goes."""

    name: str
    ordinary: float
    strange: float = -1e3

    @property
    def value(self) -> float:
        return max(self.ordinary, self.strange)


def weighed(*answers: Seen) -> Posterior:
    return posterior_of([cast("Answer", one) for one in answers], EFFECTS)


def test_probabilities_sum_to_one_and_are_in_order() -> None:
    found = weighed(Seen("none", 0.0), Seen("tether", 8.0), Seen("current+tether", 9.0))
    values = [value for _, value in found.ranking]
    assert sum(values) == pytest.approx(1.0)
    assert values == sorted(values, reverse=True)
    assert {name for name, _ in found.ranking} == {"none", "unknown", "tether", "current+tether"}


def test_without_evidence_nothing_is_the_matter() -> None:
    said = decide(weighed(Seen("none", 0.0), Seen("tether", 0.0), Seen("current", 1.0)))
    assert said.names == ("none",)


def test_a_clear_effect_stands_alone() -> None:
    said = decide(weighed(Seen("none", 0.0), Seen("tether", 60.0), Seen("current", 20.0)))
    assert said.names == ("tether",)
    assert said.ambiguous == ()


def test_two_that_are_alike_are_told_together() -> None:
    said = decide(weighed(Seen("none", 0.0), Seen("tether", 60.0), Seen("current", 59.0)))
    assert said.names == ("tether",)
    assert said.ambiguous == ("current",)


def test_many_that_are_alike_are_no_answer() -> None:
    alike = [Seen(name, 60.0) for name in ("tether", "current", "lift", "payload", "cg_shift", "a")]
    said = decide(weighed(Seen("none", 0.0), *alike))
    assert said.names == ("unknown",)
    assert said.ambiguous


def test_a_force_that_no_effect_explains_is_unknown() -> None:
    said = decide(weighed(Seen("none", -90.0, 0.0), Seen("tether", -80.0)))
    assert said.names == ("unknown",)


def test_what_is_said_leaves_the_probabilities_alone() -> None:
    found = weighed(Seen("none", 0.0), Seen("tether", 60.0))
    before = found.ranking
    decide(found)
    assert found.ranking == before
