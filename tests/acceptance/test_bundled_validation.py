"""mmt300 flown with the tables that the run made: the paper's claim in numbers."""

from pathlib import Path
from typing import Any

import pytest
from bundled_bench import run_of_mmt300
from workflow_runs import Finished

SPEEDS = [0.0, 0.5, 1.0, 1.5, 2.0]


@pytest.fixture(scope="module")
def flown(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:  # noqa: ANN401 - JSON
    """The record of the bundled run, which other tests share."""
    finished = Finished(run_of_mmt300(repository, tmp_path_factory))
    return finished.record("mmt300", "validation")


def kept(flown: Any, variant: str) -> dict[float, Any]:  # noqa: ANN401 - JSON
    """Keeping flights by speed."""
    return {one["speed_mps"]: one for one in flown["keeping"] if one["variant"] == variant}


def stepped(flown: Any, variant: str, step: str) -> dict[float, Any]:  # noqa: ANN401 - JSON
    """Step flights by speed."""
    return {
        one["speed_at_mps"]: one
        for one in flown["steps"]
        if (one["variant"], one["step"]) == (variant, step)
    }


def test_the_speeds_and_the_allocator_are_the_papers(flown: Any) -> None:  # noqa: ANN401
    assert flown["speed_mps"] == SPEEDS
    assert flown["allocator"] == "paper"
    assert flown["portions"] == [0.6, 0.4, 0.4]


def test_speed_errors_grow_without_compensation_only(flown: Any) -> None:  # noqa: ANN401
    moored, compensated = kept(flown, "mooring"), kept(flown, "compensated")
    errors = [moored[v]["speed_error_mps"] for v in SPEEDS]
    assert errors == sorted(errors)
    assert errors[3] == pytest.approx(0.139, rel=0.1)
    for speed in SPEEDS[1:4]:
        assert compensated[speed]["speed_error_mps"] < moored[speed]["speed_error_mps"] / 20
        assert moored[speed]["wrench_gain"][0] < 0.7
        assert compensated[speed]["wrench_gain"][0] == pytest.approx(1.0, abs=0.02)


def test_course_and_depth_suffer_far_less_than_the_paper_says(flown: Any) -> None:  # noqa: ANN401
    """Heading and pitch push one thruster up and its partner down: most of the loss cancels."""
    moored, compensated = kept(flown, "mooring"), kept(flown, "compensated")
    course = [moored[v]["heading_error_deg"] / compensated[v]["heading_error_deg"] for v in SPEEDS]
    depth = [moored[v]["depth_error_m"] / compensated[v]["depth_error_m"] for v in SPEEDS]
    assert 1.0 < max(course) < 1.4
    assert 0.95 < min(depth) < max(depth) < 1.2


def test_a_depth_step_reaches_the_pitch_through_the_mooring_inverse(flown: Any) -> None:  # noqa: ANN401
    ideal, moored, compensated = (
        stepped(flown, variant, "depth")[1.0]["pitch_deg"]
        for variant in ("ideal", "mooring", "compensated")
    )
    # 2.13 times; 2.33 times where a propeller that is not driven does not drag
    assert moored == pytest.approx(2.13 * ideal, rel=0.03)
    assert compensated < 1.25 * ideal


def test_two_metres_a_second_are_out_of_reach_of_these_portions(flown: Any) -> None:  # noqa: ANN401
    last = kept(flown, "compensated")[2.0]
    assert last["cut_surge_share"] > 0.9
    assert last["reached_mps"] == pytest.approx(1.69, abs=0.05)
    assert any("out of reach" in text for text in flown["explanations"])


def test_fixed_point_flies_as_floating_point(flown: Any) -> None:  # noqa: ANN401
    assert flown["fixed_point"]["largest_difference"] <= 1
    assert flown["fixed_point"]["differing_share"] < 0.005


def test_power_at_the_supply_is_known_and_above_that_of_the_shafts(flown: Any) -> None:  # noqa: ANN401
    for one in kept(flown, "compensated").values():
        assert one["thrust_power_w"] < one["shaft_power_w"] < one["electrical_power_w"]


def test_small_surge_portions_do_not_reach_and_small_heading_portions_turn_late(
    flown: Any,  # noqa: ANN401
) -> None:
    first, *others = flown["portions_flown"]
    assert first["flight"]["reached_mps"] < 1.3
    assert all(one["flight"]["reached_mps"] > 1.45 for one in others)
    assert others[-1]["heading_step_cut_share"] > others[0]["heading_step_cut_share"] + 0.3
