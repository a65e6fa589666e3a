"""What single thrusters were found to give reaches the codes of the exported allocator."""

import numpy as np
from allocator_cases import dragging, eight
from allocator_model import allocate_fixed, allocate_single
from single_model import single_tables, thrust_from_code

from pipeline.export.allocator_layout import AllocatorLayout, allocator_layout
from pipeline.export.fixed_point import fixed_tables
from pipeline.export.grid_check import FLAG
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

SOUND = {"gain_ahead": 1.0, "gain_reverse": 1.0, "dead_zone_code": 0.0}
GENERATOR = np.random.default_rng(4)
#: Wrenches within reach at rest.
WRENCH = GENERATOR.uniform(-1, 1, (300, 6)) * [30, 30, 40, 3, 5, 5]
STILL = np.zeros((300, 3))


def layout(gain: float) -> AllocatorLayout:
    """The vehicle with eight thrusters, the first of which has this share of its thrust."""
    thrusters = [one.model_copy(update=SOUND) for one in eight().thrusters]
    thrusters[0] = thrusters[0].model_copy(update={"gain_ahead": gain, "gain_reverse": gain})
    vehicle: Vehicle = eight().model_copy(update={"thrusters": tuple(thrusters)})
    return allocator_layout(vehicle, dragging())


def error(allocator: AllocatorLayout, true_gain: float) -> FloatArray:
    """RMS of what the codes give less the demand, by axis."""
    tables = [single_tables(dragging())]
    _, codes, _ = allocate_single(allocator, tables, WRENCH, STILL)
    given = thrust_from_code(tables[0], codes, np.zeros(codes.shape)).astype(float)
    given[:, 0] *= true_gain
    left = given @ layout(1.0).allocation.matrix.T - WRENCH
    return np.asarray(np.sqrt(np.mean(left**2, axis=0)))


def test_on_the_weak_vehicle_the_error_falls_to_that_of_the_sound_one() -> None:
    sound = error(layout(1.0), 1.0)
    before, after = error(layout(1.0), 0.69), error(layout(0.69), 0.69)
    assert (before > 3.0 * sound)[[0, 1, 5]].all()
    assert (after < 1.15 * sound).all()


def test_the_others_codes_stay() -> None:
    tables = [single_tables(dragging())]
    plain = allocate_single(layout(1.0), tables, WRENCH, STILL)[1]
    weak = allocate_single(layout(0.69), tables, WRENCH, STILL)[1]
    np.testing.assert_array_equal(weak[:, 1:], plain[:, 1:])
    asked = np.abs(plain[:, 0]) > 20
    assert (np.abs(weak[asked, 0]) > np.abs(plain[asked, 0])).all()


def test_a_dead_thruster_is_asked_for_nothing_and_the_rest_do_what_they_can() -> None:
    dead = layout(0.0)
    surge = np.array([[20.0, 0, 0, 0, 0, 0]])
    for thrust, codes, flags in (
        allocate_single(dead, [single_tables(dragging())], surge, STILL[:1]),
        allocate_fixed(
            dead,
            [fixed_tables(dragging())],
            (65536 * surge).astype(np.int64),
            np.zeros((1, 3), np.int64),
        ),
    ):
        assert thrust[0, 0] == codes[0, 0] == 0
        assert not int(flags[0]) & FLAG["SATURATED"]
        size = 1.0 if abs(thrust).max() < 1000 else 65536.0
        np.testing.assert_allclose(
            thrust[0] / size @ layout(1.0).allocation.matrix.T, surge[0], atol=1e-3
        )
