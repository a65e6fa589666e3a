"""A common factor of two mooring tests is told from factors ahead and astern."""

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.identify.bench_changes import bench_changes
from pipeline.records.measurements import MooringPoint, Source


def points(ahead: float, astern: float, codes: range = range(-100, 101, 10)) -> list[MooringPoint]:
    noise = np.random.default_rng(3).normal(0.0, 0.05, 201)
    return [
        MooringPoint(
            source=Source(file="a.csv", sheet=None, row=row),
            code=code,
            thrust_n=(ahead if code > 0 else astern) * 0.004 * code * abs(code) + noise[code],
            sweep="up",
        )
        for row, code in enumerate(codes, start=2)
    ]


def test_a_common_factor_is_one_difference() -> None:
    standing, asked, (curve,) = bench_changes(points(1.0, 0.8), points(0.7, 0.56))
    (one,) = standing
    assert one.kind == "common_factor"
    assert one.ratio == pytest.approx(0.70, abs=0.01)
    assert len(asked) == 3
    assert len(curve.a_x) == 21


def test_one_sign_alone_is_no_common_factor() -> None:
    standing, _, _ = bench_changes(points(1.0, 0.8), points(0.7, 0.8))
    (one,) = standing
    assert (one.kind, one.what) == ("factor", "thrust ahead")
    assert one.ratio == pytest.approx(0.70, abs=0.01)


def test_the_same_thruster_again_is_no_difference() -> None:
    assert bench_changes(points(1.0, 0.8), points(1.005, 0.8))[0] == ()


def test_codes_that_do_not_meet_cannot_be_compared() -> None:
    with pytest.raises(CannotComputeError, match="no codes in common"):
        bench_changes(points(1.0, 0.8, range(10, 60, 10)), points(1.0, 0.8, range(60, 110, 10)))
