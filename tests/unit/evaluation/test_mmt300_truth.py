"""The rebuilt drive, propeller and mooring curve give the printed tables back."""

import numpy as np
import pytest

from evaluation.bundled import mmt300_truth as truth

PRINTED = [
    (code, speed_mps)
    for speed_mps in truth.TABLE2
    for code in range(20, truth.CODE_MAX + 1)
    if truth.table2_thrust(code, speed_mps) > 0.5
]


@pytest.mark.parametrize(
    ("code", "speed_mps", "rpm", "torque_nm"),
    [
        (127, 0.0, 1692, 0.732),
        (127, 0.5, 1746, 0.684),
        (127, 1.0, 1805, 0.628),
        (127, 1.5, 1892, 0.583),
        (127, 2.0, 1982, 0.527),
        (80, 0.0, 1217, 0.378),
        (80, 0.5, 1258, 0.335),
        (80, 1.0, 1312, 0.287),
        (80, 1.5, 1403, 0.248),
        (80, 2.0, 1495, 0.197),
        (40, 0.0, 714, 0.130),
        (40, 0.5, 742, 0.098),
        (40, 1.0, 760, 0.053),
    ],
)
def test_inverting_table_2_through_table_1_gives_known_working_points(
    code: int, speed_mps: float, rpm: float, torque_nm: float
) -> None:
    found_rpm, found_nm = truth.working_point(code, speed_mps)
    assert found_rpm == pytest.approx(rpm, abs=0.6)
    assert found_nm == pytest.approx(torque_nm, abs=6e-4)


def test_no_working_point_in_the_dead_zone() -> None:
    with pytest.raises(ValueError, match="dead zone"):
        truth.working_point(40, 1.5)


def test_density_is_the_papers_in_si() -> None:
    assert pytest.approx(1000.62) == truth.DENSITY_KGPM3


def test_balance_of_drive_and_propeller_meets_table_2_at_every_bench_code() -> None:
    for code, speed_mps in PRINTED:
        if code in truth.BENCH_CODES:
            difference = truth.balanced_thrust(code, speed_mps) - truth.table2_thrust(
                code, speed_mps
            )
            assert abs(difference) <= 0.2, (code, speed_mps)


def test_balance_of_drive_and_propeller_meets_table_2_between_the_bench_codes() -> None:
    worst = max(
        abs(truth.balanced_thrust(code, speed) - truth.table2_thrust(code, speed))
        for code, speed in PRINTED
    )
    assert worst <= 0.23


def test_full_code_is_met_more_closely_at_every_speed() -> None:
    for speed_mps in truth.TABLE2:
        difference = truth.balanced_thrust(127, speed_mps) - truth.table2_thrust(127, speed_mps)
        assert abs(difference) <= 0.15, speed_mps


def test_no_thrust_where_table_2_has_none() -> None:
    """Within half a newton, below which the tables give code 0 anyway."""
    for speed_mps in truth.TABLE2:
        for code in truth.BENCH_CODES:
            if truth.table2_thrust(code, speed_mps) == 0.0:
                assert truth.balanced_thrust(code, speed_mps) <= 0.5, (code, speed_mps)


def test_torque_falls_with_speed_and_rises_with_code_where_the_bench_goes() -> None:
    from evaluation.bundled.mmt300_bench import torque_range

    for code in truth.BENCH_CODES:
        low, high = torque_range(code)
        rpm = np.linspace(truth.drive_speed(high, code), truth.drive_speed(low, code), 50)
        torque_nm = truth.drive_torque(rpm, code)
        assert np.all(np.diff(torque_nm) < 0.0), code
        assert np.all(torque_nm > 0.0), code
        if code < truth.CODE_MAX:
            assert np.all(truth.drive_torque(rpm, code + 1) > torque_nm), code


def test_sweeps_cover_the_working_points_with_a_margin_at_both_ends() -> None:
    from evaluation.bundled.mmt300_bench import torque_range

    for code, speed_mps in PRINTED:
        if code in truth.BENCH_CODES:
            _, torque_nm = truth.working_point(code, speed_mps)
            low, high = torque_range(code)
            assert 1.15 * low < torque_nm < high / 1.15, (code, speed_mps)


def test_drive_speed_inverts_drive_torque() -> None:
    for code in truth.BENCH_CODES:
        _, at_rest_nm = truth.working_point(code, 0.0)
        rpm = truth.drive_speed(0.8 * at_rest_nm, code)
        assert float(truth.drive_torque(rpm, code)) == pytest.approx(0.8 * at_rest_nm, rel=1e-9)
    with pytest.raises(ValueError, match="does not give"):
        truth.drive_speed(50.0, 60)


@pytest.mark.parametrize(
    ("code", "up_n", "down_n"),
    [
        (20, 1.73, -1.59),
        (40, 7.04, -6.50),
        (60, 13.40, -12.53),
        (70, 17.09, -16.12),
        (80, 21.15, -20.17),
        (100, 30.26, -29.56),
        (127, 42.71, -42.24),
    ],
)
def test_inverting_table_3_gives_known_mooring_thrusts(
    code: int, up_n: float, down_n: float
) -> None:
    assert truth.mooring_thrust(code) == pytest.approx(up_n, abs=0.006)
    assert truth.mooring_thrust(-code) == pytest.approx(down_n, abs=0.006)


def test_the_gap_between_mooring_and_calculation_is_the_papers() -> None:
    gap = {
        code: truth.mooring_thrust(code) - truth.table2_thrust(code, 0.0)
        for code in truth.BENCH_CODES
    }
    assert min(gap, key=lambda code: gap[code]) in {60, 70}
    assert min(gap.values()) == pytest.approx(-1.02, abs=0.02)
    assert max(gap.values()) == pytest.approx(0.46, abs=0.02)
