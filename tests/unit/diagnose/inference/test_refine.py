"""Answers at their own points, and anew where two looks at a lead disagree."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose import engine
from pipeline.diagnose.inference import infer, own_point, refine, second_look
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.inference.own_point import Reached, judged_anew, log_evidence_at
from pipeline.diagnose.inference.trials import Lead
from pipeline.diagnose.inference.verdict import departures_of, idle_effects
from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.judging.search import Judged, Search
from pipeline.diagnose.linear.elimination import grams
from pipeline.diagnose.linear.linear_model import vector_of
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

Given = tuple[Search, Answers, Lead]


@pytest.fixture(scope="module")
def given() -> Given:
    """What a diagnosis of a weak thruster gives to be judged."""
    case = small_case(
        ("thruster_degraded:thrust_fraction=0.8@front_left",),
        effects=("thruster_degraded", "quadratic_damping", "dvl_scale"),
    )
    kept: list[Given] = []

    def keep(
        found: Search, first: Answers, lead: Lead, most: int, elsewhere: float
    ) -> refine.Refined:
        kept.append((found, first, lead))
        return refine.refined(found, first, lead, most, elsewhere)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(infer, "refined", keep)
        engine.diagnose(case, threads=1)
    return kept[0]


@pytest.mark.parametrize("loses", [3.0, 1e6])
def test_nothing_is_judged_at_its_own_point_unless_all_was_judged_there(
    given: Given, monkeypatch: pytest.MonkeyPatch, loses: float
) -> None:
    found, first, lead = given

    def correction(
        there: Search, _judged: Judged, finding: Finding | None
    ) -> tuple[float, FloatArray]:
        return -loses if finding is None else 0.0, there.model.point.departures

    monkeypatch.setattr(second_look, "_correction", correction)
    own = refine.refined(found, first, lead, 2)
    change = own.search.judged[0].nothing - found.judged[0].nothing
    if loses < 5.0:
        assert change == pytest.approx(-loses)
        assert () not in own.points
    else:
        # as seen from the vehicle as it is stated, not as promised by the weak thruster's model
        assert -20.0 < change < 20.0
        assert () in own.points
    assert {(), first.ranking[0].finding.which} <= own.sure
    assert not own.doubtful
    assert own.seen_from(first.ranking[0]) is None


def test_what_the_own_points_say_does_not_depend_on_where_all_was_linear(given: Given) -> None:
    """The lead over none is the same from the vehicle as it is stated and from the weak one."""
    found, first, lead = given
    top = first.ranking[0]
    leads = []
    for departures in (found.model.point.departures, np.zeros(len(found.setting.coordinates))):
        led = lead(found.setting, vector_of(found.setting, departures))
        model = linear_model(led, replace(led.origin(), departures=departures))
        there = replace(found, model=model, grams=grams(model))
        level = Level(np.ones(6), 1.0, True)
        values = []
        for finding in (top.finding, None):
            judged = replace(top.judged, level=level)
            begin = departures_of(there, replace(top, judged=judged), finding)
            values.append(judged_anew(there, lead, judged, finding, begin, -np.inf).value)
        leads.append(values[0] - values[1])
    assert leads[0] == pytest.approx(leads[1], abs=2.0)
    assert leads[0] > 10.0


def test_what_is_too_small_to_matter_stays_where_it_is_most_probable(given: Given) -> None:
    """Put back to neutral on the way, it cost `none` 50 nats at a healthy vehicle."""
    found, first, lead = given
    nothing = first.of("none")
    assert nothing is not None
    begin = departures_of(found, nothing, None)
    stated = np.array([one.ordinary > 0.0 for one in found.setting.coordinates])
    assert begin[~stated].any()
    reached = judged_anew(found, lead, nothing.judged, None, begin, -np.inf)
    assert reached.settled
    assert (reached.point[~stated] / begin[~stated] > 0.5).all()


@pytest.mark.parametrize(("enough", "sought"), [(-np.inf, 2), (np.inf, 1)])
def test_what_is_too_far_behind_near_its_end_is_sought_from_nowhere_else(
    given: Given, monkeypatch: pytest.MonkeyPatch, enough: float, sought: int
) -> None:
    found, first, lead = given
    nothing = first.of("none")
    assert nothing is not None
    ways = []
    # nothing settles: what moves by nothing at all still moves too far
    for name in ("_SETTLED", "_STAYS", "_AS_GOOD"):
        monkeypatch.setattr(own_point, name, -1.0)

    def counted(*given: Any) -> Reached:  # noqa: ANN401
        ways.append(way(*given))
        return ways[-1]

    way = own_point._followed
    monkeypatch.setattr(own_point, "_followed", counted)
    begin = departures_of(found, nothing, None)
    reached = judged_anew(found, lead, nothing.judged, None, begin, enough)
    assert len(ways) == sought
    assert not reached.settled
    assert reached.behind == (enough == np.inf)


def test_a_pair_is_judged_under_every_force_that_a_single_effect_is(given: Given) -> None:
    """Each alone needs a force that no healthy vehicle has: both need none."""
    found, _, _ = given
    pairs = [{one.which for one in level.pairs} for level in found.judged]
    assert pairs[0]
    assert all(some == pairs[0] for some in pairs)
    assert any(level.level.factor.min() < level.level.factor.max() for level in found.judged)


def test_the_effects_of_a_pair_are_judged_at_their_own_points_too(
    given: Given, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, first, lead = given
    looked_at: set[tuple[str, ...]] = set()

    def correction(
        there: Search, _judged: Judged, finding: Finding | None
    ) -> tuple[float, FloatArray]:
        looked_at.add(() if finding is None else finding.effects)
        return 0.0, there.model.point.departures

    monkeypatch.setattr(second_look, "_correction", correction)
    wanted = ("quadratic_damping", "thruster_degraded")
    judged, both = next(
        (one, pair) for one in found.judged for pair in one.pairs if pair.effects == wanted
    )
    pair = replace(first.ranking[0], name="+".join(both.effects), finding=both, judged=judged)
    single = next(one for one in judged.singles if one.effects == ("quadratic_damping",))
    damping = replace(pair, name="quadratic_damping", finding=single)
    refine.refined(found, Answers((pair, *first.ranking, damping)), lead, 1)
    assert looked_at == {
        (),
        wanted,
        ("thruster_degraded",),
        ("quadratic_damping",),
    }


@pytest.mark.parametrize("elsewhere", [0.3, np.inf])
def test_the_others_wait_where_the_first_answer_lies_elsewhere(
    given: Given, monkeypatch: pytest.MonkeyPatch, elsewhere: float
) -> None:
    """Its lead is the same from its own point, but the linear model was far off about it."""
    found, first, lead = given
    gone_to: list[tuple[int, ...]] = []

    def correction(
        there: Search, _judged: Judged, _finding: Finding | None
    ) -> tuple[float, FloatArray]:
        return 500.0, there.model.point.departures

    def anew(there: Search, *hypothesis: Any) -> Reached:  # noqa: ANN401 (passed on as they come)
        _, judged, finding, begin, _ = hypothesis
        gone_to.append(() if finding is None else finding.which)
        value = log_evidence_at(there, there.grams, judged, finding) + 500.0
        return Reached(value, begin + 0.5, settled=True)

    monkeypatch.setattr(second_look, "_correction", correction)
    monkeypatch.setattr(second_look, "judged_anew", anew)
    own = refine.refined(found, first, lead, 3, elsewhere)
    top = first.ranking[0]
    assert top.finding is not None
    assert gone_to[0] == top.finding.which
    if elsewhere < 0.5:
        assert gone_to == [top.finding.which]
        # whatever comes first before the others are seen from there
        for one in (top, first.of("none"), first.of("unknown")):
            assert one is not None
            seen_from = own.seen_from(one)
            assert seen_from is not None
            assert seen_from[0] == pytest.approx(found.model.point.departures + 0.5)
            assert seen_from[1] is top.judged.level
    else:
        assert () in gone_to
        assert own.seen_from(top) is None


def test_values_that_no_vehicle_has_are_no_answer(
    given: Given, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a payload of less than nothing that leaves no mass: `unknown`, and not no diagnosis."""
    found, first, _ = given
    top = first.ranking[0]
    assert top.finding is not None
    assert refine.possible_alone(found, first) is first
    which = list(top.finding.which)

    def vector(setting: Any, departures: np.ndarray) -> np.ndarray:  # noqa: ANN401
        if departures[which].any():
            raise CannotComputeError("the vehicle has -7.7 kg left. The total must stay positive.")
        return vector_of(setting, departures)

    monkeypatch.setattr(refine, "vector_of", vector)
    answered = refine.possible_alone(found, first)
    assert answered.of(top.name) is None
    assert (answered.ranking[0].name, answered.ranking[0].finding) == ("unknown", None)
    assert sum(one.probability for one in answered.ranking) == pytest.approx(1.0)


