"""The kernel's arrays of a tether: how large they may become."""

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.physics.winch import Winch
from pipeline.simulate.tether import LumpedMassTether, Prepared, TetherState, prepare

CABLE = LumpedMassTether(10.0, 20, 0.01, 0.1, 1.2, 0.01, 2e4, 1000.0, 9.81)


def prepared(longest_m: float) -> Prepared:
    places = np.column_stack([np.zeros(21), np.zeros(21), np.linspace(0.0, 10.0, 21)])
    return prepare(
        CABLE,
        TetherState(places, np.zeros_like(places), np.full(20, 0.5)),
        current_mps=np.zeros(3),
        winch=Winch(0.2, 1.0, 60.0, 5.0, longest_m=longest_m),
        winch_command=0.0,
    )


def test_there_is_room_for_what_the_winch_can_pay_out() -> None:
    assert len(prepared(1000.0).place) == 2004


@pytest.mark.parametrize("longest_m", [1e5, 1e308])
def test_a_winch_with_more_cable_than_memory_is_refused(longest_m: float) -> None:
    with pytest.raises(CannotComputeError, match="State a shorter longest_m of the winch"):
        prepared(longest_m)
