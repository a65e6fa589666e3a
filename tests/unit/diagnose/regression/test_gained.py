"""Which finding of the gains counts as a dead thruster."""

import pytest

from pipeline.diagnose.regression.gained import gained_of
from pipeline.records.gains import GainFinding, ThrusterGains


def gains(*findings: tuple[str, str, float]) -> ThrusterGains:
    """Findings: kind, thruster, p-value."""
    found = tuple(
        GainFinding(
            kind=kind,  # type: ignore[arg-type]
            thrusters=(name,),
            runs=("b",),
            value=0.02,
            ci95=(-0.1, 0.14),
            p_value=p,
            text="",
        )
        for kind, name, p in findings
    )
    return ThrusterGains(
        vehicle="v", false_alarms=0.01, runs=(), gains=(), pooled=(), findings=found, not_judged={}
    )


def test_a_dead_thruster_counts_beside_something_hardly_found() -> None:
    (alone,) = gained_of(gains(("dead", "sway", 1e-6)), ["a", "b"])
    assert (alone.thruster, alone.runs, alone.p_value) == ("sway", (1,), 1e-6)
    (beside,) = gained_of(gains(("dead", "sway", 1e-6), ("reversed", "rear", 8e-3)), ["a", "b"])
    assert beside.p_value == pytest.approx(1e-6 / 8e-3)


@pytest.mark.parametrize(
    "findings",
    [
        (),
        (("weak", "sway", 1e-6),),
        # a dead zone: all of them do nothing
        (("dead", "sway", 1e-8), ("dead", "rear", 1e-6), ("dead", "left", 1e-5)),
        (("swapped", "left", 1e-9), ("dead", "sway", 1e-6)),
    ],
)
def test_what_has_another_cause_does_not(findings: tuple[tuple[str, str, float], ...]) -> None:
    assert gained_of(gains(*findings), ["a", "b"]) == ()
