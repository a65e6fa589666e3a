"""Thrust measured in a flow corrects the family at speed, and nothing at rest."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.control.inverse import thrust_grid
from pipeline.identify.inverse import inverse_characteristic
from pipeline.physics.thrust_grid import thrust_from_code
from pipeline.records.base import Source
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.records.measurements import MooringPoint, MooringRecord
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

Maker = Callable[[Callable[[float], float], float], MooringRecord]
#: Thrust of the made thruster over (code^2, code times speed), and the codes that are read.
AT_REST, TAKEN = 2.6e-3, 0.09
CODES = np.array([-120.0, -90.0, -60.0, 60.0, 90.0, 120.0])


def made_n(code: FloatArray, speed: float) -> FloatArray:
    """T = a N|N| - b |N| V, as of a K_T that falls straight with J."""
    along = np.sign(code) * speed
    return np.sign(code) * np.maximum(AT_REST * code**2 - TAKEN * np.abs(code) * along, 0.0)


def in_a_flow(speed: float, thrust_n: FloatArray, codes: FloatArray = CODES) -> list[MooringPoint]:
    return [
        MooringPoint(
            source=Source(file="flow.csv", row=row), code=code, thrust_n=thrust, sweep="up",
            speed_mps=speed, marks=("not at rest",),
        )
        for row, (code, thrust) in enumerate(zip(codes.tolist(), thrust_n.tolist(), strict=True))
    ]  # fmt: skip


def flown(
    record: MooringRecord, more: list[MooringPoint], vehicle: Vehicle, static: object = None
) -> InverseCharacteristic:
    assert static is None or isinstance(static, StaticCharacteristic)
    every = record.model_copy(update={"points": (*record.points, *more)})
    return inverse_characteristic(static, every, vehicle)


def thrust(found: InverseCharacteristic, code: FloatArray, speed: float) -> FloatArray:
    assert found.firmware is not None
    grids = [thrust_grid(one) for one in (found.firmware.positive, found.firmware.negative)]
    return thrust_from_code(code, speed, positive=grids[0], negative=grids[1])


@pytest.fixture
def at_rest(mooring_from: Maker) -> MooringRecord:
    return mooring_from(lambda code: abs(float(made_n(np.array(code), 0.0))), 0.0)


def test_what_speed_takes_needs_no_calculation(at_rest: MooringRecord, vehicle: Vehicle) -> None:
    """From three speeds, either way, to every speed between them and every code."""
    points = [
        point
        for speed in (0.5, 1.0, 1.5)
        for sign in (1.0, -1.0)
        for point in in_a_flow(sign * speed, made_n(CODES, sign * speed))
    ]
    found = flown(at_rest, points, vehicle)
    codes = np.arange(60.0, 121.0, 10.0)
    for speed in (0.0, 0.5, 0.7, 1.0, 1.5):
        assert np.abs(thrust(found, codes, speed) - made_n(codes, speed)).max() < 0.15
        assert np.abs(thrust(found, -codes, -speed) - made_n(-codes, -speed)).max() < 0.15
    assert found.firmware is not None
    assert found.firmware.fastest_tested_mps == pytest.approx(1.5)
    assert not found.firmware.at_rest_only
    assert sum("was measured at 0.5, 1, 1.5 m/s" in one for one in found.explanations) == 2


def test_one_code_at_one_speed_corrects_the_calculation(
    static: StaticCharacteristic, mooring_from: Maker, vehicle: Vehicle
) -> None:
    def calculated(code: float) -> float:
        return float(np.interp(abs(code), static.code, static.thrust_n[0]))

    record = mooring_from(calculated, 0.0)
    code, speed = np.array([100.0]), 1.0
    plain = flown(record, [], vehicle, static)
    less = thrust(plain, code, speed) - 2.0
    found = flown(record, in_a_flow(speed, less, code), vehicle, static)
    assert thrust(found, code, speed) == pytest.approx(less, abs=0.1)
    # at rest and on the side that was not measured nothing changes, at speed all codes do
    every = np.arange(30.0, 127.0, 9.0)
    for sign, at in ((1.0, 0.0), (-1.0, -1.0)):
        np.testing.assert_allclose(
            thrust(found, sign * every, at), thrust(plain, sign * every, at), atol=0.05
        )
    more = thrust(plain, every, 0.5) - thrust(found, every, 0.5)
    assert more.min() >= 0.0
    assert 0.5 < float(np.interp(100.0, every, more)) < 1.5
    # the gap between the two ways is in the interval
    assert found.family is not None
    side = found.family.positive
    row = side.speed_mps.index(min(side.speed_mps, key=lambda v: abs(v - speed)))
    assert np.interp(100.0, side.code, side.half95_n[row]) > 1.9


def test_a_flow_that_cannot_be_along_the_thrust(at_rest: MooringRecord, vehicle: Vehicle) -> None:
    """Against the thrust, or more than at rest: not used, and the second is said."""
    plain = flown(at_rest, [], vehicle)
    ahead = np.array([90.0, 120.0])
    against = flown(at_rest, in_a_flow(-1.0, made_n(ahead, -1.0), ahead), vehicle)
    assert against.firmware == plain.firmware.model_copy(  # type: ignore[union-attr]
        update={"sources": against.firmware.sources}  # type: ignore[union-attr]
    )
    turned = flown(at_rest, in_a_flow(1.0, made_n(ahead, -1.0), ahead), vehicle)
    assert "more than at rest" in " ".join(turned.explanations)
    np.testing.assert_array_equal(thrust(turned, ahead, 1.0), thrust(plain, ahead, 1.0))
