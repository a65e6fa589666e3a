"""Scoring: known bounds, hand-made verdicts, the questions that do not apply."""

from typing import Any

import pytest

from pipeline.blind.cases import (
    SHARES,
    case_of,
)
from pipeline.blind.label import CaseLabel, TrueEffect
from pipeline.blind.score import score_campaign
from pipeline.blind.subject import BlindSubject, possible_effects
from pipeline.blind.verdict_score import CaseScore, score_case


def label(kind: str = "single", ratio: float = 6.0, **more: Any) -> CaseLabel:  # noqa: ANN401 - fields of any type
    effects = (TrueEffect(effect="thrust_deduction", parameters={"t": 0.2}),)
    return CaseLabel(
        vehicle="rov8",
        kind=kind,
        effects=more.pop("effects", effects if kind in ("single", "leave_one_out") else ()),
        wanted_ratio=ratio,
        gap_ratio=ratio,
        channel_ratios={"u": ratio, "v": 1.2},
        healthy_floor={"u": 0.01, "v": 0.01},
        regimes={"command": 0.8, "time": 0.05},
        manoeuvres="trial",
        healthy_runs=3,
        seed=1,
        **more,
    )


def verdict(*effects: str, others: tuple[str, ...] = (), **more: Any) -> dict[str, Any]:  # noqa: ANN401
    return {
        "verdict": {"effects": list(effects), "probability": 0.9, "ambiguous_with": list(others)},
        "gap": {
            "where": {
                "channels": ["u"],
                "regimes": [{"regressor": "command_level"}],
                "times": more.pop("times", []),
            }
        },
        "ranking": [
            {
                "effect": "+".join(effects),
                "parameters": {"t": {"value": 0.21, "unit": "1", "ci95": [0.19, 0.23]}},
            }
        ],
        "shrink": {"before": 6.0, "after": 1.05, "noise_floor": 1.0, "gap_closed": 0.99},
        "confusable": more.pop("confusable", []),
        "elapsed_s": 12.0,
    }


def test_a_right_answer() -> None:
    score = score_case("c", label(), verdict("thrust_deduction"))
    assert score.first_right
    assert score.in_set
    assert score.separable
    assert score.set_size == 1
    assert not score.confidently_wrong
    assert score.channel_right
    assert score.regime_right
    assert score.after_over_floor == pytest.approx(1.05)
    assert [(one.inside, one.half_width_share) for one in score.intervals] == [
        (True, pytest.approx(0.1))
    ]


def test_an_axis_is_told_by_its_velocity() -> None:
    heave = TrueEffect(effect="quadratic_damping", parameters={"heave": 1.5}, axes=("heave",))
    said = verdict("quadratic_damping")
    for axes, right in ((["w"], True), (["u", "w"], True), (["u"], False), ([], None)):
        said["verdict"]["detail"] = {"thruster": None, "axes": axes}
        assert score_case("c", label(effects=(heave,)), said).detail_right is right


def test_a_wrong_answer_is_confidently_wrong_unless_the_truth_is_told_too() -> None:
    wrong = score_case("c", label(), verdict("added_mass"))
    assert not wrong.first_right
    assert wrong.confidently_wrong
    hedged = score_case("c", label(), verdict("added_mass", others=("thrust_deduction",)))
    assert not hedged.first_right
    assert hedged.in_set
    assert hedged.abstained
    assert not hedged.confidently_wrong


def test_an_effect_too_many_is_wrong_unless_something_stands_beside_it() -> None:
    sure = score_case("c", label(), verdict("current", "thrust_deduction"))
    assert sure.in_set
    assert sure.confidently_wrong
    hedged = verdict("current", "thrust_deduction", others=("unknown",))
    assert not score_case("c", label(), hedged).confidently_wrong


def test_confusable_effects_are_one_answer() -> None:
    alike = [["added_mass", "thrust_deduction", -0.99]]
    told = verdict("added_mass", others=("thrust_deduction",), confusable=alike)
    score = score_case("c", label(), told)
    assert score.separable is False
    assert score.group_right
    alone = score_case("c", label(), verdict("added_mass", confusable=alike))
    assert not alone.group_right


def test_a_fault_that_hardly_shows_may_be_none() -> None:
    assert not score_case("c", label(ratio=1.05), verdict("none")).confidently_wrong


def test_none_and_its_false_alarms() -> None:
    quiet = label("none", 1.0)
    assert score_case("c", quiet, verdict("none")).false_alarm is False
    assert score_case("c", quiet, verdict("current")).false_alarm is True
    assert score_case("c", quiet, {"refused": "too short"}).false_alarm is False


