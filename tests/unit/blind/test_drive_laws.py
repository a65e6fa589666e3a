"""Laws that are fitted anew to the bench's family give its working points back."""

import numpy as np
import pytest

from pipeline.blind.subject import BlindSubject
from pipeline.blind.truth.craft import Craft, craft_of
from pipeline.blind.truth.drive_laws import drive_law
from pipeline.blind.truth.flight import fly_craft, still
from pipeline.blind.truth.kernel_forces import BALANCED
from pipeline.blind.truth.manoeuvres import belief_of
from pipeline.errors import CannotComputeError


def immovable(craft: Craft) -> Craft:
    """Return a vehicle so heavy that it keeps its speed."""
    return craft.changed(
        mass_kg=1e9,
        inertia=1e9 * np.eye(3),
        buoyancy_n=1e9 * craft.gravity,
        centre_b=craft.centre_g,
    )


@pytest.mark.parametrize(("code", "speed"), [(60, 0.0), (100, 0.0), (127, 1.0), (110, 1.5)])
def test_a_steady_thruster_gives_the_thrust_of_the_bench(
    mmt300: BlindSubject, code: int, speed: float
) -> None:
    assert mmt300.static is not None
    craft = craft_of(mmt300.vehicle, mmt300.static)
    assert craft.laws[0].mode == BALANCED
    craft = immovable(craft)
    start = still(np.array([0.0, 0.0, 12.0]))
    cosine = craft.push[0, 0]
    start[12] = speed / cosine
    codes = np.zeros((20, 5))
    codes[:, 0] = code
    flight = fly_craft(craft, belief_of(craft), commands=codes, start=start)
    row = int(np.argmin(np.abs(np.array(mmt300.static.speed_mps) - speed)))
    column = mmt300.static.code.index(code)
    assert flight.thrust[-1, 0] == pytest.approx(mmt300.static.thrust_n[row][column], rel=2e-3)
    assert 60.0 * flight.shafts[-1, 0] == pytest.approx(
        mmt300.static.shaft_speed_rpm[row][column], rel=1e-3
    )


def test_the_rotor_and_its_controller_together_take_the_stated_lag(mmt300: BlindSubject) -> None:
    craft = craft_of(mmt300.vehicle, mmt300.static)
    craft = immovable(craft)
    codes = np.full((15, 5), 100.0)
    codes[5:] = 110.0
    flight = fly_craft(craft, belief_of(craft), commands=codes)
    step = flight.shafts[25:, 0] - flight.shafts[24, 0]
    # the area above the answer to a step is its delay
    delay = float((1.0 - step / step[-1]).sum() * 0.02)
    assert delay == pytest.approx(0.1, abs=0.015)


def test_without_bench_data_there_is_no_law(mmt300: BlindSubject) -> None:
    with pytest.raises(CannotComputeError, match="rig2sea run mmt300"):
        drive_law(mmt300.vehicle, "at_drive", "screw", None)
