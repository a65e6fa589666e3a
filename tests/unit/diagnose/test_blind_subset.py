"""A small fixed part of the blind check: cases of the separate truth, with their verdicts."""

from pathlib import Path

import pytest

from pipeline.blind.generate import CaseSpec, generate
from pipeline.campaign.blind_case import diagnose_in_memory, load_subject, packed_of
from pipeline.effects.library import candidates

#: Effects that are asked for where few are.
FEW = {"dvl_scale", "residual_buoyancy", "thruster_degraded"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "what", "seed"),
    [("none", (), 501), ("single", ("dvl_scale",), 503)],
)
def test_verdict_on_a_case_of_the_separate_truth(
    kind: str, what: tuple[str, ...], seed: int
) -> None:
    subject = load_subject("rov8", Path("raw"), Path())
    case = generate(
        subject, CaseSpec(kind, what, severity=6.0, healthy=0, duration_s=16.0, seed=seed)
    )
    verdict = diagnose_in_memory(case, packed_of(case.subject), ())["verdict"]
    # at 1.6 floors and 16 s one answer cannot be told from its neighbour
    assert set(case.label.truth) <= {*verdict["effects"], *verdict["ambiguous_with"]}
    assert (tuple(verdict["effects"]) == ("none",)) == (kind == "none")


def test_verdict_among_a_few_effects() -> None:
    subject = load_subject("rov8", Path("raw"), Path())
    spec = CaseSpec("single", ("dvl_scale",), severity=6.0, healthy=0, duration_s=16.0, seed=503)
    case = generate(subject, spec)
    packed = packed_of(case.subject)
    others = tuple(set(candidates(packed.context)) - FEW)
    verdict = diagnose_in_memory(case, packed, others)["verdict"]
    assert tuple(verdict["effects"]) == case.label.truth
