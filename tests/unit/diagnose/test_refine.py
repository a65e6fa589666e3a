"""Answers at their own points, and `none` where its own was not reached."""

from dataclasses import replace
from typing import Any

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose import engine, refine
from pipeline.diagnose.answer import Answers
from pipeline.diagnose.hypotheses import Finding
from pipeline.diagnose.search import Judged, Search
from pipeline.diagnose.trials import Lead

Given = tuple[Search, Answers, Lead]


@pytest.fixture(scope="module")
def given() -> Given:
    """What a diagnosis of a weak thruster gives to be judged."""
    case = small_case(
        ("thruster_degraded:thrust_fraction=0.8@front_left",),
        effects=("thruster_degraded", "quadratic_damping"),
    )
    kept: list[Given] = []

    def keep(found: Search, first: Answers, lead: Lead, most: int) -> Search:
        kept.append((found, first, lead))
        return refine.refined(found, first, lead, most)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine, "refined", keep)
        engine.diagnose(case, threads=1)
    return kept[0]


@pytest.mark.parametrize("astray", [False, True])
def test_none_is_judged_anew_where_its_own_point_was_not_reached(
    given: Given, monkeypatch: pytest.MonkeyPatch, astray: bool
) -> None:
    found, first, lead = given
    lost = -1e6 if astray else -500.0

    def correction(_found: Any, _lead: Any, _judged: Judged, finding: Finding | None) -> float:  # noqa: ANN401
        return lost if finding is None else 0.0

    monkeypatch.setattr(refine, "_correction", correction)
    own = refine.refined(found, first, lead, 2)
    change = own.judged[0].nothing - found.judged[0].nothing
    if astray:
        # the weak thruster still speaks against it, as seen from the vehicle as it is stated
        assert -1e5 < change < 100.0
    else:
        assert change == pytest.approx(lost)


def test_the_effects_of_a_pair_are_judged_at_their_own_points_too(
    given: Given, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, first, lead = given
    looked_at: set[tuple[str, ...]] = set()

    def correction(_found: Any, _lead: Any, _judged: Judged, finding: Finding | None) -> float:  # noqa: ANN401
        looked_at.add(() if finding is None else finding.effects)
        return 0.0

    monkeypatch.setattr(refine, "_correction", correction)
    judged, both = next((one, pair) for one in found.judged for pair in one.pairs)
    pair = replace(first.ranking[0], name="+".join(both.effects), finding=both, judged=judged)
    single = next(one for one in judged.singles if one.effects == ("quadratic_damping",))
    damping = replace(pair, name="quadratic_damping", finding=single)
    refine.refined(found, Answers((pair, *first.ranking, damping)), lead, 1)
    assert looked_at == {
        (),
        ("quadratic_damping", "thruster_degraded"),
        ("thruster_degraded",),
        ("quadratic_damping",),
    }
