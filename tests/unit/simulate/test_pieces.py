"""Pieces simulated in one call against each of them simulated by itself."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from pipeline.physics.parameters import write
from pipeline.simulate.kernel import BODY, SEMI_IMPLICIT, STATE
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Pieces, run, run_pieces

Make = Callable[..., PackedVehicle]

COUNT = 5
STEPS_S = np.array([0.02, 0.05, 0.02, 0.03])
BOUNDS = np.array([0, 10, 18, 40, 41])


def cut() -> tuple[Pieces, np.ndarray, np.ndarray]:
    """Pieces of unequal lengths and steps, their starts, and forces from outside."""
    generator = np.random.default_rng(3)
    commands = generator.uniform(-100.0, 100.0, (BOUNDS[-1], COUNT))
    commands[5:9] = 0.0
    starts = np.zeros((len(STEPS_S), STATE))
    starts[:, 3] = 1.0
    starts[:, 7:13] = generator.normal(0.0, 0.2, (len(STEPS_S), 6))
    starts[:, BODY : BODY + COUNT] = generator.uniform(-80.0, 80.0, (len(STEPS_S), COUNT))
    return Pieces(commands, BOUNDS, STEPS_S), starts, generator.normal(0, 5.0, (BOUNDS[-1], 6))


@pytest.mark.parametrize("form", [(0.0, 1.0), (1.0, 1.0), (0.5, 2.0), (0.0, 1.4)])
def test_a_piece_knows_nothing_of_the_one_before(
    make_packed: Make, form: tuple[float, float]
) -> None:
    lags = np.zeros(12)
    lags[:COUNT] = [0.1, 0.2, 0.0, 0.15, 0.3]
    dead = np.full(12, 6.0)
    slots = {"lag": lags, "drive_dead": dead, "lag_dead_share": form[0], "lag_power": form[1]}
    packed = make_packed(**slots)
    pieces, starts, outside = cut()
    states, rates, _ = run_pieces(packed, pieces, packed.vector, starts, outside, SEMI_IMPLICIT)
    for number, (first, end) in enumerate(pairwise(BOUNDS)):
        alone = run(
            packed,
            pieces.commands[first:end],
            dt_s=float(STEPS_S[number]),
            start=starts[number],
            external=outside[first:end],
            method="semi_implicit",
        )
        rows = slice(pieces.first_row[number], pieces.last_row[number] + 1)
        np.testing.assert_array_equal(states[rows, 7:13], alone.nu)
        np.testing.assert_array_equal(rates[rows], alone.nu_dot)
        np.testing.assert_array_equal(states[rows, BODY : BODY + COUNT], alone.actuator)


@pytest.mark.parametrize(("dead_share", "power"), [(0.0, 1.0), (1.0, 1.0), (0.0, 2.0), (1.0, 1.5)])
def test_what_lags_falls_off_exponentially(
    make_packed: Make, dead_share: float, power: float
) -> None:
    """After a step of the command what lags is left where exp(-t / tau) leaves it."""
    dead, largest, tau, code = 6.0, 127.0, 0.2, 90.0
    packed = make_packed(
        lag=np.full(12, tau), drive_dead=np.full(12, dead), lag_dead_share=dead_share
    )
    write(packed.vector, "lag_power", power)
    flown = run(packed, np.full((30, COUNT), code), dt_s=0.02, method="semi_implicit")
    begins = dead_share * dead
    share = (np.full(31, code) - begins) / (largest - begins)
    lags = share**power * (1.0 - np.exp(-0.02 * np.arange(31) / tau))
    expected = begins + (largest - begins) * lags ** (1.0 / power)
    np.testing.assert_allclose(flown.actuator[1:, 0], expected[1:], rtol=1e-12)
