"""What healthy vehicles are predicted to differ by."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import index_of, small_case

from pipeline.diagnose.case import channels_of, setting_of
from pipeline.diagnose.gap.forecast import forecast, healthy_spread, outlook
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import realisable, vector_of
from pipeline.errors import CannotComputeError


def test_vehicles_that_cannot_be_are_left_out_of_the_healthy_floor() -> None:
    """Where half of the draws have no buoyancy left the floor is that of the others."""
    case = small_case(manoeuvres=("prbs",), seconds=12.5, effects=("payload",))
    channels = channels_of(case.vehicle, case.runs)
    setting = setting_of(case, case.runs, channels, threads=1)
    every = setting.coordinates
    volume = index_of(every, "payload:volume_m3")
    width = np.zeros(len(every))
    width[volume] = 2.0
    with pytest.raises(CannotComputeError, match="buoyancy left"):
        vector_of(setting, realisable(every, -width))
    near = outlook(setting, case.runs, channels, setting.bench.stack.starts, 5.0)
    # thrusters with the stated curves
    near = replace(near, profiles=np.zeros_like(near.profiles))
    nominal = forecast(near, setting.bench.stack.packed.vector, channels)
    prior = Prior(np.zeros(len(every)), np.diag(width**2))
    calm = replace(setting, force_unit=np.zeros(6))
    found = healthy_spread(near, calm, prior, channels, nominal, seed=0)
    above = forecast(near, vector_of(setting, realisable(every, width)), channels)
    for name, squares in found.items():
        np.testing.assert_allclose(squares, (above.errors[name] - nominal.errors[name]) ** 2)
    nowhere = Prior(-width, np.zeros((len(every), len(every))))
    with pytest.raises(CannotComputeError, match="no vehicle that can be"):
        healthy_spread(near, calm, nowhere, channels, nominal, seed=0)
