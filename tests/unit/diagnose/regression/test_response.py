"""A vehicle with a known answer: what is learned of it, and what is told of a change."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.diagnose.regression.grid import GridRun
from pipeline.diagnose.regression.held_out import _off, _with, decides, error_ahead, predictions
from pipeline.diagnose.regression.response import Response
from pipeline.diagnose.regression.ridge import BENT, STIFF
from pipeline.records.reference import Prediction
from pipeline.types import FloatArray, IntArray

PERIOD_S, DRAG, PUSH = 0.1, 0.5, 0.04


def linear(velocity: FloatArray, force: FloatArray) -> FloatArray:
    """Follow linear drag over a period."""
    return (1.0 - DRAG * PERIOD_S) * velocity + PUSH * force * PERIOD_S


def quadratic(velocity: FloatArray, force: FloatArray) -> FloatArray:
    """Follow quadratic drag over a long period: it takes more of a large force than of a small."""
    for _ in range(20):
        velocity = velocity + (PUSH * force - 2.0 * np.abs(velocity) * velocity) * PERIOD_S
    return velocity


def flown(
    seed: int,
    gain: float = 1.0,
    noise: float = 0.002,
    motion: Callable[[FloatArray, FloatArray], FloatArray] = linear,
) -> GridRun:
    """Yaw and surge with drag; one thruster that pushes and turns, one that turns."""
    generator = np.random.default_rng(seed)
    rows = 500
    thrust = np.repeat(generator.normal(0.0, 10.0, (rows // 10, 2)), 10, axis=0)
    wrench, own = np.zeros((rows, 6)), np.zeros((rows, 1, 6))
    own[:, 0, 0], own[:, 0, 5] = thrust[:, 0], 0.3 * thrust[:, 0]
    wrench[:, 0], wrench[:, 5] = thrust[:, 0], 0.3 * thrust[:, 0] + thrust[:, 1]
    acting = wrench - (1.0 - gain) * own[:, 0]
    velocity = np.zeros((rows, 2))
    for k in range(1, rows):
        velocity[k] = motion(velocity[k - 1], acting[k, [0, 5]])
        velocity[k] += noise * generator.standard_normal(2)
    return GridRun(
        name=f"run {seed}",
        period_s=PERIOD_S,
        time_s=PERIOD_S * np.arange(rows),
        channels=("u", "r"),
        velocity=velocity,
        attitude=np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1)),
        down=np.tile([0.0, 0.0, 1.0], (rows, 1)),
        wrench=wrench,
        more=own,
        heavier=np.zeros((1, 6, 6)),
        misread=np.zeros((1, 3, 9)),
    )


@pytest.fixture(scope="module")
def learned() -> Response:
    return Response([flown(seed) for seed in range(4)], BENT[0])


def test_the_answer_to_force_is_that_of_the_vehicle(learned: Response) -> None:
    force = learned.force.reshape(-1, 6, 2)
    assert force[0, 0, 0] == pytest.approx(PUSH * PERIOD_S, rel=0.02)
    assert force[0, 5, 1] == pytest.approx(PUSH * PERIOD_S, rel=0.02)
    # no yaw moment moves a vehicle ahead: what little was learned of that is noise
    assert (force[:, 5, 0] == 0.0).all()
    assert (force[:, 0, 1] == 0.0).all()


@pytest.mark.parametrize("gain", [1.0, 0.6, 0.0])
def test_a_run_tells_the_gain_of_its_thruster(learned: Response, gain: float) -> None:
    told = learned.told(flown(9, gain))
    std = float(told.information[0, 0]) ** -0.5
    size = float(told.score[0] / told.information[0, 0])
    assert std < 0.05
    assert size == pytest.approx(gain - 1.0, abs=4.0 * std + 0.01)


def test_drag_takes_more_of_a_large_force() -> None:
    def mean(now: FloatArray, _before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
        return quadratic(now, run.wrench[rows][:, [0, 5]])

    sound = [flown(seed, motion=quadratic) for seed in range(4)]
    response = Response(sound, BENT[-1], mean, mean, stiff=STIFF)
    run = replace(flown(9, 0.0, motion=quadratic), taken={0: -1.0})
    told = response.told(run)
    assert told.score[0] / told.information[0, 0] == pytest.approx(-1.0, abs=0.02)
    # where it is fast a newton does less than its share of what all of them do
    small = response.told(replace(run, taken={0: -0.01}))
    assert small.score[0] / small.information[0, 0] < -1.1


def test_slow_flights_of_the_file_teach_no_slope() -> None:
    """Noise of a reading takes itself off in slow runs; in a fast one it would pass for drag."""

    def mean(now: FloatArray, _before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
        return linear(now, run.wrench[rows][:, [0, 5]])

    def read(run: GridRun, share: float) -> GridRun:
        noise = 0.02 * np.random.default_rng(3).standard_normal(run.velocity.shape)
        wrench, velocity = share * run.wrench, share * run.velocity + noise
        return replace(run, wrench=wrench, more=share * run.more, velocity=velocity)

    slow = [read(flown(seed, noise=0.0), 0.01) for seed in range(4)]
    response = Response(slow, BENT[-1], mean, mean, stiff=STIFF)
    fast = read(flown(9, noise=0.0), 1.0)
    rows, left, _ = response.after(fast, np.zeros(1))
    now = fast.velocity[rows - 1]
    assert np.abs(np.sum(left * now, axis=0) / np.sum(now**2, axis=0)).max() < 0.01


def test_a_heavier_vehicle_gains_less_and_resists_that() -> None:
    heavier, half = np.zeros((1, 6, 6)), 0.5 / PUSH
    heavier[0, 0, 0] = half

    def slower(velocity: FloatArray, force: FloatArray) -> FloatArray:
        gained = PERIOD_S * (PUSH * force - DRAG * velocity)
        return velocity + gained * np.array([1.0 / 1.5, 1.0])

    response = Response([flown(seed) for seed in range(4)], BENT[0])
    run = replace(flown(9, motion=slower), more=np.zeros((500, 1, 6)), heavier=heavier)
    told = response.told(replace(run, taken={0: 1.0}))
    assert told.score[0] / told.information[0, 0] == pytest.approx(1.0, abs=0.03)


def test_sound_runs_scatter_as_they_claim(learned: Response) -> None:
    z = [one.score[0] / one.information[0, 0] ** 0.5 for one in learned.told_of_sound()]
    assert np.abs(z).max() < 3.5
    assert learned.whitened_of_sound(0).var() == pytest.approx(1.0, abs=0.25)


def test_an_acceleration_that_is_to_be_explained_is_not_taken_from_what_was_measured() -> None:
    # a heavier vehicle: the noise of an acceleration must not speak for or against it
    heavier = np.zeros((1, 6, 6))
    heavier[0, 0, 0] = 1.0 / PUSH
    runs = [
        GridRun(
            **{**vars(flown(seed, noise=0.05)), "more": np.zeros((500, 1, 6)), "heavier": heavier}
        )
        for seed in range(5)
    ]
    response = Response(runs[:4], BENT[0])
    told = response.told(runs[4])
    assert abs(told.score[0] / told.information[0, 0]) < 0.15


def test_noise_of_readings_makes_no_slow_vehicle_lighter() -> None:
    heavier = np.zeros((1, 6, 6))
    heavier[0, 0, 0] = 1.0 / PUSH

    def z(*, course: bool) -> float:
        generator, runs = np.random.default_rng(3), []
        for seed in range(15):
            run, slow = flown(seed, noise=0.0), 1.0 if seed < 4 else 0.05
            true = slow * run.velocity
            runs.append(
                replace(
                    run,
                    velocity=true + 0.02 * generator.standard_normal(true.shape),
                    course=true if course else None,
                    wrench=slow * run.wrench,
                    more=np.zeros((500, 1, 6)),
                    heavier=heavier,
                )
            )
        response = Response(runs[:5], BENT[0])
        told = [response.told(run) for run in runs[5:]]
        score = sum(float(one.score[0]) for one in told)
        return score / sum(float(one.information[0, 0]) for one in told) ** 0.5

    assert abs(z(course=True)) < 2.5
    assert z(course=False) < -4.0


def test_what_is_taken_off_is_the_change(learned: Response) -> None:
    _, before, after = learned.after(flown(9, 0.6), np.array([-0.4]))
    assert np.sqrt(np.mean(after**2)) < 0.5 * np.sqrt(np.mean(before**2))


def test_motion_and_force_explain_what_a_weak_thruster_leaves_and_no_noise(
    learned: Response,
) -> None:
    run, none, all_of_it = flown(9, 0.6), np.zeros(1), np.array([-0.4])
    left, rest, _ = learned.explained(run, none)
    assert left[0] > 20.0 * rest[0]
    left, rest, did = learned.explained(run, all_of_it)
    assert left == pytest.approx(rest, rel=0.8)
    assert did[0] > 20.0 * rest[0]
    few = {name: getattr(run, name)[:30] for name in ("time_s", "velocity", "attitude", "down")}
    short = replace(run, **few, wrench=run.wrench[:30], more=run.more[:30])
    assert np.isnan(learned.explained(short, none)[1]).all()


def test_directions_that_are_added_are_as_if_they_had_been_there(learned: Response) -> None:
    run = flown(9, 0.6)
    more = replace(
        run,
        more=np.concatenate([run.more, 2.0 * run.more], axis=1),
        heavier=np.zeros((2, 6, 6)),
        misread=np.zeros((2, 3, 6)),
    )
    whole, added = learned.told(more), learned.told(replace(more, base=run))
    assert added.information == pytest.approx(whole.information)
    assert added.score == pytest.approx(whole.score)
    assert added.thrust == pytest.approx(whole.thrust)


def test_it_predicts_what_took_no_part_better_than_the_last_value(learned: Response) -> None:
    table = predictions(learned, {})
    error = {(row.method, row.quantity, row.ahead_s): row.rmse for row in table}
    for quantity in ("velocity", "angular_velocity"):
        assert error["reference", quantity, 3.0] < 0.5 * error["last value", quantity, 3.0]


@pytest.mark.parametrize(("own", "file", "chosen"), [(0.1, 0.2, True), (0.2, 0.1, False)])
def test_the_model_that_predicts_better_decides(own: float, file: float, *, chosen: bool) -> None:
    table = tuple(
        Prediction(
            method=method, quantity="velocity", unit="m/s", ahead_s=1.0, rmse=rmse, readings=9
        )
        for method, rmse in (("reference", own), ("vehicle file", file))
    )
    assert decides(table)[0] is chosen
    assert not decides(table[:1])[0]


def test_what_runs_away_is_no_model_of_the_vehicle() -> None:
    table = tuple(
        Prediction(
            method=method, quantity="velocity", unit="m/s", ahead_s=ahead, rmse=rmse, readings=9
        )
        for method, errors in (("reference", (0.05, 5.0, 9.0)), ("vehicle file", (0.1, 0.1, 0.1)))
        for ahead, rmse in zip((1.0, 3.0, 6.0), errors, strict=True)
    )
    used, why = decides(table)
    assert not used
    assert "1, 3, 6 s ahead is 0.50, 50.00, 90.00 times that of the vehicle file" in why


def test_a_constant_that_all_runs_have_is_not_held_against_a_model() -> None:
    runs = [flown(seed) for seed in range(2)]

    def trimmed(now: np.ndarray, _before: np.ndarray, run: GridRun, rows: np.ndarray) -> np.ndarray:
        force = PUSH * PERIOD_S * run.wrench[rows][:, [0, 5]]
        return np.asarray((1.0 - DRAG * PERIOD_S) * now + force - 0.05)

    assert _off(trimmed, runs[0]) == pytest.approx([0.05, 0.05], abs=0.001)
    again = _off(_with(trimmed, _off(trimmed, runs[0])), runs[1])
    assert again == pytest.approx([0.0, 0.0], abs=0.001)


def as_known(now: FloatArray, _before: FloatArray, run: GridRun, rows: IntArray) -> FloatArray:
    """Follow the motion of `flown`, as a file has it that is right."""
    return np.asarray((1.0 - DRAG * PERIOD_S) * now + PUSH * PERIOD_S * run.wrench[rows][:, [0, 5]])


def test_a_vehicle_that_is_as_its_file_is_not_learned_anew() -> None:
    """From two short runs with noise, everything that is learned of it is an error."""
    runs = [flown(seed, noise=0.05) for seed in range(2)]
    anew = Response(runs, BENT[-1], as_known, as_known)
    stiff = Response(runs, BENT[-1], as_known, as_known, stiff=STIFF)
    assert error_ahead(stiff) < error_ahead(anew)
    off = [
        np.abs(one.force.reshape(-1, 6, 2)[0, 0, 0] / (PUSH * PERIOD_S) - 1.0)
        for one in (stiff, anew)
    ]
    assert off[0] < 1e-3 < off[1]


def test_force_that_sound_runs_hardly_had_moves_a_vehicle_as_its_file_says() -> None:
    """A trim that thrust makes up for is told by that thrust, whatever the sound runs needed."""
    runs = [flown(seed) for seed in range(4)]
    for run in runs:  # next to nothing ahead, and what there was did not move it
        run.velocity[:, 0] = 0.002 * np.random.default_rng(len(run.name)).standard_normal(500)
        run.wrench[:, 0] *= 1e-4
    blank, told = Response(runs, BENT[0]), Response(runs, BENT[0], file=as_known)
    gains = [float(one.force.reshape(-1, 6, 2)[:, 0, 0].sum()) for one in (blank, told)]
    assert gains[1] == pytest.approx(PUSH * PERIOD_S, rel=0.3)
    assert abs(gains[0] - PUSH * PERIOD_S) > PUSH * PERIOD_S


def test_force_that_no_sound_run_had_moves_a_vehicle_as_its_file_says() -> None:
    """No thruster rolls it; a centre of mass beside the middle does."""
    runs = [flown(seed) for seed in range(4)]
    for run in runs:
        run.wrench[:, 0] = 0.0
    told = Response(runs, BENT[0], file=as_known)
    gain = float(told.force.reshape(-1, 6, 2)[:, 0, 0].sum())
    assert gain == pytest.approx(PUSH * PERIOD_S, rel=0.05)


def test_force_along_another_axis_takes_nothing_from_that_along_the_own() -> None:
    """A thruster off the middle pushes and heaves at once: what moves it ahead is the push."""
    runs = [flown(seed) for seed in range(4)]
    for run in runs:
        run.wrench[:, 2] = 0.3 * run.wrench[:, 0]
    told = Response(runs, BENT[0], file=as_known)
    gain = told.force.reshape(-1, 6, 2)[0, 0, 0]
    assert gain == pytest.approx(PUSH * PERIOD_S, rel=0.05)


def test_it_may_start_from_a_motion_that_is_known() -> None:
    """What the first guess has right is not learned, and its answer to force is kept."""
    runs = [flown(seed) for seed in range(4)]
    informed, blank = Response(runs, BENT[0], as_known), Response(runs, BENT[0])
    assert informed.force.reshape(-1, 6, 2)[0, 0, 0] == pytest.approx(PUSH * PERIOD_S, rel=0.01)
    assert error_ahead(informed) < error_ahead(blank) + 0.01


def test_what_a_heavier_vehicle_resists_is_the_motion_with_the_change() -> None:
    """A thruster that is dead accelerates nothing: an added mass has nothing to resist there."""
    heavier = np.zeros((2, 6, 6))
    heavier[1, 0, 0] = 1.0

    def two(run: GridRun) -> GridRun:
        both = np.concatenate([run.more, np.zeros_like(run.more)], axis=1)
        return replace(run, more=both, heavier=heavier, misread=np.zeros((2, 3, 9)))

    learned = Response([two(flown(seed)) for seed in range(4)], BENT[0])
    run = two(flown(9, gain=0.0))
    settled = learned.settled(run, np.array([-1.0, 0.0]))
    before, after = (learned.told(one).information for one in (run, settled))
    assert after[1, 1] < 0.3 * before[1, 1]
    assert after[0, 0] == pytest.approx(before[0, 0])
    # settled anew from there, and by nothing at all
    again = learned.settled(settled, np.array([-1.0, 0.0]))
    assert again.settled_of is run
    assert learned.told(again).information == pytest.approx(after)
    plain = learned.settled(settled, np.zeros(2))
    assert learned.told(plain).information == pytest.approx(before)
