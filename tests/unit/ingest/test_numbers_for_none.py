"""A number that stands for no reading is no reading; one that a sensor reads again and again is."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import rov

from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_health import value_marks
from pipeline.types import FloatArray

N = 400
T = np.arange(N) / 5.0


def depth(seed: int = 0) -> FloatArray:
    noise = np.random.default_rng(seed).normal(0.0, 0.01, N)
    return (4.0 + 1.5 * np.sin(0.1 * T) + noise)[:, None]


@pytest.mark.parametrize("none", [0.0, -99.0, -999.0, 65.535])
@pytest.mark.parametrize("every", [5, 40])
def test_a_number_far_from_all_others_is_left_out(none: float, every: int) -> None:
    values = depth()
    values[::every] = none
    assert (value_marks(values, 0.2)["dropout"] == (values[:, 0] == none)).all()


@pytest.mark.parametrize("none", [0.0, -32.768, 999.0])
def test_so_it_is_for_all_components(none: float) -> None:
    values = np.concatenate([depth(seed) for seed in range(3)], axis=1)
    values[7::9] = none
    assert (value_marks(values, 0.2)["dropout"] == (values[:, 0] == none)).all()


def test_what_a_sensor_reads_again_and_again_stays() -> None:
    surface = np.maximum(depth() - 4.0, 0.0)
    steps = np.round(np.random.default_rng(1).normal(0.0, 0.3, (N, 1)) + 48.0)
    loaded = np.where(np.arange(N)[:, None] % 50 < 25, 48.0, 40.0) + 0.01 * depth()
    still = np.round(depth() * 0.02, 1)
    for values in (surface, steps, np.round(loaded, 1), loaded, still):
        assert "dropout" not in value_marks(values, 0.2)


def test_a_pitch_that_none_can_be_is_no_attitude(tmp_path: Path) -> None:
    rows = [(0.2 * k, 3.0, 1.0 + 0.1 * (k % 7), 90.0 + 0.2 * k) for k in range(100)]
    text = [",".join(map(str, (t, *(one if k % 9 else (-999.0,) * 3)))) for k, (t, *one) in
            enumerate(rows)]  # fmt: skip
    (tmp_path / "run.csv").write_text("\n".join(["t,roll [deg],pitch [deg],yaw [deg]", *text]))
    channel = read_pool_run(tmp_path / "run.csv", rov(), tmp_path).channels["attitude"]
    assert np.flatnonzero(channel.marks["not_a_number"]).tolist() == list(range(0, 100, 9))
