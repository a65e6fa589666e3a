"""One row a goal, and the cases that count against it, each with its worst fault."""

from typing import Any

import pytest

from pipeline.blind.goals import against_goals, missed
from pipeline.blind.verdict_score import CaseScore


def score(number: int = 0, **more: Any) -> CaseScore:  # noqa: ANN401 - fields of any type
    """Give a single effect of six floors, found."""
    usual = {
        "case": f"case_{number:05d}",
        "vehicle": "rov8",
        "kind": "single",
        "healthy": True,
        "missing": (),
        "manoeuvres": "trial",
        "gap_ratio": 6.0,
        "truth": ("lift",),
        "verdict": ("lift",),
        "ambiguous_with": (),
        "probability": 0.99,
        "separable": True,
        "first_right": True,
        "abstained": False,
        "in_set": True,
        "set_size": 1,
        "confidently_wrong": False,
        "elapsed_s": 20.0,
    }
    return CaseScore(**{**usual, **more})


PAIR = {"kind": "pair", "separable": None, "first_right": None}


def row(scores: list[CaseScore], stratum: str, question: str) -> tuple[int, int]:
    (found,) = (
        one for one in against_goals(scores) if (one.stratum, one.question) == (stratum, question)
    )
    return found.yes, found.cases


def test_three_floors_are_clear_and_less_is_small() -> None:
    scores = [
        score(gap_ratio=3.0),
        score(gap_ratio=20.0, first_right=False),
        score(gap_ratio=2.99, first_right=False, abstained=True),
    ]
    assert row(scores, "single, gap from 3, can be told apart", "first") == (1, 2)
    assert row(scores, "single, gap 1-3, can be told apart", "first") == (0, 1)
    assert row(scores, "single, gap 1-3, can be told apart", "first, or abstains") == (1, 1)


def test_what_cannot_be_told_apart_counts_in_the_set_alone() -> None:
    scores = [score(separable=False, first_right=False, in_set=False)]
    assert row(scores, "single, gap from 3, can be told apart", "first") == (0, 0)
    assert row(scores, "single, gap from 3", "in the answer set") == (0, 1)


def test_vehicles_with_and_without_healthy_runs_count_apart() -> None:
    scores = [
        score(kind="none", false_alarm=True, healthy=True),
        score(kind="none", false_alarm=False, healthy=False),
        score(**PAIR, pair_exact=True, pair_any=True, healthy=False),
        score(kind="outside", unknown_right=False, healthy=True),
    ]
    assert row(scores, "with healthy runs", "healthy vehicle called ill") == (1, 1)
    assert row(scores, "without healthy runs", "healthy vehicle called ill") == (0, 1)
    assert row(scores, "pair, without healthy runs", "both named") == (1, 1)
    assert row(scores, "pair, with healthy runs", "both named") == (0, 0)
    assert row(scores, "outside the library, with healthy runs", "called unknown") == (0, 1)


def test_a_goal_of_nothing_in_three_hundred_is_missed_by_one() -> None:
    healthy = [score(kind="none", false_alarm=number == 7) for number in range(300)]
    alarms = against_goals(healthy)[0]
    assert (alarms.yes, alarms.met) == (1, False)


@pytest.mark.parametrize(
    ("more", "fault"),
    [
        ({}, ""),
        ({"first_right": False, "ambiguous_with": ("lift",)}, "in the set, not first"),
        ({"first_right": False, "gap_ratio": 2.0}, ""),
        ({"first_right": False, "in_set": False}, "truth not in the set"),
        (
            {"first_right": False, "in_set": False, "confidently_wrong": True},
            "truth not in the set for sure",
        ),
        ({"kind": "none", "false_alarm": True, "confidently_wrong": True}, "healthy, called ill"),
        ({"kind": "none", "false_alarm": False}, ""),
        ({**PAIR, "pair_exact": False, "pair_any": True}, "not this pair"),
        (
            {**PAIR, "pair_exact": False, "pair_any": False, "confidently_wrong": True},
            "neither named for sure",
        ),
        ({**PAIR, "pair_exact": True, "pair_any": True}, ""),
        ({"kind": "outside", "unknown_right": False}, "not called unknown"),
        ({"kind": "outside", "unknown_right": True, "in_set": False}, ""),
        ({"kind": "leave_one_out", "confidently_wrong": True}, "another effect for sure"),
        ({"kind": "leave_one_out", "unknown_right": False, "in_set": False}, ""),
        ({"refused": "too short", "in_set": False}, "refused"),
    ],
)
def test_the_fault_of_an_answer(more: dict[str, Any], fault: str) -> None:
    found = missed([score(**more)])
    assert [one.fault for one in found] == ([fault] if fault else [])


def test_misses_stand_by_number() -> None:
    wrong = {"first_right": False, "in_set": False}
    found = missed([score(12, **wrong), score(3), score(2, **wrong)])
    assert [one.score.case for one in found] == ["case_00002", "case_00012"]
