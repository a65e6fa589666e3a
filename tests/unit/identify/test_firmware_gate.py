"""Checks that stand between a mooring test and firmware."""

import numpy as np
import pytest

from pipeline.identify.firmware_gate import gate_checks, rising_points
from pipeline.records.base import Source
from pipeline.records.measurements import MooringPoint
from pipeline.vehicle.schema import Vehicle

CODES = np.arange(-100.0, 101.0, 10.0)


def points(thrust_n: np.ndarray, tare_n: float = 0.0) -> tuple[MooringPoint, ...]:
    return tuple(
        MooringPoint(
            source=Source(file="a.csv", sheet=None, row=at + 2),
            code=float(code),
            thrust_n=float(thrust),
            tare_n=tare_n,
            sweep="up",
        )
        for at, (code, thrust) in enumerate(zip(CODES, thrust_n, strict=True))
    )


def vehicle() -> Vehicle:
    return Vehicle.model_validate(
        {
            "name": "v",
            "title": "",
            "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.81},
            "propellers": {"p": {"diameter_m": 0.1}},
            "drives": {"d": {"code_min": -100, "code_max": 100}},
            "tables": {"propeller": "p", "drive": "d"},
        }
    )


def sound() -> np.ndarray:
    return np.asarray(50.0 * np.sign(CODES) * (CODES / 100.0) ** 2)


def failed(thrust_n: np.ndarray, tare_n: float = 0.0) -> set[str]:
    given = points(thrust_n, tare_n)
    checks = (*rising_points(given)[1], *gate_checks(given, (None, None), vehicle()))
    return {check.gate for check in checks if not check.passed}


def test_a_sound_test_passes_all_but_the_fits_it_has_not() -> None:
    assert failed(sound()) == {"signs"}


@pytest.mark.parametrize(
    ("gate", "thrust", "tare"),
    [
        ("thrust_rises", np.where(CODES > 80, 30.0, sound()), 0.0),
        ("neighbours", np.where(CODES == 60, 0.18, sound()), 0.0),
        ("neutral", sound(), 9.0),
    ],
)
def test_what_is_wrong_is_named(gate: str, thrust: np.ndarray, tare: float) -> None:
    assert gate in failed(thrust, tare)


def test_codes_beyond_a_fold_are_left_out() -> None:
    kept, (check,) = rising_points(points(np.where(CODES > 80, 25.0, sound())))
    assert max(point.code for point in kept) == 80.0
    assert "beyond code 80 (32 N) thrust falls to 25 N" in check.text


def test_accept_names_a_check_and_a_reason() -> None:
    tree = vehicle().model_dump()
    accepted = {**tree, "accept": {"neutral": "the sensor carries the arm's weight"}}
    assert Vehicle.model_validate(accepted).accept["neutral"].startswith("the sensor")
    for wrong in ({"neutral": "ok"}, {"nothing": "a reason that is long"}):
        with pytest.raises(ValueError, match="accept"):
            Vehicle.model_validate({**tree, "accept": wrong})
