"""Payload, centre of gravity, buoyancy: held against sums over point masses worked by hand."""

import numpy as np
import pytest
from effect_cases import CONTEXT, GRAVITY_MPS2, sample_vector
from hypothesis import given
from hypothesis import strategies as st

from pipeline.effects.library import EffectSpec, apply_effects
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.types import FloatArray

coordinate = st.floats(-1.0, 1.0)
place = st.tuples(coordinate, coordinate, coordinate)


def applied(id_: str, **values: float) -> FloatArray:
    return apply_effects(sample_vector(), [EffectSpec(id_, values)], CONTEXT)


def about_centre(vector: FloatArray) -> FloatArray:
    """Inertia about the centre of mass, from that about the origin. [kg m^2]"""
    r, m = read(vector, "centre_of_mass"), float(read(vector, "mass"))
    return np.asarray(read(vector, "inertia") - m * (r @ r * np.eye(3) - np.outer(r, r)))


def test_cg_shift_by_hand() -> None:
    """300 kg from x = 0.02 to 0.12 m: I_yy and I_zz gain 300 (0.0144 - 0.0004) = 4.2 kg m^2."""
    before, after = sample_vector(), applied("cg_shift", dx_m=0.1)
    assert read(after, "centre_of_mass") == pytest.approx([0.12, 0.0, 0.03])
    gained = read(after, "inertia") - read(before, "inertia")
    assert np.diag(gained) == pytest.approx([0.0, 4.2, 4.2], abs=1e-9)
    # product of inertia: -m (x z) goes from -300 0.02 0.03 to -300 0.12 0.03
    assert gained[0, 2] == pytest.approx(-0.9)
    assert gained[2, 0] == pytest.approx(-0.9)
    for name in ("mass", "weight", "buoyancy", "centre_of_buoyancy"):
        assert (read(after, name) == read(before, name)).all()


@given(shift=place)
def test_cg_shift_keeps_the_inertia_about_the_centre(shift: tuple[float, float, float]) -> None:
    after = applied("cg_shift", dx_m=shift[0], dy_m=shift[1], dz_m=shift[2])
    assert about_centre(after) == pytest.approx(about_centre(sample_vector()), abs=1e-9)
    assert read(after, "inertia") == pytest.approx(read(after, "inertia").T, abs=1e-12)


@given(shift=place)
def test_cg_shift_and_back(shift: tuple[float, float, float]) -> None:
    there = applied("cg_shift", dx_m=shift[0], dy_m=shift[1], dz_m=shift[2])
    back = apply_effects(
        there,
        [EffectSpec("cg_shift", {"dx_m": -shift[0], "dy_m": -shift[1], "dz_m": -shift[2]})],
        CONTEXT,
    )
    assert back == pytest.approx(sample_vector(), abs=1e-9)


def test_payload_by_hand() -> None:
    """10 kg and 4 l at (1, 0, 0.2) on 300 kg at (0.02, 0, 0.03) with 2950 N at (0.02, 0.01, 0)."""
    before = sample_vector()
    after = applied("payload", mass_kg=10.0, volume_m3=0.004, x_m=1.0, y_m=0.0, z_m=0.2)
    assert read(after, "mass") == 310.0
    assert read(after, "weight") == pytest.approx(310.0 * 9.81)
    # (300 * 0.02 + 10 * 1) / 310, (300 * 0.03 + 10 * 0.2) / 310
    assert read(after, "centre_of_mass") == pytest.approx([16 / 310, 0.0, 11 / 310])
    lift = 1000.62 * 9.81 * 0.004
    assert read(after, "buoyancy") == pytest.approx(2950.0 + lift)
    assert read(after, "centre_of_buoyancy") == pytest.approx(
        [
            (2950 * 0.02 + lift) / (2950 + lift),
            2950 * 0.01 / (2950 + lift),
            lift * 0.2 / (2950 + lift),
        ]
    )
    gained = read(after, "inertia") - read(before, "inertia")
    # 10 (y^2 + z^2), 10 (x^2 + z^2), 10 (x^2 + y^2), and -10 x z
    assert gained == pytest.approx(np.array([[0.4, 0, -2.0], [0, 10.4, 0], [-2.0, 0, 10.0]]))


