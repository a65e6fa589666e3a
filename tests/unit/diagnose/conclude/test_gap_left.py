"""What the gap that answers leave says of them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.diagnose.conclude.gap_left import by_gap_left, surprise
from pipeline.diagnose.rules.shares import Share

RANKING = (
    Share("added_mass", 0.90),
    Share("none", 0.06),
    Share("cg_shift", 0.03),
    Share("unknown", 0.01),
)


def test_the_answer_that_leaves_no_gap_goes_before_one_that_leaves_it() -> None:
    left = {"added_mass": surprise({"theta": 3.4, "z": 3.6}), "cg_shift": surprise({"z": 0.9})}
    shares = by_gap_left(RANKING, left)
    assert shares[0].name == "cg_shift"
    known = {one.name: one.probability for one in shares}
    # what is said of none and of what is unknown is not touched
    assert known["none"] == 0.06
    assert known["unknown"] == 0.01
    assert sum(known.values()) == pytest.approx(1.0)


def test_two_that_leave_alike_stay_as_they_were() -> None:
    shares = by_gap_left(RANKING, {"added_mass": 7.0, "cg_shift": 7.0})
    assert [one.name for one in shares] == [one.name for one in RANKING]
    assert [one.probability for one in shares] == pytest.approx(
        [one.probability for one in RANKING]
    )


def test_nothing_looked_at_changes_nothing() -> None:
    assert by_gap_left(RANKING, {}) == RANKING
    assert by_gap_left(RANKING, {"added_mass": np.inf}) == RANKING


def test_an_answer_that_no_vehicle_can_have_is_out() -> None:
    shares = by_gap_left(RANKING, {"added_mass": np.inf, "cg_shift": 30.0})
    assert {one.name: one.probability for one in shares}["cg_shift"] == pytest.approx(0.93)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1e6))
def test_within_the_floor_nothing_surprises_and_far_beyond_no_more(
    inside: float, beyond: float
) -> None:
    assert surprise({"u": inside}) == 0.0
    assert surprise({"u": 4.0 + beyond}) == surprise({"u": 4.0})
    assert surprise({"u": 2.0, "v": inside}) == surprise({"u": 2.0})
