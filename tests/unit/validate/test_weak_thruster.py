"""Flown in a closed loop on the weak vehicle, the corrected allocator errs as on the sound one."""

import numpy as np
from flight_cases import Bench

from evaluation.weak_thruster import fly_all, table


def test_the_error_on_the_weak_vehicle_falls_to_that_of_the_sound_one(mmt300: Bench) -> None:
    flown = fly_all(mmt300.vehicle, mmt300.model, mmt300.inverse)
    sound, before, after = (one.rms[[0, 4]] for one in flown.values())
    assert (before > 3.0 * sound).all()
    assert (after < 1.1 * sound).all()
    codes = [one.flight.codes for one in flown.values()]
    ahead = codes[0][:, 0] > 20.0
    assert (codes[2][ahead, 0] > codes[0][ahead, 0]).mean() > 0.95
    # the same demand at the start: the others' codes stay
    np.testing.assert_array_equal(codes[2][0, 1:], codes[0][0, 1:])
    assert "weak, file corrected" in table(flown)
