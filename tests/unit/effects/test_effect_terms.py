"""Thrusters, hull, surroundings, measurement: what each number becomes in the vector."""

from math import pi

import numpy as np
import pytest
from effect_cases import CONTEXT, sample_vector
from hypothesis import given
from hypothesis import strategies as st

from pipeline.effects.effect import AXES
from pipeline.effects.library import EffectSpec, apply_effects, parse_effect
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.types import FloatArray

ABSENT = 7 * [0.0]
factors = st.fixed_dictionaries({axis: st.floats(0.05, 20.0) for axis in AXES})


def applied(text: str) -> FloatArray:
    return apply_effects(sample_vector(), [parse_effect(text, CONTEXT.thruster_names)], CONTEXT)


def difference(text: str, slot: str) -> FloatArray:
    return np.asarray(read(applied(text), slot) - read(sample_vector(), slot))


def ratio(text: str, slot: str) -> FloatArray:
    return np.asarray(read(applied(text), slot) / read(sample_vector(), slot))


@given(values=factors)
def test_added_mass_stays_symmetric_and_positive(values: dict[str, float]) -> None:
    vector = apply_effects(sample_vector(), [EffectSpec("added_mass", values)], CONTEXT)
    matrix, before = read(vector, "added_mass"), read(sample_vector(), "added_mass")
    assert (matrix == matrix.T).all()
    assert np.linalg.eigvalsh(matrix).min() > 0.0
    assert np.diag(matrix) == pytest.approx(np.diag(before) * [values[axis] for axis in AXES])


def test_added_mass_off_the_diagonal() -> None:
    """Factors 4 in sway and 9 in yaw: A_26 by 6, A_22 by 4, A_12 by 2."""
    got = ratio("added_mass:sway=4,yaw=9", "added_mass")
    assert got[1, 5] == got[5, 1] == 6.0
    assert got[1, 1] == 4.0
    assert got[0, 1] == got[1, 0] == 2.0
    assert got[0, 0] == 1.0


@given(values=factors, nu=st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6))
def test_linear_damping_never_gives_energy(values: dict[str, float], nu: list[float]) -> None:
    vector = apply_effects(sample_vector(), [EffectSpec("linear_damping", values)], CONTEXT)
    speed = np.array(nu)
    assert speed @ read(vector, "linear_damping") @ speed >= 0.0


def test_linear_damping_can_vanish() -> None:
    got = ratio("linear_damping:heave=0", "linear_damping")
    assert (got[2] == 0.0).all()
    assert (got[:, 2] == 0.0).all()
    assert got[0, 0] == 1.0


def test_quadratic_damping_by_axis() -> None:
    got = ratio("quadratic_damping:surge=1.5,pitch=0.5", "quadratic_damping")
    assert got.tolist() == [1.5, 1.0, 1.0, 1.0, 0.5, 1.0]


def test_lift_slopes_of_the_pilgrim() -> None:
    """Kostenko 2017: 1375 N/rad at 3 m/s is 1375 N / (3 m/s)^2 = 152.8 N s^2/m^2."""
    vector = applied(f"lift:heave_slope={1375 / 9},yaw_slope=-3")
    assert read(vector, "heave_lift_slope") == pytest.approx(152.8, abs=0.03)
    assert read(vector, "yaw_lift_slope") == -3.0
    assert read(vector, "pitch_lift_slope") == read(vector, "sway_lift_slope") == 0.0


def test_crossflow_coriolis_and_walls_add_their_share() -> None:
    assert difference("crossflow_coupling:fraction=0.8", "crossflow_fraction") == 0.8
    assert difference("wall_effect:strength=0.375", "wall_strength") == 0.375
    lacking = sample_vector()
    read(lacking, "coriolis_fraction")[...] = 0.0
    whole = apply_effects(lacking, [EffectSpec("coriolis_omitted", {"fraction": 1.0})], CONTEXT)
    assert read(whole, "coriolis_fraction") == 1.0


def test_advance_speed_loss_from_mooring_to_open_water() -> None:
    moored = sample_vector()
    read(moored, "inflow_fraction")[:5] = 0.0
    spec = EffectSpec("advance_speed_loss", {"inflow_fraction": 1.0})
    assert (read(apply_effects(moored, [spec], CONTEXT), "inflow_fraction") == 1.0).all()


