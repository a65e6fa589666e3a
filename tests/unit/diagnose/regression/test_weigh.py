"""One posterior: its limits by hand, runs apart and together, and the decision."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.stats import norm

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.regression.decide import decide
from pipeline.diagnose.regression.gained import Gained
from pipeline.diagnose.regression.ordinary import (
    INEXACT,
    Ordinary,
    _scale,
    ordinary_of,
    posterior,
)
from pipeline.diagnose.regression.sizes import sizes
from pipeline.diagnose.regression.told import Told
from pipeline.diagnose.regression.weigh import (
    NONE,
    UNKNOWN,
    _groups,
    weighed,
)
from pipeline.effects.library import effects

GAIN = effects()["thruster_degraded"]
DIRECTIONS = (
    Coordinate(GAIN, GAIN.parameters[0], "left", 0.5, 0.1),
    Coordinate(GAIN, GAIN.parameters[0], "right", 0.5, 0.1),
    Coordinate(
        effects()["residual_buoyancy"],
        effects()["residual_buoyancy"].parameters[0],
        None,
        37.5,
        0.1,
    ),
)
ORDINARY = Ordinary(np.full(3, 0.1), np.ones(1))


def told(size: tuple[float, ...], information: float = 400.0) -> Told:
    """A run that shows sizes of the directions, each by itself."""
    every = information * np.eye(3)
    return Told(every[None], information * np.array([size]), np.zeros(3))


def test_one_direction_has_the_evidence_of_the_textbook() -> None:
    # x ~ N(0, s^2) read with variance 1/A and ordinary t^2: N(x; 0, v + s^2) over N(x; 0, v)
    ranking = weighed([told((0.0, 0.0, 0.8))], DIRECTIONS, ORDINARY)
    found = next(one for one in ranking if one.name == "residual_buoyancy")
    v = 1.0 / 400.0 + 0.1**2
    ratio = [
        share
        * norm(0.0, np.sqrt(v + width**2)).pdf(0.8)
        / norm(0.0, np.sqrt(v)).pdf(0.8)
        # of the wider prior a part lies beyond where a buoyancy may be
        / (2.0 * norm(0.0, width).cdf(5.0) - 1.0)
        for width, share in ((1.0, 0.8), (3.0, 0.2))
    ]
    assert found.evidence == pytest.approx(np.log(np.sum(ratio)), rel=1e-6)
    value, low, high = sizes(found, DIRECTIONS, INEXACT)[2]
    assert value == pytest.approx(37.5 * 0.8 / (1.0 + v))
    # beside a tenth of the size, which a signature may be off by
    std = np.hypot(np.sqrt(v / (1.0 + v)), 0.1 * 0.8 / (1.0 + v))
    assert high - low == pytest.approx(2 * 1.96 * 37.5 * std, rel=1e-3)


def test_an_interval_reaches_the_end_where_the_likeliest_size_is() -> None:
    first = weighed([told((-2.2, 0.0, 0.0))], DIRECTIONS, ORDINARY)[0]
    assert first.name == "thruster_degraded@left"
    value, low, high = sizes(first, DIRECTIONS, INEXACT)[0]
    assert low == 0.0 < value < high


def test_a_weak_thruster_is_counted_against_the_thrust_of_its_run() -> None:
    # all thrusters give half as much in this run, and the left one 0.6 of that
    scale = Coordinate(
        effects()["thrust_deduction"], effects()["thrust_deduction"].parameters[0], None, 0.5, 0.5
    )
    every = 4000.0 * np.eye(4)
    run = Told(every[None], 4000.0 * np.array([[-0.4, 0.0, 0.0, 1.0]]), np.array([0, 0, 0, -0.5]))
    ordinary = Ordinary(np.array([0.05, 0.05, 0.1, 1.0]), np.ones(1))
    found = weighed([run], (*DIRECTIONS, scale), ordinary)
    weak = next(one for one in found if one.name == "thruster_degraded@left")
    value, low, high = sizes(weak, (*DIRECTIONS, scale), INEXACT)[0]
    assert low < 0.6 < high
    assert value == pytest.approx(0.6, abs=0.02)


def test_a_weak_thruster_beside_a_low_supply_is_counted_against_what_is_left() -> None:
    # the supply takes half of the thrust, and the left thruster gives 0.6 of the other half
    sag = effects()["voltage_sag"]
    drop = Coordinate(sag, sag.parameters[0], None, 0.5, 0.1)
    every = 4000.0 * np.eye(4)
    run = Told(every[None], 4000.0 * np.array([[-0.4, 0.0, 0.0, 1.0]]), np.array([0, 0, 0, -0.5]))
    ordinary = Ordinary(np.full(4, 1e-3), np.ones(1))
    found = weighed([run], (*DIRECTIONS, drop), ordinary)
    assert found[0].name == "thruster_degraded@left+voltage_sag"
    assert sizes(found[0], (*DIRECTIONS, drop), INEXACT)[0][0] == pytest.approx(0.6, abs=0.02)


def test_the_mass_of_a_module_has_the_error_of_its_volume() -> None:
    """What it weighs in water is known, and neither of the two."""
    module = effects()["payload"]
    mass, volume, *_ = module.parameters
    both = (
        Coordinate(module, mass, None, 10.0, 0.0),
        Coordinate(module, volume, None, 0.01, 0.0, beside=(("mass_kg", 5.0),)),
    )
    wet = np.array([10.0, -10.0])
    run = Told(400.0 * np.outer(wet, wet)[None], 400.0 * 2.0 * wet[None], np.zeros(2))
    found = weighed([run], both, Ordinary(np.full(2, 1e-3), np.ones(1)))[0]
    assert (found.name, found.which) == ("payload", (0, 1))
    _, low, high = sizes(found, both, INEXACT)[0]
    assert low < 2.0
    assert high > 10.0


def test_probabilities_are_one_posterior() -> None:
    ranking = weighed([told((-0.8, 0.0, 0.0))], DIRECTIONS, ORDINARY)
    assert sum(one.probability for one in ranking) == pytest.approx(1.0)
    assert ranking[0].name == "thruster_degraded@left"
    assert len({one.name for one in ranking}) == len(ranking)
    assert sizes(ranking[0], DIRECTIONS, INEXACT)[0][0] == pytest.approx(0.6, abs=0.02)


def test_an_effect_may_change_two_of_its_parameters() -> None:
    """A current from the north-east has both; one from the north is not said to."""
    current = effects()["current"]
    along = tuple(Coordinate(current, own, None, 0.5, 0.1) for own in current.parameters)
    both = weighed([told((0.5, -0.5, 0.0))], along, ORDINARY)
    assert [(one.name, one.which) for one in both[:1]] == [("current", (0, 1))]
    assert sizes(both[0], along, INEXACT)[1][0] == pytest.approx(-0.25, abs=0.02)
    north = weighed([told((0.5, 0.0, 0.0))], along, ORDINARY)
    assert (north[0].name, north[0].which) == ("current", (0,))
    assert north[0].probability > 0.75


def test_eight_thrusters_share_what_an_effect_of_the_vehicle_has_and_each_is_a_part() -> None:
    names = ("a", "b", "c", "d", "e", "f", "g", "h")
    weak, trim = effects()["thruster_degraded"], effects()["residual_buoyancy"]
    every = [Coordinate(weak, weak.parameters[0], name, 0.5, 0.1) for name in names]
    every.append(Coordinate(trim, trim.parameters[0], None, 37.5, 0.1))
    shares = [share for _, share in _groups(every)]
    assert sum(shares) == pytest.approx(1.0)
    assert shares[0] == pytest.approx(0.5 / 9 + 0.25 / 8)
    assert shares[-1] == pytest.approx(0.5 / 9 + 0.25)


def test_a_thruster_that_gives_more_is_not_a_weak_one() -> None:
    ranking = weighed([told((0.4, 0.0, 0.0))], DIRECTIONS, ORDINARY)
    weak = next(one for one in ranking if one.name == "thruster_degraded@left")
    assert weak.evidence < 0.0
    assert sizes(weak, DIRECTIONS, INEXACT)[0][2] <= 1.0


def test_what_is_ordinary_is_none() -> None:
    said = decide(weighed([told((-0.1, 0.05, 0.1))], DIRECTIONS, ORDINARY))
    assert said.names == (NONE,)


def test_it_says_which_run_carries_it() -> None:
    calm, bad = told((0.0, 0.0, 0.0)), told((-0.8, 0.0, 0.0))
    first = weighed([calm, bad, calm], DIRECTIONS, ORDINARY)[0]
    assert (first.name, first.runs) == ("thruster_degraded@left", (1,))
    first = weighed([bad, bad, bad], DIRECTIONS, ORDINARY)[0]
    assert (first.name, first.runs) == ("thruster_degraded@left", (0, 1, 2))


def test_two_that_are_alike_are_not_told_apart() -> None:
    both = np.array([[400.0, 399.9, 0.0], [399.9, 400.0, 0.0], [0.0, 0.0, 400.0]])
    ranking = weighed([Told(both[None], -0.8 * both[:1], np.zeros(3))], DIRECTIONS, ORDINARY)
    said = decide(ranking)
    assert ranking[0].probability < 0.6
    assert said.names == (UNKNOWN,)
    assert said.ambiguous == ("thruster_degraded",)


def test_gains_count_where_they_show_more() -> None:
    calm = told((0.0, 0.0, 0.0), 1.0)
    dead = Gained("right", (0,), 0.0, (-0.2, 0.2), 1e-4)
    first = weighed([calm], DIRECTIONS, ORDINARY, (dead,))[0]
    assert first.name == "thruster_degraded@right"
    # -1 / (e p ln p) to one, at even priors of nothing and of all single changes as 2 to 1
    odds = -1.0 / (np.e * 1e-4 * np.log(1e-4)) / 2.0
    assert first.probability == pytest.approx(odds / (odds + 1.0), abs=0.15)
    assert sizes(first, DIRECTIONS, INEXACT)[1][0] == pytest.approx(0.0, abs=0.1)


def test_gains_do_not_count_where_the_motion_speaks_against_them() -> None:
    """A lag makes a gain look small; the force of that thruster is there all the same."""
    sound = told((0.0, 0.0, 0.0), 400.0)
    dead = Gained("right", (0,), 0.0, (-0.2, 0.2), 1e-4)
    assert weighed([sound], DIRECTIONS, ORDINARY, (dead,))[0].name == NONE


@dataclass(frozen=True)
class Drawn:
    """Runs drawn with a scatter and a noise."""

    width: float
    noise: float

    def runs(self, count: int) -> list[Told]:
        generator = np.random.default_rng(3)
        information = 100.0
        size = self.width * generator.standard_normal((count, 3))
        size += self.noise / np.sqrt(information) * generator.standard_normal((count, 3))
        return [told(tuple(one), information) for one in size]


def test_widths_are_learned_and_noise_beyond_them_tempers() -> None:
    stated = np.full(3, 0.3)
    sound = ordinary_of(Drawn(0.3, 1.0).runs(30), DIRECTIONS, stated)
    assert sound.trusted > 0.5
    assert sound.width == pytest.approx(np.full(3, 0.3), rel=0.3)
    narrow = ordinary_of(Drawn(0.03, 1.0).runs(30), DIRECTIONS, stated)
    assert (narrow.width < 0.6 * sound.width).all()
    noisy = ordinary_of(Drawn(0.3, 9.0).runs(30), DIRECTIONS, stated)
    assert noisy.trusted < 0.2
    assert (noisy.width <= 1.5 * stated + 1e-12).all()


def test_three_runs_that_hardly_differ_narrow_what_was_stated() -> None:
    """Nine squares of a tenth: the most probable scale, not halfway to what was stated."""
    squares, count = np.array([0.09, 9.0]), np.array([9.0, 9.0])
    found = _scale(squares, count)
    for one, own in zip(found, squares, strict=True):
        tried = np.exp(np.linspace(-6.0, 2.0, 4001))
        log = -4.5 * np.log(tried) - own / 2.0 / tried - 0.5 * (np.log(tried) / 1.5) ** 2
        assert one == pytest.approx(tried[np.argmax(log)], rel=3e-3)
    sound = ordinary_of([told((0.02, -0.02, 0.02))] * 3, DIRECTIONS, np.full(3, 0.3))
    assert (sound.width < 0.15).all()


def test_a_run_that_scatters_more_than_few_sound_ones_is_sound() -> None:
    """Twice in all directions is no change and nothing strange; five times is."""
    every = [
        weighed([told(tuple(size * np.array([1.0, -1.0, 1.0])))], DIRECTIONS, ORDINARY)[0].name
        for size in (0.1, 0.2, 0.5)
    ]
    assert every == [NONE, NONE, UNKNOWN]


def test_the_joint_posterior_is_the_ridge() -> None:
    one = Told(np.array([[[2.0, 1.0], [1.0, 3.0]]]), np.array([[1.0, -1.0]]), np.zeros(2))
    width = np.array([0.5, 2.0])
    mean, variance = posterior(one, width)
    inverse = np.linalg.inv(one.information + np.diag(width**-2.0))
    assert mean == pytest.approx(inverse @ one.score)
    assert variance == pytest.approx(np.diag(inverse))
    assert one.tempered(np.array([0.5])).score == pytest.approx([0.5, -0.5])


def test_what_the_sound_runs_share_among_each_other_is_no_change() -> None:
    sound, asked = [told((0.0, 0.0, 0.7), 60.0)] * 3, [told((0.0, 0.0, 0.9), 60.0)] * 4
    assert weighed(asked, DIRECTIONS, ORDINARY)[0].name == "residual_buoyancy"
    assert weighed(asked, DIRECTIONS, ORDINARY, sound=sound)[0].name == NONE
    # nor two at once
    both = [told((-0.4, 0.0, 0.7), 400.0)] * 3
    assert weighed(both, DIRECTIONS, ORDINARY)[0].probability > 0.9
    first = weighed(both, DIRECTIONS, ORDINARY, sound=both)[0]
    assert (first.name, first.probability > 0.9) == (NONE, True)


@pytest.mark.parametrize("information", [400.0, 0.01])
def test_sound_runs_that_are_as_they_were_learned_or_say_nothing_hide_no_change(
    information: float,
) -> None:
    asked, sound = [told((0.0, 0.0, 0.9))] * 4, [told((0.0, 0.0, 0.0), information)] * 3
    first = weighed(asked, DIRECTIONS, ORDINARY, sound=sound)[0]
    assert first.name == "residual_buoyancy"
    assert first.probability > 0.9


def test_what_one_sound_run_shows_as_well_is_no_change() -> None:
    """A manoeuvre that shows what was not learned shows it in sound runs, too."""
    asked = [told((0.0, 0.0, 0.6)), told((0.0, 0.0, 0.0)), told((0.0, 0.0, 0.0))]
    none = told((0.0, 0.0, 0.0))
    alone = weighed(asked, DIRECTIONS, ORDINARY, (), [none, none, none])
    beside = weighed(asked, DIRECTIONS, ORDINARY, (), [told((0.0, 0.0, 0.6)), none, none])
    found = [
        {one.name: one.probability for one in ranking}["residual_buoyancy"]
        for ranking in (alone, beside)
    ]
    assert found[0] > 0.5
    assert found[1] < 0.2


def test_a_second_effect_is_sought_beside_the_first() -> None:
    """Alone it shows nothing: the first one's signature covers it."""
    uncovered, cover = 400.0, 0.8
    every = uncovered * np.array([[1.0, 0.0, cover], [0.0, 1.0, 0.0], [cover, 0.0, 1.0]])
    size = np.array([-0.8, 0.0, 0.64])
    others = tuple(
        Coordinate(GAIN, GAIN.parameters[0], f"thruster {k}", 0.5, 0.1) for k in range(4)
    )
    directions = (*DIRECTIONS, *others)
    whole = uncovered * np.eye(7)
    whole[:3, :3] = every
    score = np.concatenate([every @ size, -uncovered * np.full(4, 0.6)])
    run = Told(whole[None], score[None], np.zeros(7))
    assert abs(score[2]) < 1e-9
    ranking = weighed([run], directions, Ordinary(np.full(7, 0.1), np.ones(1)))
    evidence = {one.name: one.evidence for one in ranking}
    both = evidence["residual_buoyancy+thruster_degraded@left"]
    assert both > evidence["thruster_degraded@left"] + 2.0
