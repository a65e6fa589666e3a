"""What must hold for every effect of the library, whichever it is."""

import math
from importlib import import_module

import numpy as np
import pytest
from effect_cases import CONTEXT, changed_slots, same_bits, sample_vector
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipeline.effects.effect import Effect
from pipeline.effects.library import effects
from pipeline.physics.parameters import LENGTH, slot
from pipeline.types import FloatArray

CHANNELS = {"u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "x", "y", "z"}
each = pytest.mark.parametrize("effect", effects().values(), ids=list(effects()))
each_of_one_thruster = pytest.mark.parametrize(
    "effect", [effect for effect in effects().values() if effect.scope == "thruster"]
)


def target_of(effect: Effect) -> int | None:
    return 3 if effect.scope == "thruster" else None


def applied(effect: Effect, vector: FloatArray, values: dict[str, float]) -> FloatArray:
    changed = vector.copy()
    effect.apply(changed, values, target_of(effect), CONTEXT)
    return changed


def typical(effect: Effect) -> dict[str, float]:
    """Inside the plausible range, and in no case the neutral value."""
    return {
        p.name: p.plausible[0] + (p.plausible[1] - p.plausible[0]) * 0.37 for p in effect.parameters
    }


@each
def test_neutral_leaves_every_bit(effect: Effect) -> None:
    vector = sample_vector()
    assert same_bits(applied(effect, vector, effect.neutral_values()), vector)


@given(vector=arrays(np.float64, LENGTH, elements=st.floats(-1e100, 1e100)))
def test_neutral_leaves_every_bit_of_any_vector(vector: FloatArray) -> None:
    """Signed zeros, subnormals and absurd vehicles included."""
    for effect in effects().values():
        assert same_bits(applied(effect, vector, effect.neutral_values()), vector), effect.id


@each
def test_writes_all_the_slots_it_declares_and_no_other(effect: Effect) -> None:
    vector = sample_vector()
    changed = applied(effect, vector, typical(effect))
    assert changed_slots(vector, changed) == set(effect.vector_slots)
    assert np.isfinite(changed).all()


@each
def test_every_parameter_moves_something(effect: Effect) -> None:
    vector, values = sample_vector(), typical(effect)
    base = applied(effect, vector, values)
    for parameter in effect.parameters:
        moved = values | {parameter.name: values[parameter.name] * 1.01}
        assert not same_bits(applied(effect, vector, moved), base), parameter.name


@each
def test_grows_smoothly_out_of_the_neutral(effect: Effect) -> None:
    """No jump at the neutral value: half the step is half the change, whatever the step."""
    vector, neutral, values = sample_vector(), effect.neutral_values(), typical(effect)

    def change(share: float) -> FloatArray:
        step = {k: neutral[k] + share * (values[k] - neutral[k]) for k in neutral}
        return applied(effect, vector, step) - vector

    whole, half = change(1e-4), change(5e-5)
    assert np.abs(whole).max() > 0.0
    assert np.abs(whole - 2.0 * half).max() <= 1e-3 * np.abs(whole).max()


@each
def test_absent_thrusters_keep_their_neutral_values(effect: Effect) -> None:
    vector = sample_vector()
    changed = applied(effect, vector, typical(effect))
    for name in effect.vector_slots:
        entry = slot(name)
        if entry.shape and entry.shape[0] == 12:
            start = len(CONTEXT.thruster_names)
            kept = changed[_entries(name)][start:]
            assert (kept == entry.neutral).all()


def _entries(name: str) -> slice:
    from pipeline.physics.parameters import offset

    return slice(offset(name), offset(name) + slot(name).size)


@each_of_one_thruster
def test_acts_on_the_one_thruster(effect: Effect) -> None:
    vector = sample_vector()
    with pytest.raises(ValueError, match="index of a thruster"):
        effect.apply(vector.copy(), typical(effect), None, CONTEXT)
    changed = applied(effect, vector, typical(effect))
    for name in effect.vector_slots:
        differs = np.flatnonzero(changed[_entries(name)] != vector[_entries(name)])
        assert differs.tolist() == [3]


@each
def test_ranges_are_sensible(effect: Effect) -> None:
    for p in effect.parameters:
        low, high = p.plausible
        assert math.isfinite(low)
        assert math.isfinite(high)
        assert low < high
        assert p.possible[0] <= low
        assert high <= p.possible[1]
        assert p.possible[0] <= p.neutral <= p.possible[1]
        # neutral is the edge or the inside of what can be met, not far away from it
        assert low - (high - low) <= p.neutral <= high + (high - low)


@each
def test_whole_plausible_box_leaves_a_finite_vehicle(effect: Effect) -> None:
    vector = sample_vector()
    for side in (0, 1):
        values = {p.name: p.plausible[side] for p in effect.parameters}
        assert np.isfinite(applied(effect, vector, values)).all()


def head(effect: Effect) -> str:
    """Return the text at the head of an effect's file, which is its page."""
    return import_module(f"pipeline.effects.{effect.id}").__doc__ or ""


@each
def test_is_described(effect: Effect) -> None:
    text = " ".join(head(effect).split())
    assert "It shows" in text
    assert "Easily taken for" in text
    assert len(effect.source) > 10
    assert effect.channels
    assert set(effect.channels) <= CHANNELS
    for parameter in effect.parameters:
        assert parameter.meaning
        assert parameter.unit
        assert parameter.name.isidentifier()


@each
def test_names_only_effects_that_exist_when_it_says_what_it_is_taken_for(effect: Effect) -> None:
    known = set(effects()) | {"none", "unknown"}
    quoted = set(head(effect).split("`")[1::2])
    assert quoted <= known
    assert effect.id not in quoted
