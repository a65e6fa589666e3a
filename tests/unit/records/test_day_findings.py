"""Answers of single runs and of all together: which run carries which finding."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "report"))
import diagnosis_records

from pipeline.records.day_findings import agree, day_findings
from pipeline.records.diagnosis import Detail, DiagnosisRecord


def answer(
    effects: str, probability: float, others: tuple[str, ...] = (), thruster: str | None = None
) -> DiagnosisRecord:
    base = diagnosis_records.diagnosis(channels=(), windows=1)
    verdict = base.verdict.model_copy(
        update={
            "effects": (effects,),
            "probability": probability,
            "ambiguous_with": others,
            "detail": Detail(thruster=thruster),
        }
    )
    return base.model_copy(update={"verdict": verdict})


SOUND = answer("none", 0.98)
BAD = answer("thruster_degraded", 0.99, thruster="upper")
FAINT = answer("residual_buoyancy", 0.74, ("none", "payload"))


def test_a_fault_of_one_run_stays_that_runs() -> None:
    alone = {"straight": SOUND, "zig-zag": BAD, "pitch": SOUND}
    assert not agree(alone)
    fault, sound = day_findings(alone, answer("unknown", 0.74))
    assert (fault.effects, fault.thruster, fault.runs) == (
        ("thruster_degraded",), "upper", ("zig-zag",),
    )  # fmt: skip
    assert (sound.effects, sound.runs, sound.by) == (("none",), ("straight", "pitch"), "run")


def test_what_no_run_rules_out_is_left_to_all_together() -> None:
    alone = {"heave": FAINT, "surge": SOUND}
    assert agree(alone)
    (found,) = day_findings(alone, answer("none", 0.96))
    assert (found.effects, found.runs, found.by) == (("none",), ("heave", "surge"), "together")


def test_a_fault_that_shows_only_together_counts() -> None:
    (found,) = day_findings({"a": SOUND, "b": SOUND}, FAINT)
    assert found.effects == ("residual_buoyancy",)


def test_the_same_fault_at_two_thrusters_is_two_findings() -> None:
    other = answer("thruster_degraded", 0.9, thruster="lower")
    assert not agree({"a": BAD, "b": other})
    assert [one.thruster for one in day_findings({"b": other, "a": BAD})] == ["upper", "lower"]


def test_what_may_be_nothing_is_sound_beside_sound_runs_that_rule_out_the_rest() -> None:
    fault, sound = day_findings({"a": BAD, "b": FAINT, "c": SOUND})
    assert fault.runs == ("a",)
    assert sound.runs == ("b", "c")


def test_no_run_is_no_finding() -> None:
    assert day_findings({}) == ()
    assert not agree({})


def test_the_run_that_carries_a_fault_is_shown_first() -> None:
    base = diagnosis_records.diagnosis(channels=("u",), windows=1)
    (first, *_) = base.series
    series = tuple(first.model_copy(update={"run": name}) for name in ("straight", "zig-zag"))
    verdict = base.verdict.model_copy(update={"runs": ("zig-zag",)})
    record = base.model_copy(update={"series": series, "verdict": verdict})
    (found,) = day_findings({"all": record}, record)[:1]
    assert [one.run for one in found.shown] == ["zig-zag", "straight"]
