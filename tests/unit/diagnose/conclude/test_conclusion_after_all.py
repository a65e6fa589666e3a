"""What is unknown by its force, and leaves no gap."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_cases import index_of, small_coordinates

from pipeline.diagnose.conclude import conclusion
from pipeline.diagnose.conclude.conclusion import explained_after_all
from pipeline.diagnose.conclude.consequences import Ahead
from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.judging.search import Judged, Search
from pipeline.diagnose.linear.scales import Level


def finding(place: int, name: str, log_evidence: float) -> Finding:
    one = np.ones(1)
    return Finding(((name, None),), (place,), log_evidence, one, np.eye(1), one)


def looked_at(
    monkeypatch: pytest.MonkeyPatch, before: float, after: dict[str, float]
) -> list[tuple[str, float]]:
    """Answers and their probabilities, where effects leave such a gap in the only channel."""
    every = small_coordinates()
    buoyancy = index_of(every, "residual_buoyancy:force_n")
    scale = index_of(every, "dvl_scale:scale")
    singles = (
        finding(buoyancy, "residual_buoyancy", 900.0),
        finding(scale, "dvl_scale", 300.0),
    )
    judged = cast(
        "Judged",
        SimpleNamespace(nothing=0.0, singles=singles, pairs=(), level=Level(np.ones(6), 1.0, True)),
    )
    found: Any = SimpleNamespace(
        reach=np.ones(len(every)),
        setting=SimpleNamespace(coordinates=every),
        judged=(judged,),
    )

    def ratios(_found: Search, _ahead: Ahead, one: Candidate | None) -> dict[str, float]:
        return {"u": before if one is None else after.get(one.name, before)}

    monkeypatch.setattr(conclusion, "ratios_left", ratios)
    unknown = Candidate("unknown", 0.98, 5000.0, singles[0], judged)
    others = (
        Candidate("residual_buoyancy", 0.01, 10.0, singles[0], judged),
        Candidate("none", 0.01, 0.0, None, judged),
    )
    answered = explained_after_all(
        cast("Search", found), cast("Ahead", None), Answers((unknown, *others))
    )
    assert sum(one.probability for one in answered.ranking) == pytest.approx(1.0)
    return [(one.name, one.probability) for one in answered.ranking]


def test_an_effect_that_leaves_no_gap_goes_before_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = looked_at(monkeypatch, 3.0, {"residual_buoyancy": 0.9})
    assert rows[0] == ("residual_buoyancy", pytest.approx(0.98 * 0.9 + 0.01))
    # what is left is still told
    assert rows[1] == ("unknown", pytest.approx(0.098))


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (3.0, {"residual_buoyancy": 1.2}),  # a gap is left, as of what comes and goes
        (1.3, {"residual_buoyancy": 0.9}),  # there was hardly one
    ],
)
def test_else_it_stays_unknown(
    monkeypatch: pytest.MonkeyPatch, before: float, after: dict[str, float]
) -> None:
    rows = looked_at(monkeypatch, before, after)
    assert rows[0] == ("unknown", 0.98)


def test_the_strongest_that_closes_the_gap_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = looked_at(monkeypatch, 3.0, {"dvl_scale": 0.5, "residual_buoyancy": 0.95})
    assert rows[0][0] == "residual_buoyancy"
    rows = looked_at(monkeypatch, 3.0, {"dvl_scale": 0.5})
    assert rows[0][0] == "dvl_scale"
