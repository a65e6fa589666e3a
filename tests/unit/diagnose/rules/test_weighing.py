"""Weighing, deciding and the search for thresholds: numbers in, one answer out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from evaluation.diagnosis.threshold_search import (
    TRIED,
    WORTH_MOVING,
    Known,
    cost,
    decided,
    search_thresholds,
    total_cost,
)
from pipeline.diagnose.conclude.case_evidence import CaseEvidence
from pipeline.diagnose.inference.held_out import with_held_out
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.decision import (
    decide,
    for_the_gap,
    verdict_of,
    with_gap,
    with_unknown,
    without_gap,
)
from pipeline.diagnose.rules.helping import demote_without_heldout_gain
from pipeline.diagnose.rules.shares import Left, Share
from pipeline.diagnose.rules.sureness import with_sure_effect, with_sure_second
from pipeline.diagnose.rules.weighing import LevelEvidence, Weighed, weigh

LIMITS = Calibration(
    exponent=1.0,
    none=0.5,
    single=0.4,
    pair=0.1,
    pair_share=0.0,
    held_out=1.0,
    set_level=0.99,
    left_over=0.3,
    verdict=0.9,
    most_force=3.0,
    most_force_healthy=2.0,
    most_level=2.0,
    most_level_healthy=3.0,
    most_gap=1.5,
    least_gap=1.3,
    most_none_gap=3.0,
    most_none_gap_healthy=2.0,
    interval_factor=1.0,
    source="",
)


def level(
    nothing: float, *gains: tuple[str, float], size: float = 1.0, ordinary: bool = True
) -> LevelEvidence:
    return LevelEvidence(size, True, ordinary, 0.5, nothing, (("none", 0.0), *gains))


def weighed(
    every: Sequence[LevelEvidence], limits: Calibration = LIMITS, *, healthy: bool = False
) -> tuple[Weighed, ...]:
    return weigh(every, 4, limits, healthy_known=healthy)


def test_two_hypotheses_are_weighed_as_bayes_says() -> None:
    found = weighed([level(-3.0, ("lift", 1.0))])
    shares = {one.name: one.probability for one in found}
    odds = np.exp(1.0) * (0.4 / 4) / 0.5
    assert shares["lift"] / shares["none"] == pytest.approx(odds, rel=1e-12)
    assert sum(shares.values()) == pytest.approx(1.0)


def test_exponent_tempers() -> None:
    found = weighed([level(0.0, ("lift", 2.0))], replace(LIMITS, exponent=0.5))
    shares = {one.name: one.probability for one in found}
    assert shares["lift"] / shares["none"] == pytest.approx(np.e * 0.1 / 0.5, rel=1e-12)


def test_pairs_share_their_own_prior() -> None:
    found = weighed([level(0.0, ("lift", 5.0), ("lift+tether", 5.0))])
    shares = {one.name: one.probability for one in found}
    assert shares["lift"] / shares["lift+tether"] == pytest.approx((0.4 / 4) / (0.1 / 6))


def test_second_effect_must_add_a_share_of_what_the_first_explains() -> None:
    every = [level(0.0, ("lift", 100.0), ("lift+tether", 109.0))]
    assert weighed(every)[0].name == "lift+tether"
    assert weighed(every, replace(LIMITS, pair_share=0.1))[0].name == "lift"


def test_force_that_no_healthy_vehicle_has_is_unknown() -> None:
    found = weighed([level(-50.0), level(0.0, size=8.0, ordinary=False)])
    assert found[0].name == "unknown"
    assert found[0].probability > 0.99


def test_effect_that_takes_most_of_the_force_away_is_the_answer() -> None:
    every = [
        level(-500.0, ("tether", 300.0)),
        level(-80.0, ("tether", 110.0), size=4.0, ordinary=False),
        level(0.0, ("tether", 0.0), size=64.0, ordinary=False),
    ]
    assert weighed(every)[0].name == "tether"
    assert weighed(every, replace(LIMITS, left_over=0.01))[0].name == "unknown"


def test_what_counts_as_ordinary_rests_on_what_is_known_of_healthy_vehicles() -> None:
    every = [level(-50.0), level(0.0, size=3.0, ordinary=False)]
    assert weighed(every)[0].name == "unknown"
    assert weighed(every, healthy=True)[0].name == "none"


SHARES = (Share("lift", 0.8), Share("tether", 0.15), Share("none", 0.05))


def test_answer_below_the_threshold_names_the_others() -> None:
    assert verdict_of(SHARES, (), LIMITS) == (("lift",), ("tether", "none"))
    assert verdict_of(SHARES, (), replace(LIMITS, verdict=0.7)) == (("lift",), ())
    assert verdict_of(SHARES, (), replace(LIMITS, set_level=0.9)) == (("lift",), ("tether",))


def test_what_cannot_be_told_apart_is_named_however_sure() -> None:
    sure = (Share("lift", 0.999), Share("none", 0.001))
    assert verdict_of(sure, ("payload",), LIMITS) == (("lift",), ("payload",))


@pytest.mark.parametrize(("healthy", "first"), [(False, "lift"), (True, "unknown")])
def test_force_left_is_judged_by_what_is_known_of_healthy_vehicles(
    healthy: bool, first: str
) -> None:
    found = with_unknown(SHARES, Left(2.5, 3.0, 1.0, 1.0), LIMITS, healthy_known=healthy)
    assert found[0].name == first
    assert sum(one.probability for one in found) == pytest.approx(1.0)


def test_answer_that_closes_no_gap_is_none() -> None:
    worse = with_unknown(SHARES, Left(1.0, 4.0, 3.9, 0.03), LIMITS, healthy_known=False)
    assert worse[0].name == "unknown"
    assert [one.name for one in worse[1:]] == ["lift", "tether", "none"]


def test_no_gap_needs_no_cause() -> None:
    found = without_gap(SHARES, 1.2, 1.2, LIMITS, healthy_known=True)
    assert found[0].name == "none"
    assert sum(one.probability for one in found) == pytest.approx(1.0)
    assert without_gap(SHARES, 1.4, 1.4, LIMITS, healthy_known=True) == SHARES
    # what the readings speak for plainly needs no gap
    plain = (Share("lift", 1.0), Share("none", 1e-10))
    assert without_gap(plain, 1.2, 1.2, LIMITS, healthy_known=True) == plain
    # what no healthy runs have narrowed, the evidence has weighed already
    assert without_gap(SHARES, 1.2, 1.2, LIMITS, healthy_known=False) == SHARES
    unexplained = (Share("unknown", 0.9), Share("none", 0.1))
    assert without_gap(unexplained, 1.2, 1.2, LIMITS, healthy_known=True) == unexplained
    assert without_gap(unexplained, 0.9, 0.9, LIMITS, healthy_known=True)[0].name == "none"
    contradiction = (Share("dvl_scale", 0.9), Share("none", 0.1))
    assert without_gap(contradiction, 1.0, 1.0, LIMITS, healthy_known=True) == contradiction


def test_answer_that_held_out_windows_speak_against_does_not_lead() -> None:
    found = with_held_out(SHARES, {"lift": -10.0, "tether": 3.0}, LIMITS)
    shares = {one.name: one.probability for one in found}
    assert found[0].name == "tether"
    assert sum(shares.values()) == pytest.approx(1.0)
    # what speaks for an answer there does not raise it
    assert shares["tether"] / shares["none"] == pytest.approx(3.0)
    assert shares["lift"] / shares["none"] == pytest.approx(16.0 * np.exp(-7.0))


def test_held_out_windows_count_by_their_weight_and_beyond_chance_only() -> None:
    gains = {"lift": -10.0, "tether": -1.0}
    assert with_held_out(SHARES, gains, replace(LIMITS, held_out=0.0)) == SHARES
    assert with_held_out(SHARES, {"lift": -2.9, "tether": -1.0}, LIMITS) == SHARES
    only = (Share("lift", 1.0), Share("none", 0.0))
    assert with_held_out(only, {"lift": -1e6}, LIMITS) == only


PAIR_FIRST = (Share("lift+tether", 0.7), Share("payload", 0.15), Share("tether", 0.1))


def test_second_effect_that_is_not_sure_does_not_lead() -> None:
    found = with_sure_second(PAIR_FIRST, LIMITS)
    assert found == (Share("tether", 0.7), Share("payload", 0.15), Share("lift+tether", 0.1))
    assert verdict_of(found, (), LIMITS) == (("tether",), ("payload", "lift"))


@pytest.mark.parametrize(
    "ranking",
    [
        (Share("lift+tether", 0.92), Share("tether", 0.08)),  # sure
        (Share("lift+tether", 0.7), Share("tether", 0.05), Share("payload", 0.25)),
        (Share("tether", 0.7), Share("lift+tether", 0.3)),
        (Share("none", 1.0),),
    ],
)
def test_pair_that_is_sure_or_whose_effects_alone_are_not_the_answer_stays(
    ranking: tuple[Share, ...],
) -> None:
    assert with_sure_second(ranking, LIMITS) == ranking


@pytest.mark.parametrize(
    ("effect", "none", "held_out", "worst_ratio", "first"),
    [
        ("lift", 0.2, 0.0, 1.4, "none"),
        ("lift", 0.2, -2.0, 1.4, "none"),
        ("lift+tether", 0.2, 0.7, 1.4, "none"),
        ("tether", 0.13, 5.9, 1.4, "tether"),  # what took no part says so, too
        ("lift", 0.04, 0.0, 1.4, "lift"),  # sure
        ("lift", 0.2, 0.0, 9.0, "lift"),  # no healthy vehicle has this gap
        ("unknown", 0.2, 0.0, 1.4, "unknown"),
    ],
)
def test_none_goes_before_an_effect_that_is_not_sure(
    effect: str, none: float, held_out: float, worst_ratio: float, first: str
) -> None:
    answers = (Share(effect, 1.0 - none), Share("none", none))
    found = with_sure_effect(answers, held_out, worst_ratio, LIMITS, healthy_known=False)
    assert found[0].name == first
    assert sum(one.probability for one in found) == pytest.approx(1.0)
    if first == "none":
        assert verdict_of(found, (), LIMITS) == (("none",), tuple(effect.split("+")))


@pytest.mark.parametrize(
    ("effect", "worst_ratio", "healthy", "known", "first"),
    [
        ("voltage_sag", 1.5, False, False, "none"),
        ("thrust_deduction+voltage_sag", 1.5, False, False, "none"),
        ("voltage_sag", 1.5, False, True, "voltage_sag"),
        ("voltage_sag", 3.5, False, False, "voltage_sag"),
        ("voltage_sag", 2.5, True, False, "voltage_sag"),
        ("thrust_deduction", 1.5, False, False, "thrust_deduction"),
    ],
)
def test_a_supply_that_nobody_measured_is_no_cause_of_a_small_gap(
    effect: str, worst_ratio: float, healthy: bool, known: bool, first: str
) -> None:
    left = Left(1.0, 1.5, 0.5, 1.0, supply_known=known)
    ranking = (Share(effect, 0.998), Share("lift", 0.002))
    found = decide(ranking, left, worst_ratio, LIMITS, healthy_known=healthy)
    assert found.names == tuple(first.split("+"))
    assert sum(one.probability for one in found.ranking) == pytest.approx(1.0)
    if first == "none":
        assert found.ambiguous == tuple(effect.split("+"))
        assert found.ranking[0].probability == pytest.approx(0.8)


NONE_FIRST = (Share("none", 0.9), Share("lift", 0.08), Share("tether", 0.02))


@pytest.mark.parametrize(
    ("ratio", "healthy", "first"),
    [(2.5, False, "none"), (2.5, True, "lift"), (3.5, False, "lift")],
)
def test_gap_that_no_healthy_vehicle_has_is_one(ratio: float, healthy: bool, first: str) -> None:
    found = with_gap(NONE_FIRST, ratio, 10, LIMITS, healthy_known=healthy)
    assert found[0].name == first
    assert sum(one.probability for one in found) == pytest.approx(1.0)
    shares = {one.name: one.probability for one in found}
    # the others keep their places among each other
    assert shares["lift"] / shares["tether"] == pytest.approx(4.0)


@pytest.mark.parametrize(("ratio", "first"), [(5.0, "none"), (7.0, "unknown")])
def test_gap_that_nothing_explains_is_unknown_where_it_is_large(ratio: float, first: str) -> None:
    # the prior odds are 0.04 to 0.5: the readings speak against the effect
    ranking = (Share("none", 0.96), Share("lift", 0.04))
    found = with_gap(ranking, ratio, 10, LIMITS, healthy_known=False)
    assert found[0].name == first
    assert sum(one.probability for one in found) == pytest.approx(1.0)


@pytest.mark.parametrize(("alone", "first"), [(0.6, "lift"), (1.03, "none")])
def test_what_takes_the_place_for_the_gap_must_make_it_smaller(alone: float, first: str) -> None:
    grown = with_gap(NONE_FIRST, 3.5, 10, LIMITS, healthy_known=False)
    left = Left(force=1.0, before=1.6, after=1.2, gap_closed=0.6, alone=alone)
    assert for_the_gap(NONE_FIRST, grown, left)[0].name == first
    # it is as sure as it was, or as it became
    assert for_the_gap(NONE_FIRST, grown, left) in (NONE_FIRST, grown)


def helped(
    ranking: Sequence[Share], alone: dict[str, float], ratio: float = 1.2, before: float = 1.6
) -> tuple[str, dict[str, float]]:
    """First answer, and all probabilities, where answers leave so much of the held-out gap."""

    def left_of(shares: Sequence[Share]) -> Left:
        return Left(1.0, before, 1.2, 0.5, alone=alone.get(shares[0].name, 1.0))

    found = demote_without_heldout_gain(ranking, left_of, ratio, LIMITS, healthy_known=False)
    assert sum(one.probability for one in found) == pytest.approx(1.0)
    return found[0].name, {one.name: one.probability for one in found}


@pytest.mark.parametrize(("tested", "first"), [(True, "none"), (False, "lift")])
def test_what_the_held_out_runs_do_not_show_they_say_nothing_of(
    *, tested: bool, first: str
) -> None:
    sure = (Share("lift", 0.97), Share("none", 0.03))
    left = Left(1.0, 1.2, 1.2, None, alone=1.001, tested=tested)
    found = demote_without_heldout_gain(sure, lambda _: left, 1.2, LIMITS, healthy_known=False)
    assert found[0].name == first


SURE_OF_A_PAIR = (Share("lift+tether", 0.98), Share("lift", 0.01), Share("none", 0.01))


@pytest.mark.parametrize(
    ("ratio", "before", "heir"),
    [(1.2, 1.6, "none"), (3.5, 1.6, "unknown"), (3.5, 1.2, "none")],
)
def test_what_makes_no_gap_smaller_gives_way(ratio: float, before: float, heir: str) -> None:
    """To none, or to unknown where the gap is one that no healthy vehicle has, in all it does."""
    ranking = (Share("lift", 0.99), Share("none", 0.01))
    first, shares = helped(ranking, {"lift": 1.04}, ratio, before)
    assert first == heir
    assert shares["lift"] == pytest.approx(0.099)


def test_what_makes_the_gap_smaller_stays() -> None:
    ranking = (Share("lift", 0.99), Share("none", 0.01))
    assert helped(ranking, {"lift": 0.97}) == ("lift", {"lift": 0.99, "none": 0.01})


def test_others_that_are_probable_take_the_place() -> None:
    ranking = (Share("lift", 0.7), Share("tether", 0.2), Share("none", 0.1))
    first, shares = helped(ranking, {"lift": 1.0, "tether": 0.8})
    assert first == "tether"
    # they keep their places among each other
    assert shares["tether"] / shares["none"] == pytest.approx(2.0)


def test_an_effect_goes_before_a_pair_that_leaves_no_less() -> None:
    first, shares = helped(SURE_OF_A_PAIR, {"lift+tether": 0.7, "lift": 0.6})
    assert first == "lift"
    assert shares["lift+tether"] == pytest.approx(0.098)
    assert helped(SURE_OF_A_PAIR, {"lift+tether": 0.6, "lift": 0.7})[0] == "lift+tether"


@pytest.mark.parametrize(("left", "first"), [(0.58, "lift+tether"), (0.5, "lift")])
def test_what_the_readings_rule_out_alone_must_leave_clearly_less(left: float, first: str) -> None:
    ranking = (Share("lift+tether", 1.0), Share("lift", 1e-48), Share("none", 0.0))
    assert helped(ranking, {"lift+tether": 0.6, "lift": left})[0] == first


def test_of_two_that_leave_less_alone_the_more_probable_takes_the_place() -> None:
    """What does nearly the same as the true effect closes the same gap, by readings that differ."""
    ranking = (Share("lift+tether", 0.98), Share("lift", 0.015), Share("tether", 1e-9))
    ranking = (*ranking, Share("none", 0.005))
    first, _ = helped(ranking, {"lift+tether": 0.4, "lift": 0.35, "tether": 0.3})
    assert first == "lift"


def test_unknown_at_what_is_hardly_a_gap_has_none_beside_it() -> None:
    sure = (Share("unknown", 0.999), Share("lift", 0.001))
    found = without_gap(sure, 1.02, 1.02, LIMITS, healthy_known=True)
    assert [one.name for one in found] == ["unknown", "none", "lift"]
    assert sum(one.probability for one in found) == pytest.approx(1.0)
    assert verdict_of(found, (), LIMITS) == (("unknown",), ("none",))
    assert without_gap(sure, 1.2, 1.2, LIMITS, healthy_known=True) == sure
    # what is less sure than that stays so, and goes behind what is surer
    doubtful = (Share("unknown", 0.4), Share("lift", 0.35), Share("none", 0.25))
    assert without_gap(doubtful, 1.02, 1.02, LIMITS, healthy_known=True) == doubtful


@pytest.mark.parametrize(
    ("was_unknown", "before", "after", "first"),
    [
        (True, 2.0, 0.9, "tether"),
        (True, 2.0, 1.2, "unknown"),
        (True, 1.3, 0.9, "unknown"),
        (False, 2.0, 0.9, "unknown"),
    ],
)
def test_a_force_that_moves_nothing_is_not_unknown(
    was_unknown: bool, before: float, after: float, first: str
) -> None:
    left = Left(force=80.0, before=before, after=after, gap_closed=1.0, was_unknown=was_unknown)
    answers = (Share("tether", 0.9), Share("unknown", 0.1))
    assert with_unknown(answers, left, LIMITS, healthy_known=True)[0].name == first


@pytest.mark.parametrize(("after", "others"), [(1.1, ()), (1.3, ("unknown",))])
def test_beside_an_effect_that_leaves_a_gap_stands_unknown(
    after: float, others: tuple[str, ...]
) -> None:
    left = Left(force=1.0, before=2.2, after=0.9, gap_closed=1.0, alone=0.7, alone_after=after)
    sure = (Share("lift", 0.99), Share("unknown", 0.01))
    found = with_unknown(sure, left, LIMITS, healthy_known=False)
    assert verdict_of(found, (), LIMITS) == (("lift",), others)
    assert sum(one.probability for one in found) == pytest.approx(1.0)
    none = (Share("none", 0.99), Share("unknown", 0.01))
    assert with_unknown(none, left, LIMITS, healthy_known=False) == none


def test_an_answer_that_is_not_sure_never_stands_alone() -> None:
    shares = (Share("lift", 0.93), Share("tether", 0.07))
    limits = replace(LIMITS, set_level=0.9, verdict=0.95)
    assert verdict_of(shares, (), limits) == (("lift",), ("tether",))


def test_what_gave_way_once_does_not_come_back() -> None:
    """Two answers that do not help would else hand the place to each other."""
    ranking = (Share("lift", 0.6), Share("tether", 0.3), Share("none", 0.1))
    first, shares = helped(ranking, {"lift": 1.2, "tether": 1.1})
    assert first == "none"
    assert shares["lift"] < 0.1


@pytest.mark.parametrize(("there", "first"), [(1.2, "none"), (1.4, "lift"), (None, "lift")])
def test_a_gap_where_an_answer_does_nothing_is_not_its(there: float | None, first: str) -> None:
    ranking = (Share("lift", 0.99), Share("none", 0.01))
    left = Left(force=1.0, before=1.2, after=1.1, gap_closed=0.5, alone=0.9, gap_there=there)
    assert decide(ranking, left, 1.6, LIMITS, healthy_known=True).names == (first,)


@pytest.mark.parametrize(
    ("since", "first", "too_small"), [(1.4, "lift", ""), (1.2, "none", "lift")]
)
def test_a_gap_is_what_came_since_the_healthy_runs(
    since: float, first: str, too_small: str
) -> None:
    """What the vehicle always differed from its file by neither makes a gap nor hides one."""
    ranking = (Share("lift", 0.99), Share("none", 0.01))
    left = Left(1.0, 1.2, 0.9, 0.5, alone=0.9, gap_there=1.1, gap_since=since)
    said = decide(ranking, left, 1.1, LIMITS, healthy_known=True, worst_since=2.0)
    assert (said.names, said.too_small) == ((first,), too_small)
    # where the worst channel is one in which the answer acts
    said = decide(
        ranking, replace(left, gap_since=9.0), 1.1, LIMITS, healthy_known=True, worst_since=since
    )
    assert said.names == (first,)


def test_a_force_is_told_from_the_gap_against_the_file() -> None:
    ranking = (Share("unknown", 0.99), Share("none", 0.01))
    assert without_gap(ranking, 0.9, 5.0, LIMITS, healthy_known=True)[0].name == "none"
    assert without_gap(ranking, 1.2, 0.5, LIMITS, healthy_known=True)[0].name == "unknown"


def test_beside_none_at_a_gap_that_hardly_a_healthy_vehicle_has_stands_unknown() -> None:
    sure = (Share("none", 0.999), Share("lift", 0.001))
    found = with_gap(sure, 1.5 * LIMITS.most_none_gap, 20, LIMITS, healthy_known=False)
    assert verdict_of(found, (), LIMITS) == (("none",), ("unknown",))
    assert sum(one.probability for one in found) == pytest.approx(1.0)


def test_what_is_kept_of_a_case_is_what_was_decided_by() -> None:
    left = Left(
        force=2.0, before=3.0, after=1.0, gap_closed=0.9, alike=("lift",), alone=0.4, tested=False,
        gap_there=2.0, alone_after=1.2, was_unknown=True, supply_known=False, gap_since=2.5,
    )  # fmt: skip
    kept = case("lift", 3.0).evidence.model_copy(update={"consequences": {"lift": left}})
    assert CaseEvidence.model_validate_json(kept.model_dump_json()) == kept


def test_an_error_of_measurement_is_told_whatever_it_leaves() -> None:
    ranking = (Share("dvl_scale", 0.99), Share("none", 0.01))
    assert helped(ranking, {"dvl_scale": 1.04})[0] == "dvl_scale"


def test_what_was_first_before_the_gap_was_seen_stays_whatever_it_leaves() -> None:
    left = Left(force=1.0, before=1.6, after=1.7, gap_closed=-0.2, alone=1.1)
    ranking = (Share("lift", 0.9), Share("none", 0.1))
    assert for_the_gap(ranking, ranking, left) == ranking
    unknown = (Share("unknown", 0.8), Share("none", 0.2))
    assert for_the_gap(NONE_FIRST, unknown, left) == unknown


def case(truth: str, gain: float, ratio: float = 5.0) -> Known:
    levels = (
        LevelEvidence(
            size=1.0,
            even=True,
            ordinary=True,
            weight=1.0,
            nothing=0.0,
            gains=(("none", 0.0), ("lift", gain), ("tether", gain - 2.0)),
        ),
    )
    left = Left(force=1.0, before=3.0, after=1.0, gap_closed=1.0, alike=())
    evidence = CaseEvidence(
        healthy=False,
        effect_count=2,
        interval_factor=1.0,
        worst_ratio=ratio,
        worst_since=ratio,
        levels=levels,
        consequences={"none": left, "lift": left, "tether": left},
        held_out={},
        gap_left={},
    )
    return Known(evidence, (truth,), ratio)


def test_costs_are_in_the_order_of_harm() -> None:
    right, shared = cost(case("lift", 50.0), LIMITS), cost(case("tether", 50.0), LIMITS)
    wrong = cost(case("payload", 50.0), LIMITS)
    assert right < shared < wrong
    assert cost(case("none", 50.0), LIMITS) > wrong
    assert cost(case("lift", -50.0, ratio=1.05), LIMITS) == 0.0


def test_to_call_a_known_effect_unknown_is_wrong_but_not_confidently() -> None:
    known = case("payload", 50.0)
    left = Left(force=9.0, before=3.0, after=3.0, gap_closed=0.0, alike=())
    loud = known.evidence.model_copy(update={"consequences": {"lift": left}})
    called_unknown = replace(known, evidence=loud)
    assert decided(loud, LIMITS).names == ("unknown",)
    right, wrong = cost(case("lift", 50.0), LIMITS), cost(known, LIMITS)
    assert right < cost(called_unknown, LIMITS) < wrong


@pytest.mark.parametrize(("left", "names"), [(0.0, "lift+tether"), (10.0, "lift")])
def test_a_pair_that_the_gap_makes_unsure_gives_way_to_its_effect(left: float, names: str) -> None:
    one = case("lift", 50.0).evidence
    (level_,) = one.levels
    gains = (("none", 0.0), ("lift", 50.0), ("tether", 0.0), ("lift+tether", 62.0))
    evidence = one.model_copy(
        update={
            "levels": (replace(level_, gains=gains),),
            "consequences": {name: one.consequences["lift"] for name, _ in gains},
            "gap_left": {"lift": 0.0, "lift+tether": left},
        }
    )
    said = decided(evidence, LIMITS)
    assert said.names == tuple(names.split("+"))
    assert said.ambiguous == (() if left == 0.0 else ("tether",))


def test_search_finds_thresholds_that_make_fewer_mistakes() -> None:
    # healthy vehicles with evidence of 6 nats for an effect, sick ones with 60 or more
    cases = [case("none", 6.0)] * 5 + [case("lift", 80.0)] * 5
    before = total_cost(cases, LIMITS)
    found, least = search_thresholds(cases, LIMITS)
    assert before > 0.0
    assert least < before
    assert total_cost(cases, found) == pytest.approx(least)
    for name in TRIED:
        back = replace(found, **{name: getattr(LIMITS, name)})
        assert back == found or total_cost(cases, back) >= least + WORTH_MOVING


def test_thresholds_stay_where_nothing_but_one_case_asks_for_others() -> None:
    # a further name beside the right one: a mistake, but of 0.25
    cases = [case("lift", 3.0)]
    assert 0.0 < total_cost(cases, LIMITS) < WORTH_MOVING
    found, least = search_thresholds(cases, LIMITS)
    assert found == LIMITS
    assert least == total_cost(cases, LIMITS)
