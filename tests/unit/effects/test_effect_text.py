"""The form of the command line, and what is said when it is wrong."""

import pytest
from effect_cases import NAMES
from hypothesis import given
from hypothesis import strategies as st

from pipeline.effects.effect import Effect
from pipeline.effects.library import EffectSpec, effects, parse_effect
from pipeline.errors import InputError


def test_several_values() -> None:
    spec = parse_effect("current:north_mps=0.2,east_mps=-1e-1")
    assert spec == EffectSpec("current", {"north_mps": 0.2, "east_mps": -0.1})
    assert spec.target is None


def test_thruster() -> None:
    spec = parse_effect("thruster_degraded:thrust_fraction=0.6@upper", NAMES)
    assert spec == EffectSpec("thruster_degraded", {"thrust_fraction": 0.6}, "upper")


def test_blanks_are_allowed() -> None:
    text = " thruster_misalignment : azimuth_deg = 5 , elevation_deg = -2 @ bow "
    assert str(parse_effect(text, NAMES)) == (
        "thruster_misalignment:azimuth_deg=5.0,elevation_deg=-2.0@bow"
    )


def test_thruster_is_taken_as_it_is_where_the_vehicle_is_not_known() -> None:
    assert parse_effect("thruster_degraded:thrust_fraction=0@T1:a").target == "T1:a"


def test_is_hashable() -> None:
    assert (
        len({EffectSpec("current", {"north_mps": 0.2}), parse_effect("current:north_mps=0.2")}) == 1
    )


@st.composite
def specs(draw: st.DrawFn) -> EffectSpec:
    effect: Effect = draw(st.sampled_from(list(effects().values())))
    some = draw(st.lists(st.sampled_from(effect.parameters), min_size=1, unique=True))
    values = {p.name: draw(st.floats(*p.plausible)) for p in some}
    return EffectSpec(
        effect.id, values, draw(st.sampled_from(NAMES)) if effect.scope == "thruster" else None
    )


@given(spec=specs())
def test_text_and_back(spec: EffectSpec) -> None:
    assert parse_effect(str(spec), NAMES) == spec


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("curent:north_mps=0.2", ['no effect "curent"', 'Did you mean "current"?']),
        ("voltage:drop=0.1", ['Did you mean "voltage_sag"?']),
        ("zzz:x=1", ['no effect "zzz"', "rig2sea effects"]),
        ("", ["the id of the effect is missing"]),
        (":north_mps=1", ["the id of the effect is missing"]),
        ("none:x=1", ["a verdict of the diagnosis"]),
        ("unknown", ["a verdict of the diagnosis"]),
        ("current", ["no value is given", "north_mps [m/s], east_mps [m/s]"]),
        ("current:", ["no value is given"]),
        ("thruster_degraded@upper", ["no value is given", "thrust_fraction"]),
        ("current:north=0.2", ['no parameter "north"', 'Did you mean "north_mps"?', "[m/s]"]),
        ("payload:mass=2", ['Did you mean "mass_kg"?', "volume_m3 [m^3]"]),
        ("cg_shift:dx=0.2", ['Did you mean "dx_m"?']),
        ("current:north_mps=0,2", ['"2" is not of the form key=value', "with a point"]),
        ("current:north_mps=0.1,", ['"" is not of the form key=value']),
        ("current:north_mps=", ['north_mps: "" is not a number', "in m/s"]),
        ("current:north_mps=0.2 m/s", ['"0.2 m/s" is not a number', "without the unit"]),
        ("current:north_mps=nan", ["north_mps=nan is not possible", "from -10 to 10 in m/s"]),
        ("current:north_mps=20", ["is not possible"]),
        ("dead_zone:codes=-3", ["not below 0 in code"]),
        ("lift:heave_slope=inf", ["a finite number in N s^2/m^2"]),
        ("added_mass:surge=0", ["is not possible", "1 is neutral"]),
        ("current:north_mps=0.1,north_mps=0.2", ["north_mps is given twice"]),
        ("current:north_mps=0.1@upper", ["acts on the whole vehicle", 'Leave "@upper" out']),
        ("thruster_degraded:thrust_fraction=0", ["which thruster", "upper, lower, left"]),
        ("thruster_degraded:thrust_fraction=0@", ["which thruster"]),
        (
            "thruster_degraded:thrust_fraction=0@uper",
            ['no thruster "uper"', "one of upper, lower", 'Did you mean "upper"?'],
        ),
    ],
)
def test_what_is_said(text: str, parts: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        parse_effect(text, NAMES)
    message = str(caught.value)
    assert message.startswith(f'effect "{text}": ')
    for part in parts:
        assert part in message


@given(text=st.text(max_size=40))
def test_any_text_gives_a_spec_or_one_message(text: str) -> None:
    try:
        spec = parse_effect(text, NAMES)
    except InputError:
        return
    assert spec.id in effects()


@given(
    head=st.sampled_from(["current", "payload", "thruster_degraded", "dead_zone"]),
    rest=st.text(alphabet=":=,@.0123e-_ ampsnorthkg", max_size=30),
)
def test_nearly_right_text_gives_a_spec_or_one_message(head: str, rest: str) -> None:
    try:
        spec = parse_effect(f"{head}:{rest}", NAMES)
    except InputError:
        return
    assert parse_effect(str(spec), NAMES) == spec
