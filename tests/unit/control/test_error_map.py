import numpy as np
import pytest

from pipeline.control.allocation import ThrustLimits
from pipeline.control.error_map import allocation_map, demand_grid, map_speeds
from pipeline.errors import CannotComputeError
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.records.validation import AllocationMap
from pipeline.vehicle.schema import Vehicle

COS, SIN = float(np.cos(np.radians(22.5))), float(np.sin(np.radians(22.5)))


@pytest.fixture(scope="module")
def printed(
    mmt300: Vehicle, paper_inverse: InverseCharacteristic, paper_static: StaticCharacteristic
) -> AllocationMap:
    return allocation_map(mmt300, paper_inverse, paper_static)


def test_compensation_keeps_within_two_percent(printed: AllocationMap) -> None:
    """Wherever the demand is within reach and no thruster pushes against the motion."""
    assert max(score.worst for score in printed.compensated) < 0.002
    assert max(score.worst_with_dead_band for score in printed.compensated) <= 0.02
    assert all(score.reachable_share > 0 for score in printed.compensated)


def test_without_compensation_half_of_the_range_is_lost(printed: AllocationMap) -> None:
    """The paper's thesis: the error grows with speed at every step."""
    worst = [score.worst for score in printed.mooring]
    assert (np.diff(worst[3:]) > 0).all()
    last = printed.mooring[-1]
    assert last.speed_mps == 2.0
    assert 0.48 < last.worst < 0.56
    assert last.worst_component == "surge"
    assert last.worst_achieved[0] < 0.2 * last.worst_asked[0]


def test_worst_demand_by_hand(printed: AllocationMap) -> None:
    """The reported worst demand, worked through Tables 3 and 2 as printed."""
    last = printed.mooring[-1]
    x, m, n = last.worst_demand
    t_x, t_psi, t_phi = x / (4 * COS), m / (2 * SIN * 1.2), -n / (2 * SIN * 1.2)
    wanted = np.array([t_x - t_psi, t_x + t_psi, t_x - t_phi, t_x + t_phi])
    code = 12.7 + 4.336 * wanted - 0.070 * wanted**2 + 7.29e-4 * wanted**3
    real = np.maximum(-15 + 0.208 * code + 8.67e-4 * code**2, 0.0)
    assert last.worst_achieved[0] == pytest.approx(real.sum() * COS, abs=0.1)
    assert last.worst == pytest.approx((x - real.sum() * COS) / (4 * COS * 25.40), abs=0.002)


def test_gap_of_mooring_test_and_calculation_shows_at_rest(printed: AllocationMap) -> None:
    """Tables 3 and 2 differ by up to 1 N at V = 0 in print (2 N on the negative side)."""
    rest = printed.mooring[0]
    assert 0.01 < rest.worst < 0.06
    assert printed.compensated[0].worst < 1e-3


def test_range_is_one_sided_and_of_the_real_thruster(printed: AllocationMap) -> None:
    x, m, n = printed.compensated[-1].range_n_nm
    assert x == pytest.approx(4 * COS * 25.40, abs=0.02)
    assert m == n == pytest.approx(2 * SIN * 1.2 * 25.40, abs=0.02)


def test_shares(printed: AllocationMap) -> None:
    reach = [score.reachable_share for score in printed.compensated]
    assert reach[0] == 1.0
    assert (np.diff(reach) <= 0).all()
    assert printed.compensated[0].opposed_share == 0.0
    assert all(s.opposed_share <= s.reachable_share for s in printed.compensated)
    assert [s.reachable_share for s in printed.mooring] == reach


def test_dead_band_is_an_error_of_at_most_half_a_newton_a_thruster(printed: AllocationMap) -> None:
    for score in printed.compensated:
        largest = score.range_n_nm[0] / (4 * COS)
        assert score.worst_with_dead_band <= 0.5 / largest + 0.002


def test_scaled_form_asks_less_and_is_measured_against_that(
    mmt300: Vehicle,
    paper_inverse: InverseCharacteristic,
    paper_static: StaticCharacteristic,
) -> None:
    assert mmt300.allocator is not None
    scaled = mmt300.model_copy(
        update={"allocator": mmt300.allocator.model_copy(update={"form": "scaled"})}
    )
    result = allocation_map(scaled, paper_inverse, paper_static)
    assert result.form == "scaled"
    assert max(score.worst for score in result.compensated) < 0.002


def test_without_mooring_data_the_row_at_rest_stands_in(
    mmt300: Vehicle, paper_inverse: InverseCharacteristic, paper_static: StaticCharacteristic
) -> None:
    none = paper_inverse.model_copy(update={"table3_positive": None, "table3_negative": None})
    result = allocation_map(mmt300, none, paper_static)
    assert result.mooring[0].worst < 1e-3
    assert result.mooring[-1].worst > 0.4
    assert any("no mooring test" in text for text in result.explanations)
    one = paper_inverse.model_copy(update={"table3_negative": None})
    assert any(
        "one sign" in text for text in allocation_map(mmt300, one, paper_static).explanations
    )


