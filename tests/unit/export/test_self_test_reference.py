"""The grids, the reference and the tolerances of the generated self-test."""

import fixed_model
import numpy as np
import pytest
from firmware_cases import CASES, strongest

from pipeline.export import fixed_point, self_test


def test_small_ranges_are_tested_code_by_code() -> None:
    grid = self_test.reference(CASES["table2"]())
    assert grid.code.tolist() == list(range(-127, 128))
    tabulated = np.rint(np.linspace(-2.0, 2.0, 17) * 65536)
    assert set(tabulated) <= set(grid.speed_q16)
    assert grid.thrust_n.shape == (len(grid.speed_q16), 255)


@pytest.mark.parametrize("case", ["bench_only", "largest_codes"])
def test_large_ranges_are_thinned_but_keep_their_ends(case: str) -> None:
    characteristic = CASES[case]()
    grid = self_test.reference(characteristic)
    assert {-characteristic.code_max, -1, 0, 1, characteristic.code_max} <= set(grid.code.tolist())
    assert len(grid.code) <= 260


def test_reference_ends_where_the_drive_does() -> None:
    grid = self_test.reference(CASES["weak_reverse"]())
    assert grid.code.tolist() == list(range(-100, 128))
    assert grid.unrounded_code.min() == -100
    rest = grid.speed_q16.tolist().index(0)
    assert grid.thrust_min_n[rest] == grid.thrust_n[rest, 0] > -30.3
    nothing = self_test.reference(CASES["forward_only"]())
    assert nothing.code.min() == nothing.unrounded_code.min() == nothing.thrust_min_n.min() == 0


def test_thrusts_beyond_the_largest_end_where_the_integers_do() -> None:
    thrust = self_test.reference(strongest(31_000.0)).thrust_q16
    assert thrust.max() == -thrust.min() == 2**31 - 1


def test_tolerances_are_local() -> None:
    """The code is steep where the speed does little; their largest values do not meet."""
    characteristic = CASES["largest_codes"]()
    single = characteristic.model_copy(
        update={
            name: branch.model_copy(
                update={
                    "speed_mps": branch.speed_mps[:1],
                    "thrust_max_n": branch.thrust_max_n[:1],
                    "code": branch.code[:1],
                }
            )
            for name, branch in (
                ("positive", characteristic.positive),
                ("negative", characteristic.negative),
            )
        }
    )
    at_rest, everywhere = self_test.tolerances(single), self_test.tolerances(characteristic)
    assert at_rest.code_fixed < everywhere.code_fixed < 10 * at_rest.code_fixed
    assert everywhere.trip_fixed == 1.0 + max(0.0, 3 * everywhere.code_fixed - 0.5)


def test_reference_is_the_double_precision_characteristic() -> None:
    """Kostenko's Table 2 at its own speeds and codes, where the grid's own error is small."""
    grid = self_test.reference(CASES["table2"]())
    row = grid.speed_q16.tolist().index(65536)
    column = grid.code.tolist().index(100)
    assert grid.thrust_n[row, column] == pytest.approx(-8 + 0.211 * 100 + 9.65e-4 * 1e4, abs=0.01)
    assert grid.thrust_max_n[row] == pytest.approx(-8 + 0.211 * 127 + 9.65e-4 * 127**2)


@pytest.mark.parametrize("case", CASES)
def test_fixed_point_stays_inside_its_tolerances(case: str) -> None:
    characteristic = CASES[case]()
    grid = self_test.reference(characteristic)
    limits = self_test.tolerances(characteristic)
    tables = fixed_point.fixed_tables(characteristic)
    speed = grid.speed_q16[:, None]
    thrust = fixed_model.thrust_from_code(tables, grid.code[None, :], speed) / 65536
    code = fixed_point.code_from_thrust(tables, grid.thrust_q16[None, :], speed)
    assert np.abs(thrust - grid.thrust_n).max() <= limits.thrust_fixed_n
    assert np.abs(code - grid.unrounded_code).max() <= 0.5 + limits.code_fixed


@pytest.mark.parametrize("case", CASES)
def test_tolerances_are_too_small_to_hide_a_fault(case: str) -> None:
    characteristic = CASES[case]()
    limits = self_test.tolerances(characteristic)
    thrust = max(characteristic.positive.thrust_max_n)
    assert limits.thrust_fixed_n < 1e-4 * thrust
    assert limits.thrust_single_n < 1e-5 * thrust
    # With 32767 codes one step of the formats is a fifth of a code.
    largest = 0.2 if case == "largest_codes" else 0.05
    assert max(limits.code_fixed, limits.code_single) <= largest
