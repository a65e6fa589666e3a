"""Two allocators that differ in nothing but what they know of the inflow."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled
from flight_cases import one_way_horizontals

from pipeline.simulate.pack import pack_vehicle
from pipeline.validate.closed_loop import ClosedLoop
from pipeline.validate.controllers import general_controllers
from pipeline.validate.plan import calm_vehicle

#: A surge with a turn to starboard: two horizontals would have to push back.
DEMAND = np.array([20.0, 0.0, 0.0, 0.0, 0.0, 6.0])


@pytest.mark.parametrize("one_way", [False, True])
def test_at_rest_the_compensated_allocator_is_the_one_at_rest(
    repository: Path, *, one_way: bool
) -> None:
    vehicle = one_way_horizontals(repository) if one_way else bundled(repository, "rov8")
    controllers = general_controllers(calm_vehicle(pack_vehicle(vehicle)))
    codes, wanted, cut = controllers.mooring.decide(DEMAND, np.zeros(6))
    compensated = controllers.compensated.decide(DEMAND, np.zeros(6))
    assert compensated[0].tolist() == codes.tolist()
    assert compensated[1] == pytest.approx(wanted)
    assert not cut
    assert not compensated[2]
    assert codes[1] == codes[3] > 100.0
    assert bool(codes[0] == 0.0) is one_way


def test_thrusters_without_reverse_are_named_and_turn_alike(repository: Path) -> None:
    vehicle = one_way_horizontals(repository)
    field = ClosedLoop.of(vehicle, pack_vehicle(vehicle), None, None)
    (text,) = (text for text in field.explanations if "reverse" in text)
    assert "front_right, front_left, rear_right, rear_left. What a demand asks of them" in text
    assert "vertical" not in text
    turned = [
        float(np.degrees(field.step(member, 0.0, heading_deg=20.0).motion[-1, 2]))
        for member in (field.controllers.mooring, field.controllers.compensated)
    ]
    assert turned == pytest.approx([20.0, 20.0], abs=3.0)