def test_what_is_missing_is_said(
    mmt300: Vehicle, paper_inverse: InverseCharacteristic, paper_static: StaticCharacteristic
) -> None:
    with pytest.raises(CannotComputeError, match="no section 'allocator'"):
        allocation_map(mmt300.model_copy(update={"allocator": None}), paper_inverse, paper_static)
    with pytest.raises(CannotComputeError, match="firmware form"):
        allocation_map(mmt300, paper_inverse.model_copy(update={"firmware": None}), paper_static)


def test_a_speed_without_any_thrust_has_nothing_within_reach(
    mmt300: Vehicle, paper_inverse: InverseCharacteristic, paper_static: StaticCharacteristic
) -> None:
    codes = len(paper_static.code)
    stalled = paper_static.model_copy(
        update={
            "thrust_n": (*paper_static.thrust_n[:-1], (0.0,) * codes),
            "status": (*paper_static.status[:-1], ("dead",) * codes),
        }
    )
    firmware = paper_inverse.firmware
    assert firmware is not None
    spent = {"thrust_max_n": (*firmware.positive.thrust_max_n[:-1], 0.0)}
    grid = firmware.model_copy(update={"positive": firmware.positive.model_copy(update=spent)})
    inverse = paper_inverse.model_copy(update={"firmware": grid})
    last = allocation_map(mmt300, inverse, stalled).compensated[-1]
    assert last.range_n_nm == (0.0, 0.0, 0.0)
    assert last.worst == 0.0
    assert last.reachable_share < 1e-3


def test_holes_of_the_family_are_mentioned(
    mmt300: Vehicle, paper_inverse: InverseCharacteristic, paper_static: StaticCharacteristic
) -> None:
    first = ("no_working_point", *paper_static.status[0][1:])
    holed = paper_static.model_copy(update={"status": (first, *paper_static.status[1:])})
    texts = allocation_map(mmt300, paper_inverse, holed).explanations
    assert any("no working point at 1 of its nodes" in text for text in texts)


def test_speeds_of_the_map() -> None:
    assert map_speeds((0.0, 0.5, 1.0, 1.5, 2.0)) == [round(0.1 * i, 9) for i in range(21)]
    assert map_speeds((0.0,)) == [0.0]


@pytest.mark.parametrize("code_min", [-100, 0])
def test_a_drive_with_fewer_negative_codes_is_scored_within_them(
    mmt300: Vehicle,
    paper_inverse: InverseCharacteristic,
    paper_static: StaticCharacteristic,
    code_min: int,
) -> None:
    """Demands that need more reverse thrust than its codes give are out of reach, not an error."""
    firmware = paper_inverse.firmware
    assert firmware is not None
    inverse = paper_inverse.model_copy(
        update={"firmware": firmware.model_copy(update={"code_min": code_min})}
    )
    drives = {
        name: drive.model_copy(update={"code_min": code_min})
        for name, drive in mmt300.drives.items()
    }
    vehicle = mmt300.model_copy(update={"drives": drives})
    result = allocation_map(vehicle, inverse, paper_static)
    assert max(score.worst for score in result.compensated) <= 0.02
    # ahead nothing is different from a drive that turns both ways
    symmetric = allocation_map(mmt300, paper_inverse, paper_static)
    assert result.mooring[-1].worst == pytest.approx(symmetric.mooring[-1].worst, abs=0.01)
    assert any("no reverse thrust" in text for text in result.explanations) == (code_min == 0)


@pytest.mark.parametrize("form", ["limit", "scaled"])
@pytest.mark.parametrize("reverse_n", [0.0, 0.1, 14.0, 40.0, 90.0])
def test_demands_reach_as_far_as_each_sign_of_thrust_does(
    mmt300: Vehicle, form: str, reverse_n: float
) -> None:
    assert mmt300.allocator is not None
    allocator = mmt300.allocator.model_copy(update={"form": form})
    share, pitch_share = (0.6, 0.3) if form == "limit" else (1.0, 1.0)
    grid = demand_grid(allocator, ThrustLimits(40.0, reverse_n))
    surge = grid.surge_n
    assert surge[0] == pytest.approx(-4 * COS * share * reverse_n)
    assert surge[-1] == pytest.approx(4 * COS * share * 40.0)
    assert surge.size == 41
    assert (np.diff(surge) > 0.0).all()
    moment = 2 * SIN * 1.2 * pitch_share * min(40.0, reverse_n)
    np.testing.assert_allclose(grid.pitch_nm[[0, -1]], [-moment, moment])
    assert all(0.0 in axis for axis in (surge, grid.pitch_nm, grid.yaw_nm))
