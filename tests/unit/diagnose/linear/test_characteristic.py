"""What a thruster's curve may be off by: at which codes, of which sign, of which thrusters."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled
from diagnosis_cases import small_case

from pipeline.diagnose.case import channels_of, setting_of
from pipeline.diagnose.linear.characteristic import (
    FORMULA_SHARE,
    KNOTS,
    TABLE_SHARE,
    characteristic_profiles,
    curve_errors,
)
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.physics.parameters import read
from pipeline.simulate.kernel import BODY
from pipeline.simulate.pieces import run_pieces
from pipeline.types import FloatArray


@pytest.fixture(scope="module")
def setting() -> Setting:
    """rov8, which has one kind of thruster, driven to and fro."""
    case = small_case(manoeuvres=("prbs",), seconds=12.5)
    return setting_of(case, case.runs, channels_of(case.vehicle, case.runs), threads=1)


@pytest.fixture(scope="module")
def profiles(setting: Setting) -> FloatArray:
    bench = setting.bench
    windows = bench.stack.windows
    return characteristic_profiles(bench.stack.packed, windows, bench.whole, setting.curves)


@pytest.mark.parametrize(("name", "share"), [("rov8", FORMULA_SHARE), ("mmt300", TABLE_SHARE)])
def test_a_formula_is_less_sure_than_the_tables_of_the_bench(
    repository: Path, name: str, share: float
) -> None:
    np.testing.assert_array_equal(curve_errors(bundled(repository, name), 0.02).shape, share)


def test_each_knot_acts_near_its_codes_and_of_its_sign(
    setting: Setting, profiles: FloatArray
) -> None:
    """Where no thruster is between the knots around it, of its sign, there is no force."""
    bench, packed = setting.bench, setting.bench.stack.packed
    count = len(packed.thruster_names)
    assert profiles.shape[2] == 2 * len(KNOTS) + count + 1
    starts = np.stack([window.start for window in bench.stack.windows])
    still = np.zeros((len(profiles), 6))
    states, _ = run_pieces(packed, bench.whole, packed.vector, starts, still)
    steps = np.arange(len(profiles))
    window = np.searchsorted(bench.whole.bounds, steps, "right") - 1
    share = states[steps + window, BODY : BODY + count] / read(packed.vector, "code_max")[:count]
    edges = (0.0, *KNOTS, np.inf)
    seen = []
    for side, sign in enumerate((1.0, -1.0)):
        for number in range(len(KNOTS)):
            own = (sign * share > edges[number]) & (sign * share < edges[number + 2])
            acts = np.abs(profiles[:, :, side * len(KNOTS) + number]).sum(axis=1) > 0.0
            # the force of thrusters that push against each other may be none
            assert not acts[~own.any(axis=1)].any()
            seen.append(bool(acts.any()))
    assert sum(seen) >= len(KNOTS)


def test_a_curve_that_is_off_at_every_knot_is_off_by_no_more_than_its_share(
    setting: Setting, profiles: FloatArray
) -> None:
    packed = setting.bench.stack.packed
    most = float(packed.thrust_tables[0, 0, 0].max())
    together = np.abs(profiles[:, :3, : len(KNOTS)].sum(axis=2)).max()
    assert 0.0 < together <= FORMULA_SHARE * most * len(packed.thruster_names)
