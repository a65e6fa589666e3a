"""How the inflow acts on the thrust: along the motion, against it, and that it is no answer."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled
from effect_cases import CONTEXT

from pipeline.effects.library import EffectSpec, apply_effects, candidates, effects, unstated
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.pack import PackedVehicle, pack_vehicle

#: Surge speeds at which a horizontal thruster of the carrier loses thrust and does not stall. [m/s]
SPEEDS = (0.2, 0.6)
FULL = 127.0


@pytest.fixture(scope="module")
def carrier(repository: Path) -> PackedVehicle:
    """cargo_carrier, whose thrust falls with speed: T_max q (q - V / V_0)."""
    return pack_vehicle(bundled(repository, "cargo_carrier"))


def thrust(
    carrier: PackedVehicle, speed_mps: float, *effects: EffectSpec, **values: float
) -> float:
    """Thrust of a stern thruster at full code while the vehicle surges."""
    specs = [EffectSpec("inflow_form", values), *effects]
    vector = apply_effects(carrier.vector, specs, carrier.context)
    count = len(carrier.thruster_names)
    nu = np.array([[speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0]])
    codes = np.full((1, count), FULL)
    index = carrier.thruster_names.index("rear_left")
    return float(thruster_wrench(carrier, codes, nu, vector=vector)[1][0, index])


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_against_the_motion_a_share_of_the_loss_is_added(
    carrier: PackedVehicle, speed: float, share: float
) -> None:
    """With the whole share it is the straight line T = a n |n| - b |n| V through both sides."""
    rest, along = thrust(carrier, 0.0), thrust(carrier, speed)
    assert along < rest
    against = thrust(carrier, -speed, opposed_share=share)
    assert against - rest == pytest.approx(share * (rest - along), abs=1e-9)


def test_less_inflow_takes_less_thrust(carrier: PackedVehicle) -> None:
    """Where the file has the inflow, `advance_speed_loss` is a departure from the stated share."""
    rest, along = thrust(carrier, 0.0), thrust(carrier, 0.5)
    less = EffectSpec("advance_speed_loss", {"inflow_fraction": 0.8})
    assert rest - thrust(carrier, 0.5, less) == pytest.approx(0.8 * (rest - along), rel=1e-9)


def test_the_file_holds_the_curve_at_rest_against_the_motion(carrier: PackedVehicle) -> None:
    assert thrust(carrier, -0.6) == thrust(carrier, 0.0)


def test_it_is_no_answer_but_may_differ_where_thrust_falls_with_speed(
    carrier: PackedVehicle, repository: Path
) -> None:
    assert "inflow_form" not in effects()
    assert "inflow_form" not in candidates(CONTEXT)
    assert "inflow_form" in unstated(carrier.context)
    moored = pack_vehicle(bundled(repository, "rov8"))
    assert ("inflow_form" in unstated(moored.context)) == moored.context.thrust_falls_with_speed
