"""Power at the shafts and at the supply."""

import numpy as np
import pytest

from pipeline.records.base import Source
from pipeline.records.measurements import LoadTestPoint
from pipeline.records.validation import ElectricalModel
from pipeline.validate.power import Grid, PowerModel, electrical_model


def point(rpm: float, torque: float, **more: object) -> LoadTestPoint:
    """Draw 5 W, 0.4 W a rev/s and 20 W a (N m)^2 beside the shaft power, from 48 V."""
    power = torque * 2 * np.pi * rpm / 60 + 5.0 + 0.4 * rpm / 60 + 20.0 * torque**2
    values = {
        "source": Source(file="a.csv", row=1),
        "code": 50.0,
        "shaft_speed_rpm": rpm,
        "torque_nm": torque,
        "voltage_v": 48.0,
        "current_a": power / 48.0,
        "branch": "loading",
    }
    return LoadTestPoint.model_validate(values | more)


POINTS = tuple(
    point(rpm, torque) for rpm in (300, 600, 900, 1500) for torque in np.linspace(0.05, 0.7, 8)
)


def test_losses_are_found_again() -> None:
    model = electrical_model((*POINTS, point(100, 0.1, current_a=99.0, marks=("warm-up",))))
    assert model is not None
    assert model.constant_w == pytest.approx(5.0)
    assert model.speed_ws == pytest.approx(0.4)
    assert model.torque_w_per_nm2 == pytest.approx(20.0)
    assert model.residual_rms_w == pytest.approx(0.0, abs=1e-9)
    assert model.points == len(POINTS)


def test_stated_input_power_goes_before_current_times_voltage() -> None:
    doubled = tuple(p.model_copy(update={"current_a": 1.0, "input_power_w": 77.0}) for p in POINTS)
    model = electrical_model(doubled)
    assert model is not None
    assert model.constant_w > 50.0


def test_without_current_there_is_no_model() -> None:
    assert electrical_model(tuple(p.model_copy(update={"current_a": None}) for p in POINTS)) is None
    assert electrical_model(POINTS[:5]) is None


def test_mean_power_by_hand_and_nothing_at_code_zero() -> None:
    flat = Grid(np.array([[0.0, 10.0, 20.0]] * 2), 0.1, 1.0)
    losses = ElectricalModel(
        constant_w=3.0, speed_ws=0.5, torque_w_per_nm2=2.0, points=30, residual_rms_w=0.0
    )
    torque = Grid(np.array([[0.0, 0.1, 0.2]] * 2), 0.1, 1.0)
    model = PowerModel(flat, torque, losses)
    codes, inflow = np.array([[2.0, 0.0], [-1.0, 0.0]]), np.zeros((2, 2))
    shaft, supply = model.means(codes, inflow)
    each = [2 * np.pi * 20 * 0.2, 2 * np.pi * 10 * 0.1]
    assert shaft == pytest.approx(sum(each) / 2)
    loss = (3 + 10 + 2 * 0.04) + (3 + 5 + 2 * 0.01)
    assert supply == pytest.approx((sum(each) + loss) / 2)
    assert PowerModel(flat, torque, None).means(codes, inflow)[1] is None