@given(mass=st.floats(0.1, 50.0), volume=st.floats(0.0, 0.05), at=place)
def test_payload_moments_are_those_of_the_parts(
    mass: float, volume: float, at: tuple[float, float, float]
) -> None:
    """First moments of weight and of buoyancy are sums over vehicle and payload."""
    before = sample_vector()
    values = {"x_m": at[0], "y_m": at[1], "z_m": at[2]}
    after = applied("payload", mass_kg=mass, volume_m3=volume, **values)
    r = np.array(at)
    assert read(after, "mass") * read(after, "centre_of_mass") == pytest.approx(
        read(before, "mass") * read(before, "centre_of_mass") + mass * r, abs=1e-9
    )
    lift = 1000.62 * GRAVITY_MPS2 * volume
    assert read(after, "buoyancy") * read(after, "centre_of_buoyancy") == pytest.approx(
        read(before, "buoyancy") * read(before, "centre_of_buoyancy") + lift * r, abs=1e-7
    )
    # parallel axes: about the common centre, the pair gains the reduced mass at its distance
    apart = r - read(before, "centre_of_mass")
    reduced = 300.0 * mass / (300.0 + mass)
    gained = reduced * (apart @ apart * np.eye(3) - np.outer(apart, apart))
    assert about_centre(after) == pytest.approx(about_centre(before) + gained, abs=1e-8)
    assert np.linalg.eigvalsh(about_centre(after)).min() > 0.0


@given(mass=st.floats(0.1, 50.0), volume=st.floats(0.0001, 0.05), at=place)
def test_payload_on_and_off(mass: float, volume: float, at: tuple[float, float, float]) -> None:
    values = {"x_m": at[0], "y_m": at[1], "z_m": at[2]}
    on = applied("payload", mass_kg=mass, volume_m3=volume, **values)
    off = apply_effects(
        on, [EffectSpec("payload", {"mass_kg": -mass, "volume_m3": -volume, **values})], CONTEXT
    )
    assert off == pytest.approx(sample_vector(), abs=1e-8)


def test_neutral_payload_changes_the_trim_but_not_the_balance() -> None:
    after = applied("payload", mass_kg=10.0, volume_m3=10.0 / 1000.62, x_m=0.5)
    before = sample_vector()
    net = [float(read(v, "weight") - read(v, "buoyancy")) for v in (before, after)]
    assert net[1] == pytest.approx(net[0])


@pytest.mark.parametrize(
    ("values", "match"),
    [({"mass_kg": -300.0}, "0 kg left"), ({"volume_m3": -1.0}, "N of buoyancy left")],
)
def test_payload_that_leaves_no_vehicle(values: dict[str, float], match: str) -> None:
    with pytest.raises(CannotComputeError, match=match):
        applied("payload", **values)


def test_buoyancy_is_upward_positive() -> None:
    before, after = sample_vector(), applied("residual_buoyancy", force_n=7.5)
    assert read(after, "buoyancy") - read(before, "buoyancy") == pytest.approx(7.5)
    assert (read(after, "centre_of_buoyancy") == read(before, "centre_of_buoyancy")).all()


def test_shift_then_payload() -> None:
    """The dry vehicle's centre moves first: (300 * 0.12 + 10 * 1) / 310."""
    after = apply_effects(
        sample_vector(),
        [
            EffectSpec("payload", {"mass_kg": 10.0, "x_m": 1.0}),
            EffectSpec("cg_shift", {"dx_m": 0.1}),
        ],
        CONTEXT,
    )
    assert read(after, "centre_of_mass")[0] == pytest.approx(46 / 310)
