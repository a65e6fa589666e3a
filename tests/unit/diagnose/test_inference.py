"""Where all is judged: around the first answer's own point, if that is elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose import engine, inference
from pipeline.diagnose.answer import Answers
from pipeline.diagnose.refine import Refined
from pipeline.diagnose.search import Near, Search
from pipeline.diagnose.trials import Lead
from pipeline.errors import CannotComputeError


@pytest.mark.parametrize("off", [0.0, 0.4])
def test_all_is_judged_around_the_own_point_of_the_first_answer(
    monkeypatch: pytest.MonkeyPatch, off: float
) -> None:
    """As a vehicle that nearly capsizes where an effect was followed to that is not there."""
    seen: list[np.ndarray] = []
    asked: list[np.ndarray] = []
    real_search, real_refined = inference.search, inference.refined

    def search(setting, near: Near, *rest) -> Search:  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN002
        seen.append(near.departures)
        return real_search(setting, near, *rest)

    def refined(found: Search, first: Answers, lead: Lead, most: int) -> Refined:
        own = real_refined(found, first, lead, most)
        if len(seen) > 1:
            return own
        moved = found.model.point.departures.copy()
        moved[0] += off
        asked.append(moved)
        finding = first.ranking[0].finding
        points = {() if finding is None else finding.which: moved}
        return replace(own, points=points, doubtful=True)

    monkeypatch.setattr(inference, "search", search)
    monkeypatch.setattr(inference, "refined", refined)
    found = engine.diagnose(
        small_case(("residual_buoyancy:force_n=8",), effects=("residual_buoyancy",)), threads=1
    )
    assert found.verdict.effects == ("residual_buoyancy",)
    if off:
        assert len(seen) == 2
        assert seen[1] == pytest.approx(asked[0])
    else:
        assert len(seen) == 1


def test_what_was_judged_first_stands_where_nothing_can_fly_from_the_own_point(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Measured pool runs of a vehicle that hardly is its file were refused for that."""
    real_search, real_refined = inference.search, inference.refined
    seen: list[np.ndarray] = []

    def search(setting, near: Near, *rest) -> Search:  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN002
        seen.append(near.departures)
        if len(seen) > 1:
            raise CannotComputeError("the simulation runs away")
        return real_search(setting, near, *rest)

    def refined(found: Search, first: Answers, lead: Lead, most: int) -> Refined:
        own = real_refined(found, first, lead, most)
        finding = first.ranking[0].finding
        moved = found.model.point.departures + 0.4
        points = {() if finding is None else finding.which: moved}
        return replace(own, points=points, doubtful=True)

    monkeypatch.setattr(inference, "search", search)
    monkeypatch.setattr(inference, "refined", refined)
    found = engine.diagnose(
        small_case(("residual_buoyancy:force_n=8",), effects=("residual_buoyancy",)), threads=1
    )
    assert len(seen) == 2
    assert found.verdict.effects == ("residual_buoyancy",)
