"""Where all is judged: around the first answer's own point, if that is elsewhere."""

from dataclasses import replace
from typing import Any

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose import engine
from pipeline.diagnose.inference import infer
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.inference.refine import Refined
from pipeline.diagnose.inference.trials import Lead
from pipeline.diagnose.judging.search import Near, Search
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.errors import CannotComputeError
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.types import FloatArray


def judged_from(
    monkeypatch: pytest.MonkeyPatch, off: float, *, flies: bool = True, times: int = 1
) -> tuple[DiagnosisRecord, list[FloatArray], list[FloatArray]]:
    """Diagnose with the first answer's own point so far from where all was judged.

    With the points at which all was judged, and the own points. Unless it `flies` no vehicle can
    follow from an own point. That it lies elsewhere is so as many `times`.
    """
    seen: list[FloatArray] = []
    own_points: list[FloatArray] = []
    real_search, real_refined = infer.search, infer.refined

    def search(setting: Setting, near: Near, *rest: Any) -> Search:  # noqa: ANN401 (passed on as they come)
        seen.append(near.departures)
        if len(seen) > 1 and not flies:
            raise CannotComputeError("the simulation runs away")
        return real_search(setting, near, *rest)

    def refined(found: Search, first: Answers, lead: Lead, most: int, elsewhere: float) -> Refined:
        own = real_refined(found, first, lead, most, elsewhere)
        if len(own_points) == times:
            return own
        moved = found.model.point.departures.copy()
        moved[0] += off
        own_points.append(moved)
        finding = first.ranking[0].finding
        points = {() if finding is None else finding.which: moved}
        return replace(own, points=points, doubtful=True)

    monkeypatch.setattr(infer, "search", search)
    monkeypatch.setattr(infer, "refined", refined)
    case = small_case(("residual_buoyancy:force_n=8",), effects=("residual_buoyancy",))
    return engine.diagnose(case, threads=1), seen, own_points


@pytest.mark.parametrize("off", [0.0, 0.4])
def test_all_is_judged_around_the_own_point_of_the_first_answer(
    monkeypatch: pytest.MonkeyPatch, off: float
) -> None:
    """As a vehicle that nearly capsizes where an effect was followed to that is not there."""
    found, seen, own_points = judged_from(monkeypatch, off)
    assert found.verdict.effects == ("residual_buoyancy",)
    if off:
        assert len(seen) == 2
        assert seen[1] == pytest.approx(own_points[0])
    else:
        assert len(seen) == 1


def test_the_own_point_is_gone_to_twice_more_where_it_lies_elsewhere_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A current over the hull's depth of travel: the second point was half of the way to it."""
    found, seen, own_points = judged_from(monkeypatch, 0.4, times=4)
    assert found.verdict.effects == ("residual_buoyancy",)
    # and not for ever
    assert len(seen) == 4
    assert seen[3] == pytest.approx(own_points[2])


def test_what_was_judged_first_stands_where_nothing_can_fly_from_the_own_point(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Measured pool runs of a vehicle that hardly is its file were refused for that."""
    found, seen, _ = judged_from(monkeypatch, 0.4, flies=False)
    assert len(seen) == 2
    assert found.verdict.effects == ("residual_buoyancy",)
