"""A dead thruster by its gains is named where an answer names nothing."""

import diagnosis_records
import pytest

from pipeline.diagnose.regression.gained import Gained, odds_of_test, with_dead_thruster
from pipeline.records.diagnosis import Detail, DiagnosisRecord, Verdict

DEAD = Gained("upper", (0,), 0.02, (-0.05, 0.09), 1e-4)


def record(probability: float, *effects: str) -> DiagnosisRecord:
    made = diagnosis_records.diagnosis(channels=("w", "psi"), windows=4)
    verdict = Verdict(
        effects=effects,
        probability=probability,
        ambiguous_with=(),
        detail=Detail(),
        sentence="So.",
    )
    return made.model_copy(update={"verdict": verdict})


def test_the_odds_of_a_test_by_hand() -> None:
    """-1 / (e p ln p) is 399.4 at p = 1e-4; three to seven before."""
    assert odds_of_test(1e-4) == pytest.approx(399.4 * 3.0 / 7.0, rel=1e-3)


def test_it_is_named_where_nothing_is() -> None:
    told, (spec,) = with_dead_thruster(record(0.9, "unknown"), DEAD)
    assert told.verdict.effects == ("thruster_degraded", "unknown")
    assert told.verdict.detail.thruster == spec.target == "upper"
    assert told.verdict.probability == told.ranking[0].probability == pytest.approx(0.994, abs=1e-3)
    assert told.ranking[0].parameters["thrust_fraction"].ci95 == (0.0, 0.09)
    assert told.verdict.runs == (told.runs[0],)
    assert sum(one.probability for one in told.ranking) <= 1.0 + 1e-9
