"""Codes that lag their commands, by the equation of a shaft."""

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.effects.library import apply_effects
from pipeline.effects.specification import EffectSpec
from pipeline.measured.lagging import lagged
from pipeline.physics.parameters import read
from pipeline.simulate.pack import pack_vehicle
from pipeline.vehicle.load import load_vehicle

LAG_S, PERIOD_S = 0.3, 0.01


def test_a_drive_that_holds_a_torque_is_slow_near_standstill() -> None:
    """J dn/dt = Q - k n|n|: the thrust, in proportion to n|n|, lags by a time that falls with n."""
    rov = pack_vehicle(load_vehicle(bundled_vehicle("rov8")))
    largest = float(rov.code_limits[0, 1])
    stated = rov.vector.copy()
    read(stated, "lag")[: len(rov.thruster_names)] = LAG_S
    held = apply_effects(stated, [EffectSpec("lag_form", {"power": 0.5, "fall": 0.5})], rov.context)
    commands = np.zeros((300, len(rov.thruster_names)))
    commands[100:200, 0], commands[200:, 0] = 0.6 * largest, -0.3 * largest
    # tau = LAG_S at half of the largest code, so that J / 2 k = LAG_S sqrt(1 / 2)
    shaft, fine, rest = 0.0, 100, np.zeros(300)
    for row in range(300):
        for step in range(fine):
            if step == fine // 2:
                rest[row] = shaft * abs(shaft)
            torque = commands[row, 0] / largest - shaft * abs(shaft)
            shaft += PERIOD_S / fine * torque / (2.0 * LAG_S * np.sqrt(0.5))
    found = lagged(held, commands, PERIOD_S)[:, 0] / largest
    assert found == pytest.approx(rest, abs=0.02)
    even = lagged(stated, commands, PERIOD_S)[:, 0] / largest
    assert np.abs(even - rest).max() > 0.05
