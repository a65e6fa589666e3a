"""The parts of an answer against sound runs: where, how far it shrinks, what to fly next."""

from dataclasses import replace

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case
from pipeline.diagnose.regression.answer import against
from pipeline.diagnose.regression.decide import Said
from pipeline.diagnose.regression.grid import on_grids
from pipeline.diagnose.regression.held_out import FileModel
from pipeline.diagnose.regression.known import Reference, learned
from pipeline.diagnose.regression.next_run import next_run
from pipeline.diagnose.regression.weigh import NONE, weighed
from pipeline.records.diagnosis import DiagnosisRecord

WEAK = "thruster_degraded"
SOUND = ("prbs", "surge_steps", "zig_zag", "heave_steps")


@pytest.fixture(scope="module")
def case() -> Case:
    """A weak thruster in two of its runs, against four sound ones."""
    sound = small_case(manoeuvres=SOUND, seconds=24.0)
    asked = small_case((f"{WEAK}:thrust_fraction=0.7@front_left",), seconds=24.0, seed=1)
    return replace(asked, healthy=sound.runs)


@pytest.fixture(scope="module")
def known(case: Case) -> Reference:
    return learned(case, {"vehicle file": FileModel(case.packed)})


@pytest.fixture(scope="module")
def told(case: Case, known: Reference) -> DiagnosisRecord:
    return against(case, known, ())[0]


def test_the_gap_has_horizons_channels_and_regimes(told: DiagnosisRecord) -> None:
    assert told.verdict.effects == (WEAK,)
    yaw = told.gap.channels["r"]
    assert {"0.5", "1", "2", "10"} == set(yaw.horizons)
    assert "r" in told.gap.where.channels
    assert "command_level" in {one.regressor for one in told.gap.by_regime}
    assert all(0.0 <= one.share <= 1.0 for one in told.gap.where.regimes)
    assert sum(one.share for one in told.gap.where.times) <= 1.0 + 1e-9


def test_what_the_change_leaves_is_told_not_what_was_there(told: DiagnosisRecord) -> None:
    assert told.leftover.axes["yaw"] < told.gap.channels["r"].ratio


def test_how_far_it_shrinks_has_intervals(told: DiagnosisRecord) -> None:
    for one in (told.shrink, told.shrink.channels["r"]):
        assert one.ci95 is not None
        assert one.gap_closed is not None
        low, high = one.ci95
        assert low < one.gap_closed < high
        assert low < high


def test_the_next_run_separates_what_is_alike(
    case: Case, known: Reference, told: DiagnosisRecord
) -> None:
    """From `none` by all that the change does, from another effect by less."""
    assert told.next_run is None or told.verdict.ambiguous_with
    learned_on, grids = known.best, [known.best.response.period_s]
    asked = [
        on_grids(case.packed, run, case.vehicle.sensors, known.directions, grids)[0]
        for run in case.runs
    ]
    ranking = weighed(learned_on.told(asked), known.directions, learned_on.ordinary)
    first = ranking[0]
    from_none = next_run(case, known, ranking, Said(first, (WEAK,), (NONE,)), {})
    beside = next_run(case, known, ranking, Said(first, (WEAK,), ("quadratic_damping",)), {})
    assert from_none is not None
    assert beside is not None
    assert from_none.separates == (WEAK, NONE)
    assert from_none.expected_separation_sigma >= beside.expected_separation_sigma > 0.0
    assert next_run(case, known, ranking, Said(first, (WEAK,), ()), {}) is None