def test_dead_zone_lag_and_sag_add() -> None:
    assert difference("dead_zone:codes=8", "dead_zone").tolist() == [8.0] * 5 + ABSENT
    got = difference("thruster_lag:lag_s=0.25", "lag")
    assert got == pytest.approx(np.array([0.25] * 5 + ABSENT))
    sag = applied("voltage_sag:drop=0.1,load_drop=0.05")
    assert read(sag, "supply_drop") == 0.1
    assert read(sag, "load_drop") == 0.05


def test_dead_zone_must_leave_codes() -> None:
    applied("dead_zone:codes=126")
    with pytest.raises(CannotComputeError, match='nothing of the 127 codes of thruster "upper"'):
        applied("dead_zone:codes=127")


def test_sag_must_leave_voltage() -> None:
    with pytest.raises(CannotComputeError, match="below 1"):
        applied("voltage_sag:drop=0.5,load_drop=0.5")


def test_sag_on_top_of_sag_must_leave_voltage() -> None:
    """The limit holds for what is missing altogether, a sag of the vector before included."""
    half = applied("voltage_sag:drop=0.6")
    with pytest.raises(CannotComputeError, match=r"drop 1.2 and load_drop 0 together leave no"):
        apply_effects(half, [parse_effect("voltage_sag:drop=0.6")], CONTEXT)


def test_thrust_deduction_is_for_both_signs_and_all_thrusters() -> None:
    got = ratio("thrust_deduction:t=0.2", "thrust_gain")
    assert got == pytest.approx(np.array([0.8] * 5 + 7 * [1.0]))
    assert (ratio("thrust_deduction:t=0.2", "reverse_gain") == 1.0).all()


def test_reverse_thrust_leaves_thrust_ahead() -> None:
    got = ratio("reverse_thrust:fraction=0.78", "reverse_gain")
    assert got == pytest.approx(np.array([0.78] * 5 + 7 * [1.0]))
    assert (ratio("reverse_thrust:fraction=0.78", "thrust_gain") == 1.0).all()


def test_deduction_and_a_dead_thruster_multiply() -> None:
    specs = [
        parse_effect("thrust_deduction:t=0.5"),
        parse_effect("thruster_degraded:thrust_fraction=0.5@right"),
    ]
    vector = sample_vector()
    got = read(apply_effects(vector, specs, CONTEXT), "thrust_gain") / read(vector, "thrust_gain")
    assert got[:5].tolist() == [0.5, 0.5, 0.5, 0.25, 0.5]


def test_misalignment_in_radians() -> None:
    vector = applied("thruster_misalignment:azimuth_deg=90,elevation_deg=-30@lower")
    assert read(vector, "misalignment_azimuth")[:3] == pytest.approx([0.0, pi / 2, 0.0])
    assert read(vector, "misalignment_elevation")[:3] == pytest.approx([0.0, -pi / 6, 0.0])


def test_current_adds_to_the_stated_one() -> None:
    got = difference("current:north_mps=0.2,down_mps=-0.05", "current")
    assert got == pytest.approx(np.array([0.2, 0.0, -0.05]))


def test_tether() -> None:
    vector = applied("tether:drag_area_m2=0.3,pull_n=12")
    assert read(vector, "tether_drag_area") == 0.3
    assert read(vector, "tether_pull") == 12.0


def test_tether_of_the_nominal_model_can_be_departed_from() -> None:
    towed = sample_vector()
    read(towed, "tether_drag_area")[...] = 0.2
    more = apply_effects(towed, [EffectSpec("tether", {"drag_area_m2": 0.1})], CONTEXT)
    assert read(more, "tether_drag_area") == pytest.approx(0.3)


def test_dvl() -> None:
    assert ratio("dvl_scale:scale=1.04", "dvl_scale") == pytest.approx(1.04)
    got = difference("dvl_misalignment:roll_deg=1,yaw_deg=-2", "dvl_rotation")
    assert got == pytest.approx(np.array([pi / 180, 0.0, -pi / 90]))
    assert difference("dvl_delay:delay_s=0.15", "dvl_delay") == 0.15
    got = difference("dvl_lever_arm:x_m=0.3,z_m=-0.1", "dvl_lever_arm")
    assert got.tolist() == [0.3, 0.0, -0.1]
