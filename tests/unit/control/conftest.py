"""The paper's vehicle and its printed Tables 2-4 as records (Kostenko 2023)."""

import numpy as np
import pytest
from paper_static import StaticTable, code_from_thrust

from pipeline.records.fits import (
    FirmwareBranch,
    FirmwareCharacteristic,
    FitQuality,
    InverseCharacteristic,
    PolynomialFit,
    SpeedInverse,
    StaticCharacteristic,
)
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Allocator, Vehicle

SPEED = np.array([0.0, 0.5, 1.0, 1.5, 2.0])
TABLE_2 = np.array(
    [
        [-4.0, 0.254, 8.82e-4],
        [-5.0, 0.215, 10.2e-4],
        [-8.0, 0.211, 9.65e-4],
        [-11.0, 0.210, 9.07e-4],
        [-15.0, 0.208, 8.67e-4],
    ]
)
TABLE_3_POSITIVE = (12.7, 4.336, -0.070, 7.29e-4)
TABLE_3_NEGATIVE = (-12.7, 4.738, 0.089, 9.68e-4)
TABLE_4_THRUST_MAX = (42.0, 38.5, 34.5, 29.9, 24.8)
TABLE_4 = (
    (11.7, 4.32, -0.073, 8.51e-4),
    (20.6, 4.04, -0.062, 7.43e-4),
    (30.8, 3.97, -0.063, 8.33e-4),
    (43.2, 3.95, -0.074, 12.1e-4),
    (60.0, 3.17, -0.031, 5.00e-4),
)
DELTA = np.radians(22.5)


def polynomial_fit(coefficients: tuple[float, ...], valid: tuple[float, float]) -> PolynomialFit:
    size = len(coefficients)
    return PolynomialFit(
        quantity="N",
        variable="T",
        coefficients=coefficients,
        covariance=((0.0,) * size,) * size,
        ci95=tuple((c, c) for c in coefficients),
        quality=FitQuality(points=9, r_squared=1.0, residual_std=0.0, unit="1", valid_range=valid),
    )


def rows(matrix: FloatArray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())


@pytest.fixture(scope="session")
def table2() -> StaticTable:
    return StaticTable(SPEED, TABLE_2)


@pytest.fixture(scope="session")
def mmt300() -> Vehicle:
    """The vehicle of the paper; the lever arms are not printed and chosen here."""
    sine, cosine = float(np.sin(DELTA)), float(np.cos(DELTA))
    stern, bow = (-1.2, 0.0, 0.0), (0.9, 0.0, 0.0)
    directions = {
        "upper": (stern, (cosine, 0.0, -sine)),
        "lower": (stern, (cosine, 0.0, sine)),
        "left": (stern, (cosine, -sine, 0.0)),
        "right": (stern, (cosine, sine, 0.0)),
        "bow": (bow, (0.0, 0.0, -1.0)),
    }
    return Vehicle.model_validate(
        {
            "name": "mmt300",
            "title": "AUV MMT-300",
            "water": {"density_kgpm3": 1000.62, "gravity_mps2": 9.81},
            "propellers": {"p": {"diameter_m": 0.14}},
            "drives": {"d": {"code_min": -127, "code_max": 127}},
            "thrusters": [
                {
                    "name": name,
                    "propeller": "p",
                    "drive": "d",
                    "position_m": position,
                    "direction": direction,
                }
                for name, (position, direction) in directions.items()
            ],
            "allocator": {
                "delta_deg": 22.5,
                "stern_arm_m": 1.2,
                "bow_arm_m": 0.9,
                **{name: name for name in directions},
                "portions": {"surge": 0.6, "heading": 0.4, "pitch": 0.3},
            },
            "tables": {"propeller": "p", "drive": "d"},
        }
    )


@pytest.fixture(scope="session")
def allocator(mmt300: Vehicle) -> Allocator:
    assert mmt300.allocator is not None
    return mmt300.allocator


@pytest.fixture(scope="session")
def paper_static(table2: StaticTable) -> StaticCharacteristic:
    """Table 2 on a grid of whole codes and 0.1 m/s."""
    speed, code = np.linspace(0.0, 2.0, 21), np.arange(1.0, 128.0)
    thrust = table2.thrust_n(code[None, :], speed[:, None])
    zeros = rows(np.zeros_like(thrust))
    return StaticCharacteristic(
        speed_mps=tuple(speed.tolist()),
        code=tuple(code.tolist()),
        thrust_n=rows(thrust),
        thrust_std_n=zeros,
        shaft_speed_rpm=zeros,
        torque_nm=zeros,
        advance_ratio=zeros,
        status=tuple(tuple("live" if t > 0 else "dead" for t in row) for row in thrust),
        table2=(),
        checks=(),
        explanations=(),
    )


def firmware_branch(table: StaticTable, sign: int) -> FirmwareBranch:
    """The exact inverse of Table 2 every 0.1 m/s, at 65 fractions of T_max(V)."""
    speed, fraction = np.linspace(0.0, 2.0, 21), np.linspace(0.0, 1.0, 65)
    largest = table.thrust_n(127.0, speed)
    coefficients = table.at_speed(speed)[:, None, :]
    # at fraction 0 the edge of the dead zone: the limit of the inverse for T -> 0
    code = code_from_thrust(np.maximum(fraction, 1e-12) * largest[:, None], coefficients)
    return FirmwareBranch.model_validate(
        {
            "sign": sign,
            "speed_mps": tuple(speed.tolist()),
            "thrust_max_n": tuple(largest.tolist()),
            "fraction": tuple(fraction.tolist()),
            "code": rows(code),
            "against_motion": "row at rest",
        }
    )


@pytest.fixture(scope="session")
def paper_inverse(table2: StaticTable) -> InverseCharacteristic:
    """Tables 3 and 4 as printed, and the grid from Table 2."""
    return InverseCharacteristic(
        table3_positive=polynomial_fit(TABLE_3_POSITIVE, (0.5, 43.0)),
        table3_negative=polynomial_fit(TABLE_3_NEGATIVE, (-43.0, -0.5)),
        table4=tuple(
            SpeedInverse(
                speed_mps=speed,
                thrust_max_n=largest,
                coefficients=row,
                ci95=tuple((c, c) for c in row),
            )
            for speed, largest, row in zip(SPEED, TABLE_4_THRUST_MAX, TABLE_4, strict=True)
        ),
        firmware=FirmwareCharacteristic(
            thrust_dead_n=0.5,
            code_max=127,
            positive=firmware_branch(table2, 1),
            negative=firmware_branch(table2, -1),
        ),
        round_trip=(),
        checks=(),
        explanations=(),
    )
