"""What to fly next, when the runs leave two answers open."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose import engine
from pipeline.diagnose.case import Case
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.tell import next_run as module
from pipeline.diagnose.tell.next_run import next_run
from pipeline.records.diagnosis import NextRun
from pipeline.simulate.manoeuvres import MANOEUVRES

Known = tuple[Case, Search, Answers]


@pytest.fixture(scope="module", autouse=True)
def few_manoeuvres() -> Iterator[None]:
    """A short list to choose from: every manoeuvre is flown for every answer."""
    some = {name: MANOEUVRES[name] for name in ("hover", "surge_steps", "prbs")}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "MANOEUVRES", some)
        yield


@pytest.fixture(scope="module")
def known() -> Known:
    """A weak thruster, what the search found of it, and the answers."""
    case = small_case(
        ("thruster_degraded:thrust_fraction=0.8@front_left",),
        effects=("thruster_degraded", "quadratic_damping", "linear_damping"),
    )
    kept: list[tuple[Search, Answers]] = []
    gap_seen = engine.gap_seen

    def keep(case: Case, found: Search, answered: Answers, *rest: Any) -> Any:  # noqa: ANN401
        kept.append((found, answered))
        return gap_seen(case, found, answered, *rest)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine, "gap_seen", keep)
        engine.diagnose(case, threads=1)
    return (case, *kept[0])


@pytest.fixture(scope="module")
def following(known: Known) -> NextRun:
    """What to fly where damping stands beside the thruster."""
    found = next_run(*known, ("quadratic_damping",))
    assert found is not None
    return found


def test_the_manoeuvre_is_one_that_the_vehicle_can_fly_and_that_separates(
    following: NextRun,
) -> None:
    assert following.separates == ("thruster_degraded", "quadratic_damping")
    assert following.manoeuvre in MANOEUVRES
    assert following.expected_separation_sigma > 3.0


def test_what_shows_an_effect_at_all_shows_it_no_worse_than_beside_another(
    known: Known, following: NextRun
) -> None:
    alone = next_run(*known, ("none",))
    assert alone is not None
    assert alone.separates == ("thruster_degraded", "none")
    assert alone.expected_separation_sigma >= following.expected_separation_sigma


def test_nothing_is_flown_where_nothing_else_can_be_told(known: Known) -> None:
    assert next_run(*known, ("unknown",)) is None


def test_a_rival_of_one_effect_of_a_pair_stands_beside_the_other(known: Known) -> None:
    case, found, answered = known
    pairs = [pair for one in found.judged for pair in one.pairs]
    both = next(one for one in pairs if one.effects == ("quadratic_damping", "thruster_degraded"))
    first = replace(answered.ranking[0], name="+".join(both.effects), finding=both)
    told = next_run(case, found, replace(answered, ranking=(first,)), ("linear_damping",))
    whole = next_run(case, found, replace(answered, ranking=(first,)), ("none",))
    assert told is not None
    assert whole is not None
    # the damping is all that is left to be told apart: the thruster is in both
    assert told.separates == (first.name, "linear_damping")
    assert 0.0 < told.expected_separation_sigma < 0.5 * whole.expected_separation_sigma
