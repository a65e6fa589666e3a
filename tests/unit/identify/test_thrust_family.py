"""What was measured at rest corrects the calculated family, each sign by itself."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.control.inverse import thrust_grid
from pipeline.identify.inverse import inverse_characteristic
from pipeline.identify.static import thruster_model
from pipeline.identify.thrust_family import family_curves
from pipeline.physics.thrust_grid import code_from_thrust, thrust_from_code
from pipeline.physics.torque_balance import free_propeller_drag
from pipeline.records.fits import (
    DriveFit,
    FirmwareCharacteristic,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.measurements import MooringRecord
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

Maker = Callable[[Callable[[float], float], float], MooringRecord]
#: Thrust astern over thrust ahead of the same code: what the calculation cannot know.
ASTERN = 0.78


def calculated_n(static: StaticCharacteristic, code: float) -> float:
    return float(np.interp(abs(code), static.code, static.thrust_n[0]))


@pytest.fixture(scope="module")
def weak_astern(
    static: StaticCharacteristic, mooring_from: Maker, vehicle: Vehicle
) -> InverseCharacteristic:
    record = mooring_from(lambda code: calculated_n(static, code), 0.0)
    points = tuple(
        p.model_copy(update={"thrust_n": ASTERN * p.thrust_n}) if p.code < 0 else p
        for p in record.points
    )
    return inverse_characteristic(static, record.model_copy(update={"points": points}), vehicle)


def thrust(firmware: FirmwareCharacteristic, code: object, speed: float) -> FloatArray:
    grids = (thrust_grid(firmware.positive), thrust_grid(firmware.negative))
    return thrust_from_code(np.asarray(code), speed, positive=grids[0], negative=grids[1])


def test_measured_reverse_reaches_the_firmware(
    weak_astern: InverseCharacteristic, static: StaticCharacteristic
) -> None:
    """Within 2 codes and 0.5 N of the measurement, where the calculation is 8 N off."""
    firmware = weak_astern.firmware
    assert firmware is not None
    codes = np.arange(30, 128, 7)
    ahead = np.array([calculated_n(static, c) for c in codes])
    assert np.abs(thrust(firmware, codes, 0.0) - ahead).max() < 0.1
    assert np.abs(thrust(firmware, -codes, 0.0) + ASTERN * ahead).max() < 0.1
    assert (1 - ASTERN) * ahead[-1] > 8
    grids = (thrust_grid(firmware.positive), thrust_grid(firmware.negative))
    back = code_from_thrust(
        -ASTERN * ahead, 0.0, positive=grids[0], negative=grids[1], thrust_dead_n=0.5
    )
    assert np.abs(back + codes).max() < 0.5
    assert (firmware.positive.basis, firmware.negative.basis) == ("measured", "measured")


def test_the_other_sign_is_left_as_calculated(
    weak_astern: InverseCharacteristic, static: StaticCharacteristic, vehicle: Vehicle
) -> None:
    plain = inverse_characteristic(static, None, vehicle).firmware
    assert plain is not None
    assert weak_astern.firmware is not None
    codes = np.arange(1, 128)
    for speed in (0.0, 0.7, 2.0):
        np.testing.assert_allclose(
            thrust(weak_astern.firmware, codes, speed), thrust(plain, codes, speed), atol=0.3
        )
    assert (plain.positive.basis, plain.negative.basis) == ("calculated", "mirrored")


def test_alike_at_rest_is_alike_under_way(weak_astern: InverseCharacteristic) -> None:
    """Astern a code gives at 1 m/s what the code ahead gives that is its equal at rest."""
    firmware = weak_astern.firmware
    assert firmware is not None
    grids = (thrust_grid(firmware.positive), thrust_grid(firmware.negative))
    codes = np.arange(60, 128)
    at_rest = -thrust(firmware, -codes, 0.0)
    equal = code_from_thrust(at_rest, 0.0, positive=grids[0], negative=grids[1], thrust_dead_n=0.5)
    np.testing.assert_allclose(
        -thrust(firmware, -codes, -1.0), thrust(firmware, equal, 1.0), atol=0.25
    )


def test_the_gap_is_in_the_interval(weak_astern: InverseCharacteristic) -> None:
    family = weak_astern.family
    assert family is not None
    gap = (1 / ASTERN - 1) * np.array(family.negative.thrust_n[0])
    assert (np.array(family.negative.half95_n[0])[30:] >= 0.99 * gap[30:]).all()
    assert np.max(family.positive.half95_n[0]) < 1.0


def test_beyond_the_tables_the_balance_is_followed_to_no_thrust(
    static: StaticCharacteristic, propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    firmware = inverse_characteristic(static, None, vehicle).firmware
    assert firmware is not None
    assert static.faster is not None
    assert static.faster.ends == "no thrust"
    model = thruster_model(propeller, drive, vehicle)
    for speed in np.arange(2.1, firmware.positive.speed_mps[-3], 0.25):
        solved = float(model.solve(np.array([127.0]), float(speed)).thrust_n[0])
        assert float(thrust(firmware, 127, speed)) == pytest.approx(solved, rel=0.05, abs=0.1)
    assert thrust(firmware, 127, firmware.positive.speed_mps[-1] + 5.0) < 0.05
    assert 0.0 < firmware.fastest_tested_mps <= firmware.positive.speed_mps[-1]


def test_inside_the_dead_zone_the_propeller_drags(
    static: StaticCharacteristic, propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> None:
    firmware = inverse_characteristic(static, None, vehicle).firmware
    assert firmware is not None
    free = float(free_propeller_drag(2.0, thruster_model(propeller, drive, vehicle).propeller))
    assert 2.5 < free < 4.5
    assert thrust(firmware, 0, 2.0) == pytest.approx(-free, rel=0.01)
    assert thrust(firmware, 0, -2.0) == pytest.approx(free, rel=0.01)
    assert -free < float(thrust(firmware, 15, 2.0)) < 0.0
    assert thrust(firmware, 0, 0.0) == 0.0
    along = thrust(firmware, np.arange(-127, 128), 2.0)
    assert (np.diff(along) >= -1e-9).all()


def test_a_family_ends_where_nothing_is_left(static: StaticCharacteristic) -> None:
    family = family_curves(static, 0.5)
    assert family is not None
    assert family.curves[-1].thrust_max_n > 0.5
    assert (np.diff([c.thrust_max_n for c in family.curves]) < 0).all()
