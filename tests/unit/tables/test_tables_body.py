"""What stands in ``tables.json`` beside the coefficients."""

import pytest

from pipeline.records.fits import (
    FitQuality,
    InverseCharacteristic,
    PolynomialFit,
    SpeedInverse,
    StaticCharacteristic,
    StaticRow,
)
from pipeline.tables.build import build_tables
from pipeline.vehicle.schema import Vehicle

BOAT = Vehicle.model_validate(
    {
        "name": "boat",
        "title": "boat",
        "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.81},
        "propellers": {"p": {"diameter_m": 0.1}},
        "drives": {"d": {"code_min": -127, "code_max": 127}},
        "tables": {"propeller": "p", "drive": "d"},
    }
)
INTERVALS = {0.0: (42.2, 42.8), 2.0: (25.35, 25.74)}


def family(*speeds: float) -> StaticCharacteristic:
    quality = FitQuality(
        points=9, r_squared=1.0, residual_std=0.1, unit="N", valid_range=(20.0, 127.0)
    )
    fit = PolynomialFit(
        quantity="T",
        variable="N",
        coefficients=(1.0, 2.0, 3.0),
        covariance=((0.0,) * 3,) * 3,
        ci95=((0.0, 1.0),) * 3,
        quality=quality,
    )
    rows = tuple(
        StaticRow(
            speed_mps=v,
            fit=fit,
            dead_zone_code=10.0,
            thrust_max_n=sum(INTERVALS[v]) / 2,
            thrust_max_ci95=INTERVALS[v],
            mode_code=(),
            thrust_modes_n=(),
        )
        for v in speeds
    )
    return StaticCharacteristic(
        speed_mps=speeds,
        code=(),
        thrust_n=(),
        thrust_std_n=(),
        shaft_speed_rpm=(),
        torque_nm=(),
        advance_ratio=(),
        status=(),
        table2=rows,
        checks=(),
        explanations=(),
    )


@pytest.fixture
def inverse() -> InverseCharacteristic:
    rows = tuple(
        SpeedInverse(
            speed_mps=v, thrust_max_n=40.0, coefficients=(1, 2, 3, 4), ci95=((0.0, 1.0),) * 4
        )
        for v in INTERVALS
    )
    return InverseCharacteristic(
        table3_positive=None,
        table3_negative=None,
        table4=rows,
        firmware=None,
        round_trip=(),
        checks=(),
        explanations=(),
    )


def test_the_largest_thrust_of_table_4_has_the_interval_of_table_2(
    inverse: InverseCharacteristic,
) -> None:
    table4 = build_tables(BOAT, None, family(0.0, 2.0), inverse)["table4"]
    assert table4["ci95"]["T_max_n"] == [[42.2, 42.8], [25.35, 25.74]]
    assert list(table4["ci95"]) == ["KN0", "KN1", "KN2", "KN3", "T_max_n"]


def test_without_a_row_of_the_family_at_each_speed_there_is_none(
    inverse: InverseCharacteristic,
) -> None:
    assert "T_max_n" not in build_tables(BOAT, None, family(0.0), inverse)["table4"]["ci95"]
    assert "T_max_n" not in build_tables(BOAT, None, None, inverse)["table4"]["ci95"]
