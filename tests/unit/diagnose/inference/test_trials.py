"""The way from one point to the next."""

from typing import cast

from hypothesis import given
from hypothesis import strategies as st

from pipeline.diagnose.inference.trials import Trial, climbed


class _Valued:
    """As much of a trial as the way up needs."""

    def __init__(self, place: int, value: float) -> None:
        self.place, self.value = place, value


@given(
    st.integers(1, 12).flatmap(
        lambda count: st.tuples(
            st.just(count), st.integers(0, count - 1), st.integers(0, count - 1)
        )
    )
)
def test_the_top_is_found_from_everywhere_and_no_other_place_is_looked_at_twice(
    row: tuple[int, int, int],
) -> None:
    count, top, begin = row
    seen: list[int] = []

    def judged(place: int) -> Trial:
        seen.append(place)
        return cast("Trial", _Valued(place, -abs(place - top)))

    found = cast("_Valued", climbed(judged, begin, count))
    assert found.place == top
    assert len(seen) == len(set(seen))
    # beside the way only the first steps that lead down
    assert len(seen) <= abs(top - begin) + 3
