"""What judges the loads of a balance: a stated limit, or the tables between the drive's codes."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled

from pipeline.bundled.design import design_example
from pipeline.control.real_thrust import RealThruster
from pipeline.design.balance_design import design_balance
from pipeline.design.balance_input import BalanceInput
from pipeline.design.balance_limits import TableLimits
from pipeline.vehicle.load import load_checked

CODE = np.arange(1.0, 128.0)


def tables(code_max: float, code_min: float) -> TableLimits:
    """Thrust that grows with the square of the code, 50.8 N at 127, and none at 10 m/s."""
    thrust = 50.8 * (CODE / 127.0) ** 2
    both = np.array([thrust, 0.0 * thrust])
    real = RealThruster(np.array([0.0, 10.0]), CODE, both)
    return TableLimits(real, both, both, code_max, code_min, "x")


def mmt300(**changes: object) -> BalanceInput:
    file = design_example("balance", "mmt300")
    one = load_checked(file, BalanceInput, expected="", remedy="")
    span = {"first": 0.5, "last": 2.0, "points": 2}
    envelope = {
        "speed_mps": span,
        "residual_buoyancy_n": span | {"first": -30.0},
        "angle_deg": span | {"first": 20.0, "last": 30.0},
    }
    return BalanceInput.model_validate(one.model_dump() | {"envelope": envelope} | changes)


def test_a_load_backwards_is_limited_by_the_least_code() -> None:
    limits = tables(127.0, -60.0)
    assert limits.limit_n(5.0, 0.0) == pytest.approx(50.8)
    assert limits.limit_n(-5.0, 0.0) == pytest.approx(50.8 * (60 / 127) ** 2)
    assert limits.use(-5.0, 0.0, 1.0) == pytest.approx(5.0 / limits.limit_n(-5.0, 0.0))
    code = limits.code(-5.0, 0.0)
    assert code == pytest.approx(-127 * np.sqrt(5.0 / 50.8), abs=0.05)
    assert limits.code(-20.0, 0.0) is None
    assert limits.code(20.0, 0.0) is not None
    assert "codes -60 to 127" in limits.kind


def test_a_drive_without_reverse_gives_nothing_backwards() -> None:
    limits = tables(127.0, 0.0)
    load = limits.load("upper", -5.0, 0.0, 1.0)
    assert (load.limit_n, load.code, load.power_w) == (0.0, None, None)
    assert load.use is not None
    assert load.use > 1.0


@pytest.mark.parametrize(("last_mps", "warned"), [(2.0, False), (12.0, True)])
def test_a_map_that_goes_on_beyond_the_tables_is_warned_of(
    repository: Path, last_mps: float, warned: bool
) -> None:
    speeds = {"speed_mps": {"first": 0.5, "last": last_mps, "points": 2}}
    one = mmt300(envelope=mmt300().envelope.model_dump() | speeds)
    found = design_balance(one, bundled(repository, "mmt300"), tables(127.0, -127.0))
    assert any("known up to 10 m/s" in text for text in found.warnings) is warned


def test_a_stated_limit_goes_before_the_tables_and_says_so(repository: Path) -> None:
    vehicle = bundled(repository, "mmt300")
    without = design_balance(mmt300(), vehicle, tables(127.0, -127.0))
    assert without.limit_kind == "the identified T(N, V) of x, code 127"
    assert not any("limit:" in text for text in without.warnings)
    stated = mmt300(limit={"thrust_max_n": 3.0})
    found = design_balance(stated, vehicle, tables(127.0, -127.0))
    assert found.limit_kind == "3 N of thrust"
    assert [load.limit_n for load in found.exact.loads] == [3.0] * 4
    assert any("limit: of the design file holds, 3 N of thrust" in text for text in found.warnings)
