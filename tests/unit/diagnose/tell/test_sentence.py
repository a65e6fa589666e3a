"""The verdict in words."""

import re

import pytest

from pipeline.diagnose.tell.sentence import sentence
from pipeline.records.diagnosis import Leftover, RankedEffect

LEFT = Leftover(
    axes={"surge": 0.9}, worst_axis="surge", time_course="throughout", depends_on=None,
    correlation=None,
)  # fmt: skip


def ranked(**probabilities: float) -> list[RankedEffect]:
    """Answers with nothing but their probabilities; `_and_` stands for the plus of a pair."""
    return [
        RankedEffect(
            effect=name.replace("_and_", "+"),
            probability=value,
            parameters={},
            gap_closed=None,
            log_evidence=0.0,
        )
        for name, value in probabilities.items()
    ]


def test_a_pair_whose_second_effect_is_not_sure_says_what_is_probable_alone() -> None:
    ranking = ranked(lift_and_payload=0.63, payload=0.37, lift=0.0)
    said = sentence(("lift", "payload"), 0.63, (), ranking, LEFT)
    assert said.endswith("(probability 0.63); payload alone has probability 0.37.")


@pytest.mark.parametrize("pair", [0.99, 0.96])
def test_a_sure_pair_is_said_without_more(pair: float) -> None:
    ranking = ranked(lift_and_payload=pair, payload=1.0 - pair)
    assert "alone" not in sentence(("lift", "payload"), pair, (), ranking, LEFT)


def test_what_an_effect_cannot_be_told_from_is_said_last() -> None:
    said = sentence(("payload",), 0.6, ("lift",), ranked(payload=0.6, lift=0.4), LEFT)
    assert said.endswith("(probability 0.60). These runs cannot tell it from lift.")


def test_two_thrusters_are_each_named_with_their_effect() -> None:
    (row,) = ranked(thruster_degraded_and_thruster_misalignment=0.99)
    row = row.model_copy(
        update={
            "thruster": "bow",
            "thrusters": {"thruster_degraded": "bow", "thruster_misalignment": "left"},
        }
    )
    said = sentence(("thruster_degraded", "thruster_misalignment"), 0.99, (), [row], LEFT)
    for name, place in row.thrusters.items():
        assert re.search(rf"{name} \([^)]*\) at {place}\b", said)


def test_none_beside_unknown_does_not_say_as_well_as_healthy() -> None:
    """It stands there where a channel is two to four healthy floors off."""
    ranking = ranked(none=0.55, unknown=0.43)
    said = sentence(("none",), 0.55, ("unknown",), ranking, LEFT)
    assert said.startswith("No effect: what the vehicle file states as uncertain suffices")
    assert said.endswith("(probability 0.55). These runs cannot tell it from unknown.")
    alone = sentence(("none",), 0.99, (), ranking, LEFT)
    assert "as well as a healthy vehicle" in alone