def test_a_pair_whose_second_effect_does_nothing_is_its_first(given: Given) -> None:
    found, first, _ = given
    factor = 1.4
    alone = first.of("thruster_degraded")
    assert alone is not None
    assert alone.finding is not None
    every = found.setting.coordinates
    surge = next(k for k, one in enumerate(every) if one.name == "quadratic_damping:surge")
    which = tuple(sorted((*alone.finding.which, surge)))
    both = replace(
        alone.finding,
        groups=(*alone.finding.groups, ("quadratic_damping", None)),
        which=which,
        variance=np.ones(len(which)),
    )
    # the drag is as stated: its interval holds the stated value, the thruster's does not
    pair = replace(alone, name="quadratic_damping+thruster_degraded", finding=both, probability=0.7)
    assert idle_effects(found, alone, factor) == ()
    assert idle_effects(found, pair, factor) == ("quadratic_damping",)
    answered = Answers((pair, replace(alone, probability=0.3)))
    left = refine.that_depart(found, answered, factor)
    assert [(one.name, one.probability) for one in left.ranking] == [
        ("thruster_degraded", pytest.approx(1.0)),
        ("quadratic_damping+thruster_degraded", 0.0),
    ]
    # nobody is there to take its place
    assert refine.that_depart(found, Answers((pair,)), factor).ranking[0].probability == 0.7
