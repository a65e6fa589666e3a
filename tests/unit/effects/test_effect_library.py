"""The library as a whole: what is in it, for which vehicle, and switching effects on."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from effect_cases import CONTEXT, same_bits, sample_vector
from hypothesis import given
from hypothesis import strategies as st

from pipeline.effects import library
from pipeline.effects.effect import EffectContext
from pipeline.effects.library import (
    VERDICTS,
    EffectSpec,
    apply_effects,
    candidates,
    effects,
    module_names,
    unstated,
    why_not,
)
from pipeline.errors import CannotComputeError, InputError
from pipeline.physics.parameters import read

#: Ids that others rely on: none may go or change its name. A new effect need not be here.
INTERFACE_IDS = [
    "advance_speed_loss",
    "dead_zone",
    "thruster_lag",
    "voltage_sag",
    "thruster_degraded",
    "reverse_thrust",
    "thruster_misalignment",
    "thrust_deduction",
    "added_mass",
    "linear_damping",
    "quadratic_damping",
    "crossflow_coupling",
    "lift",
    "coriolis_omitted",
    "residual_buoyancy",
    "cg_shift",
    "payload",
    "current",
    "tether",
    "wall_effect",
    "dvl_scale",
    "dvl_misalignment",
    "dvl_delay",
    "dvl_lever_arm",
]
COMPLETE = replace(CONTEXT, thrust_falls_with_speed=True, coriolis=True)


def test_every_id_of_the_interface_is_there() -> None:
    assert set(effects()) >= set(INTERFACE_IDS)
    assert list(effects()) == sorted(effects())
    assert all(id_ == effect.id for id_, effect in effects().items())
    assert set(VERDICTS) == {"none", "unknown"}


def test_one_thruster_effects() -> None:
    single = {id_ for id_ in INTERFACE_IDS if effects()[id_].scope == "thruster"}
    assert single == {"thruster_degraded", "thruster_misalignment"}


def test_finds_every_file_of_the_package(repository: Path) -> None:
    folder = repository / "pipeline" / "effects"
    files = {f"pipeline.effects.{p.stem}" for p in folder.glob("*.py")} - {
        "pipeline.effects.__init__"
    }
    assert set(module_names()) == files
    holding = {p.stem for p in folder.glob("*.py") if "\nEFFECT = " in p.read_text("utf-8")}
    assert holding == set(effects()) | set(unstated(COMPLETE))


def test_the_returned_library_is_the_callers_own() -> None:
    effects().clear()
    assert effects()


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"id": "flow"}, "file's name"),
        ({"vector_slots": ("currents",)}, "no such slot: currents"),
        ({"parameters": ()}, "parameters must be there"),
    ],
)
def test_an_inconsistent_file_is_named(change: dict[str, object], match: str) -> None:
    wrong = replace(effects()["current"], **change)  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(ValueError, match=match):
        library._check_effect(wrong, "current")


def test_all_are_candidates_where_everything_is_lacking_known_and_measured() -> None:
    assert set(candidates(CONTEXT)) >= set(INTERFACE_IDS)
    assert set(candidates(CONTEXT)) | set(why_not(CONTEXT)) == set(effects())


@pytest.mark.parametrize(
    ("context", "reasons"),
    [
        (
            COMPLETE,
            {"coriolis_omitted": "already"},
        ),
        (replace(CONTEXT, strips=False), {"crossflow_coupling": "no hull sections"}),
        (replace(CONTEXT, crossflow_in_nominal=True), {"crossflow_coupling": "already"}),
        (replace(CONTEXT, walls=False), {"wall_effect": "no walls"}),
        (replace(CONTEXT, lagged=False), {"thruster_lag": "solved in time"}),
        (
            replace(CONTEXT, measured=frozenset({"imu"})),
            dict.fromkeys(
                ["dvl_delay", "dvl_lever_arm", "dvl_misalignment", "dvl_scale"], "no DVL"
            ),
        ),
        (
            replace(CONTEXT, thruster_names=()),
            dict.fromkeys(
                [
                    "advance_speed_loss",
                    "dead_zone",
                    "reverse_thrust",
                    "thrust_deduction",
                    "thruster_degraded",
                    "thruster_lag",
                    "thruster_misalignment",
                    "voltage_sag",
                ],
                "no thrusters",
            ),
        ),
    ],
)
def test_what_is_no_candidate_says_why(context: EffectContext, reasons: dict[str, str]) -> None:
    given_reasons = {id_: why for id_, why in why_not(context).items() if id_ in INTERFACE_IDS}
    assert set(given_reasons) == set(reasons)
    for id_, part in reasons.items():
        assert part in given_reasons[id_]
    assert set(candidates(context)) & set(INTERFACE_IDS) == set(INTERFACE_IDS) - set(reasons)


def test_input_is_not_changed() -> None:
    vector = sample_vector()
    before = vector.copy()
    changed = apply_effects(vector, [EffectSpec("current", {"north_mps": 0.3})], CONTEXT)
    assert same_bits(vector, before)
    assert read(changed, "current")[0] == pytest.approx(0.4)


def test_nothing_switched_on_is_the_nominal_bit_for_bit() -> None:
    vector = sample_vector()
    neutral = [
        EffectSpec(id_, effect.neutral_values(), "left" if effect.scope == "thruster" else None)
        for id_, effect in candidates(CONTEXT).items()
    ]
    assert same_bits(apply_effects(vector, [], CONTEXT), vector)
    assert same_bits(apply_effects(vector, neutral, CONTEXT), vector)


MIXED = [
    EffectSpec("payload", {"mass_kg": 5.0, "volume_m3": 0.002, "x_m": 0.7}),
    EffectSpec("cg_shift", {"dx_m": 0.02}),
    EffectSpec("residual_buoyancy", {"force_n": 12.0}),
    EffectSpec("thrust_deduction", {"t": 0.13}),
    EffectSpec("thruster_degraded", {"thrust_fraction": 0.7}, "bow"),
    EffectSpec("thruster_degraded", {"thrust_fraction": 0.3}, "left"),
    EffectSpec("current", {"north_mps": 0.1}),
    EffectSpec("current", {"north_mps": 0.23}),
]


@given(order=st.permutations(MIXED))
def test_order_of_the_specs_does_not_matter(order: list[EffectSpec]) -> None:
    vector = sample_vector()
    assert same_bits(apply_effects(vector, order, CONTEXT), apply_effects(vector, MIXED, CONTEXT))


def test_target_is_found_by_name() -> None:
    vector = sample_vector()
    changed = apply_effects(
        vector, [EffectSpec("thruster_degraded", {"thrust_fraction": 0.5}, "left")], CONTEXT
    )
    ratio = read(changed, "thrust_gain") / read(vector, "thrust_gain")
    assert ratio.tolist() == [1.0, 1.0, 0.5] + 9 * [1.0]


def test_no_candidate_cannot_be_switched_on() -> None:
    spec = EffectSpec("coriolis_omitted", {"fraction": 1.0})
    with pytest.raises(CannotComputeError, match="cannot be switched on here: the nominal model"):
        apply_effects(sample_vector(), [spec], COMPLETE)


@pytest.mark.parametrize(
    "spec",
    [
        EffectSpec("flow", {"north_mps": 0.1}),
        EffectSpec("current", {"north": 0.1}),
        EffectSpec("current", {"north_mps": float("nan")}),
        EffectSpec("current", {"north_mps": 0.1}, "left"),
        EffectSpec("added_mass", {"sway": -1.0}),
        EffectSpec("thruster_degraded", {"thrust_fraction": 0.5}),
        EffectSpec("thruster_degraded", {"thrust_fraction": 0.5}, "stern"),
    ],
)
def test_wrong_specs_are_refused(spec: EffectSpec) -> None:
    with pytest.raises(InputError, match=r"^effect "):
        apply_effects(sample_vector(), [spec], CONTEXT)


def test_vehicle_without_a_slot_filled_takes_no_harm() -> None:
    """An empty vector has no mass to share with: the place of the payload is the centre."""
    changed = apply_effects(
        np.zeros_like(sample_vector()),
        [EffectSpec("payload", {"mass_kg": 2.0, "x_m": 0.5})],
        CONTEXT,
    )
    assert read(changed, "centre_of_mass").tolist() == [0.5, 0.0, 0.0]
