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


@pytest.mark.parametrize("off", [0.0, 0.3])
def test_all_is_judged_around_the_own_point_of_the_first_answer(
    monkeypatch: pytest.MonkeyPatch, off: float
) -> None:
    """As a vehicle that nearly capsizes where an effect was followed to that is not there."""
    seen: list[np.ndarray] = []
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
        finding = first.ranking[0].finding
        return replace(own, points={() if finding is None else finding.which: moved})

    monkeypatch.setattr(inference, "search", search)
    monkeypatch.setattr(inference, "refined", refined)
    found = engine.diagnose(
        small_case(("residual_buoyancy:force_n=8",), effects=("residual_buoyancy",)), threads=1
    )
    assert found.verdict.effects == ("residual_buoyancy",)
    if off:
        assert len(seen) == 2
        assert seen[1][0] == pytest.approx(seen[0][0] + off)
    else:
        assert len(seen) == 1