def test_an_overlapping_effect_counts_for_a_trouble_if_its_times_are_told() -> None:
    snag = label("outside", trouble="line_snag", overlaps=("tether",))
    assert score_case("c", snag, verdict("unknown")).unknown_right
    assert not score_case("c", snag, verdict("tether")).unknown_right
    times = [{"run": "run_1", "from_s": 60.0, "to_s": 90.0, "share": 0.9}]
    assert score_case("c", snag, verdict("tether", times=times)).unknown_right
    assert not score_case("c", snag, verdict("current", times=times)).unknown_right


def test_an_effect_left_out_must_be_unknown() -> None:
    assert score_case("c", label("leave_one_out"), verdict("unknown")).unknown_right
    wrong = score_case("c", label("leave_one_out"), verdict("added_mass"))
    assert not wrong.unknown_right
    assert wrong.confidently_wrong


def test_pairs() -> None:
    two = tuple(TrueEffect(effect=name, parameters={}) for name in ("current", "dead_zone"))
    pair = label("pair", effects=two)
    assert score_case("c", pair, verdict("current", "dead_zone")).pair_exact
    half = score_case("c", pair, verdict("current"))
    assert half.pair_any
    assert not half.pair_exact
    assert half.confidently_wrong


def test_the_other_effect_of_a_pair_alone_is_no_mistake_where_one_hardly_shows() -> None:
    two = tuple(TrueEffect(effect=name, parameters={}) for name in ("current", "dead_zone"))
    pair = label("pair", effects=two, own_ratios={"current": 5.9, "dead_zone": 1.05})
    larger = score_case("c", pair, verdict("current"))
    assert larger.smaller_gap == 1.05
    assert not larger.pair_exact
    assert not larger.confidently_wrong
    assert score_case("c", pair, verdict("dead_zone")).confidently_wrong


def test_pairs_are_counted_by_what_the_smaller_effect_adds() -> None:
    two = tuple(TrueEffect(effect=name, parameters={}) for name in ("current", "dead_zone"))
    scores = [
        score_case(
            "c",
            label("pair", effects=two, own_ratios={"current": 6.0, "dead_zone": ratio}),
            verdict(*answer),
        )
        for ratio, answer in (
            (1.0, ("current",)),
            (2.0, ("current", "dead_zone")),
            (2.5, ("current",)),
            (4.0, ("current", "dead_zone")),
        )
    ]
    found = {(one.question, one.stratum): one for one in score_campaign(scores).rates}
    exact = [
        (one.yes, one.cases)
        for (question, where), one in found.items()
        if question == "exact pair" and where.startswith("gap of the smaller one")
    ]
    assert exact == [(0, 1), (1, 2), (1, 1)]
    assert found["exact pair", "with healthy runs"].cases == 4


def test_a_campaign_is_counted_by_band() -> None:
    scores: list[CaseScore] = [
        score_case("a", label(ratio=2.0), verdict("thrust_deduction")),
        score_case("b", label(ratio=2.5), verdict("added_mass")),
        score_case("c", label(ratio=6.0), verdict("thrust_deduction")),
        score_case("d", label("none", 1.0), verdict("none")),
        score_case("e", label(ratio=1.05), verdict("none")),
    ]
    total = score_campaign(scores)
    found = {(one.question, one.stratum): one for one in total.rates}
    assert found["truth in the answer set", "gap 1-3"].yes == 1
    assert found["truth in the answer set", "gap 1-3"].cases == 3
    # what hardly shows is none of these
    assert found["truth in the answer set", "gap 1.15-3"].cases == 2
    low = found["right effect first", "gap 1-3, separable"]
    assert (low.yes, low.cases, low.met) == (1, 3, False)
    assert found["right effect first", "gap 3-10, separable"].yes == 1
    assert found["right effect first", "gap >10, separable"].share is None
    assert found["false alarm on none", "with healthy runs"].met
    rows = dict(zip(total.confusion.truths, total.confusion.counts, strict=True))
    assert rows["thrust_deduction"][total.confusion.answers.index("added_mass")] == 1
    assert sum(map(sum, total.confusion.counts)) == 5


def test_the_plan_of_a_campaign(rov8: BlindSubject, carrier: BlindSubject) -> None:
    subjects = {one.name: one for one in (rov8, carrier)}
    total = sum(SHARES.values())
    plan = [case_of(number, subjects, seed=0) for number in range(total)]
    counts = {kind: sum(one.spec.kind == kind for one in plan) for kind in SHARES}
    assert counts == SHARES
    single = {(one.vehicle, one.spec.what[0]) for one in plan if one.spec.kind == "single"}
    wanted = {(name, effect) for name, s in subjects.items() for effect in possible_effects(s)}
    assert single == wanted
    assert all("dvl" not in o.spec.missing or "dvl" not in "".join(o.spec.what) for o in plan)
    assert len({one.spec.seed for one in plan}) == total
    # any part of the plan is spread over the kinds
    assert {one.spec.kind for one in plan[:20]} >= {"none", "single", "outside", "pair"}
