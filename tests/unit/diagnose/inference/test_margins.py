"""What a lead in evidence is worth where the linear model and the full one do not agree."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.diagnose.inference.answer import Candidate
from pipeline.diagnose.inference.margins import cautious, trusted_lead
from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.judging.search import Judged, Search
from pipeline.diagnose.linear.elimination import Grams, Marginal
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import LinearModel
from pipeline.diagnose.linear.scales import Level

leads = st.floats(-1e5, 1e5)


@given(leads, leads)
def test_a_lead_is_never_worth_more_than_the_full_model_says(linear: float, full: float) -> None:
    worth = trusted_lead(linear, full)
    assert abs(worth) <= abs(full) + 1e-9
    assert worth * full >= 0.0
    assert worth == pytest.approx(-trusted_lead(-linear, -full))


@given(leads)
def test_a_lead_that_both_see_is_worth_all_of_it(lead: float) -> None:
    assert trusted_lead(lead, lead) == pytest.approx(lead)


@given(st.floats(50.0, 1e5))
def test_a_lead_that_only_one_sees_is_worth_next_to_nothing(lead: float) -> None:
    # r / sqrt(1 + pi r^2 / 8) tends to sqrt(8 / pi)
    assert trusted_lead(0.0, lead) == pytest.approx(np.sqrt(8.0 / np.pi), rel=1e-2)


def _finding(effect: str, gain: float) -> Finding:
    one = np.ones(1)
    return Finding(((effect, None),), (0,), gain, one, np.eye(1), one)


def _judged(nothing: float, *singles: Finding) -> Judged:
    nil = Marginal(np.eye(1), np.zeros(1), 0.0, 0.0)
    return Judged(Level(np.ones(6), 1.0, True), nil, nil, nothing, singles, ())


def _search(*judged: Judged) -> Search:
    none = np.zeros(0)
    return Search(
        LinearModel.__new__(LinearModel),
        Grams(none, none, none, none.astype(int), none, none.astype(int), none.astype(int), none),
        Prior(none, none),
        judged,
        {},
        {},
        1,
        none.astype(bool),
        none,
    )


def _top(search: Search) -> Candidate:
    judged = search.judged[0]
    return Candidate("voltage_sag", 1.0, 0.0, judged.singles[0], judged)


def test_an_effect_leads_none_by_what_both_models_grant_it() -> None:
    linear = _search(_judged(100.0, _finding("voltage_sag", 2.2), _finding("lift", 1.0)))
    full = _search(_judged(-50.0, _finding("voltage_sag", 49.0), _finding("lift", 20.0)))
    (one,) = cautious(linear, full, _top(full)).judged
    assert one.singles[0].log_evidence == pytest.approx(2.2)
    # effects stay as far apart, and where they were
    assert one.nothing + one.singles[0].log_evidence == pytest.approx(-1.0)
    assert one.singles[0].log_evidence - one.singles[1].log_evidence == pytest.approx(29.0)


def test_a_lead_of_two_answers_that_were_seen_where_they_stay_is_worth_all_of_it() -> None:
    linear = _search(_judged(100.0, _finding("voltage_sag", 2.2)))
    full = _search(_judged(-50.0, _finding("voltage_sag", 49.0)))
    for sure, worth in (({(), (0,)}, 49.0), ({(0,)}, 2.2), ({()}, 2.2)):
        (one,) = cautious(linear, full, _top(full), sure).judged
        assert one.singles[0].log_evidence == pytest.approx(worth)


def test_nothing_changes_where_none_is_first_or_the_models_agree() -> None:
    full = _search(_judged(-50.0, _finding("voltage_sag", 49.0)))
    first = _top(full)
    assert cautious(full, full, replace(first, name="none", finding=None)) is full
    (one,) = cautious(full, full, first).judged
    assert one.nothing == pytest.approx(-50.0)
    assert one.singles[0].log_evidence == pytest.approx(49.0)


@pytest.mark.parametrize(("linear_lead", "worth"), [(6.0, 6.0), (30.0, 20.0), (-100.0, 0.266)])
def test_two_effects_lead_one_of_them_by_what_both_models_grant(
    linear_lead: float, worth: float
) -> None:
    def seen(lead: float) -> Search:
        alone = _judged(0.0, _finding("voltage_sag", 50.0), _finding("lift", 40.0))
        one = np.ones(2)
        groups = (("dead_zone", None), ("voltage_sag", None))
        pair = Finding(groups, (0, 1), 50.0 + lead, one, np.eye(2), one)
        return _search(replace(alone, pairs=(pair,)))

    full = seen(20.0)
    judged = full.judged[0]
    top = Candidate("dead_zone+voltage_sag", 1.0, 0.0, judged.pairs[0], judged)
    (one,) = cautious(seen(linear_lead), full, top).judged
    lead = one.pairs[0].log_evidence - one.singles[0].log_evidence
    assert lead == pytest.approx(worth, rel=0.05)
    # an effect that is not one of the two stays where it was
    assert one.pairs[0].log_evidence - one.singles[1].log_evidence == pytest.approx(30.0)
