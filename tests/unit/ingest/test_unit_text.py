import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.ingest.unit_text import (
    UnitTextError,
    factor,
    is_same_unit,
    known_units,
    normalise_unit,
    quantities_of,
    unit_worth,
)

#: By hand: 1 in = 0.0254 m, 1 ft = 0.3048 m, 1 lb = 0.45359237 kg, 1 oz = lb / 16, g = 9.80665.
KNOWN = [
    ("torque", "oz in", 0.45359237 / 16 * 9.80665 * 0.0254),
    ("torque", "oz in", 0.00706155181),
    ("torque", "lb in", 0.112984829),
    ("torque", "lb ft", 1.355817948),
    ("torque", "g cm", 9.80665e-5),
    ("torque", "kg cm", 0.0980665),
    ("torque", "N mm", 0.001),
    ("torque", "N cm", 0.01),
    ("torque", "N m", 1.0),
    ("torque", "кгс м", 9.80665),
    ("force", "kgf", 9.80665),
    ("force", "gf", 0.00980665),
    ("force", "lbf", 4.4482216),
    ("force", "N", 1.0),
    ("shaft_speed", "rad/s", 60 / (2 * math.pi)),
    ("shaft_speed", "rps", 60.0),
    ("shaft_speed", "1/min", 1.0),
    ("current", "mA", 0.001),
    ("voltage", "mV", 0.001),
    ("power", "kW", 1000.0),
    ("time", "ms", 0.001),
    ("pulse_width", "ms", 1000.0),
    ("speed", "kn", 1852 / 3600),
    ("ratio", "%", 0.01),
]
SPELLINGS = [
    ("torque", "oz in", ["oz-in", "ozf.in", "OZ·IN", "oz*in", "in-oz", "ozin", "[oz.in]"]),
    ("torque", "lb in", ["lbf·in", "lb-in", "in lb", "lbin"]),
    ("torque", "lb ft", ["ft·lbf", "lbf-ft", "ft-lb", "LB FT"]),
    ("torque", "g cm", ["gf cm", "г·см", "гс·см", "гссм", "г см", "gf.cm"]),
    ("torque", "kg cm", ["kgf cm", "кгс·см", "кг·см", "kgcm", "Kg.cm", "кгссм", "кгc·см"]),
    ("torque", "N mm", ["N.mm", "Nmm", "Н·мм", "Н*мм", "N-mm", "H·мм", "(Н мм)", "мН·м"]),
    ("torque", "N cm", ["N.cm", "Н·см", "Ncm"]),
    ("torque", "N m", ["N·m", "Nm", "Н·м", "Н м", "Нм", "H·м", "N⋅m", "newton metre"]),
    ("shaft_speed", "rpm", ["RPM", "об/мин", "об/мин.", "об./мин", "1/min", "min-1", "min⁻¹",
                            "мин-1", "мин⁻¹", "r/min", "rev/min"]),
    ("shaft_speed", "rad/s", ["rad.s", "рад/с", "rad·s-1", "rad s⁻¹", "рад/сек"]),
    ("shaft_speed", "rps", ["об/с", "rev/s", "1/s", "с-1", "Hz", "Гц"]),
    ("force", "kgf", ["Kg f", "кгс", "кг", "kg", "KGF"]),
    ("force", "N", ["Н", "H", "newtons"]),
    ("force", "gf", ["гс", "g", "г"]),
    ("force", "lbf", ["lb", "lbs"]),
    ("current", "A", ["А", "amps", "[A]"]),
    ("current", "mA", ["мА", "ма"]),
    ("voltage", "V", ["В", "volts"]),
    ("power", "W", ["Вт", "вт", "watts"]),
    ("pulse_width", "us", ["µs", "μs", "мкс", "usec"]),
    ("time", "s", ["с", "сек", "sec"]),
]  # fmt: skip


@pytest.mark.parametrize(("quantity", "text", "worth"), KNOWN)
def test_units_are_worth_what_a_hand_calculation_gives(
    quantity: str, text: str, worth: float
) -> None:
    assert factor(text, quantity) == pytest.approx(worth, rel=1e-8)


@pytest.mark.parametrize(("quantity", "unit", "texts"), SPELLINGS)
def test_spellings_mean_one_unit(quantity: str, unit: str, texts: list[str]) -> None:
    assert {text: factor(text, quantity) for text in texts} == dict.fromkeys(
        texts, factor(unit, quantity)
    )


@pytest.mark.parametrize(
    "quantity", ["torque", "force", "shaft_speed", "current", "power", "speed"]
)
def test_every_unit_goes_there_and_back(quantity: str) -> None:
    """Inverse factors would pass a test of one direction only where the factor is 1."""
    for text in known_units(quantity):
        value = 12.5
        there = value * factor(text, quantity)
        assert there / factor(text, quantity) == pytest.approx(value, rel=1e-12)
        found = unit_worth(quantity, factor(text, quantity), 1.0 + 1e-6)
        assert found is not None
        assert factor(found, quantity) == pytest.approx(factor(text, quantity), rel=1e-9)


def test_larger_units_are_worth_more() -> None:
    rising = ["g cm", "N mm", "oz in", "N cm", "kg cm", "lb in", "N m", "lb ft", "kg m"]
    worths = [factor(text, "torque") for text in rising]
    assert worths == sorted(worths)


@pytest.mark.parametrize(
    ("quantity", "text", "said"),
    [
        ("torque", "V", "unit of voltage"),
        ("torque", "kg", "unit of force"),
        ("force", "N m", "unit of torque"),
        ("shaft_speed", "m/s", "unit of speed"),
        ("torque", "furlong", "not a known unit"),
        ("torque", "N/m", "not a known unit"),
        ("torque", "", "not a known unit"),
    ],
)
def test_a_unit_of_something_else_is_refused_with_the_known_ones(
    quantity: str, text: str, said: str
) -> None:
    with pytest.raises(UnitTextError, match=said) as caught:
        factor(text, quantity)
    assert all(unit in str(caught.value) for unit in known_units(quantity))


@pytest.mark.parametrize("text", ["кгсм", "гсм"])
def test_a_text_that_could_be_two_units_is_refused(text: str) -> None:
    """кгс·м and кг·см differ by a hundred."""
    with pytest.raises(UnitTextError, match="could be two units"):
        factor(text, "torque")
    assert factor("кгс·м", "torque") == pytest.approx(100 * factor("кг·см", "torque"))


def test_a_near_miss_is_offered() -> None:
    with pytest.raises(UnitTextError, match='did you mean "kg cm"'):
        factor("kgg cm", "torque")


def test_revolutions_are_not_radians() -> None:
    assert factor("1/s", "shaft_speed") == pytest.approx(
        2 * math.pi * factor("rad/s", "shaft_speed")
    )


def test_records_have_si_units_and_rpm() -> None:
    quantities = ("torque", "force", "shaft_speed", "current", "voltage", "power", "time")
    assert [known_units(name)[0] for name in quantities] == ["N m", "N", "rpm", "A", "V", "W", "s"]
    assert all(factor(known_units(name)[0], name) == 1.0 for name in quantities)


@given(
    st.sampled_from([(quantity, text) for quantity, _, texts in SPELLINGS for text in texts]),
    st.sampled_from(["", " ", "\u00a0", "  "]),
    st.booleans(),
)
def test_blanks_brackets_and_case_change_nothing(
    spelling: tuple[str, str], blank: str, upper: bool
) -> None:
    quantity, text = spelling
    dressed = f"[{blank}{text.upper() if upper else text}{blank}]" if text[0] not in "[(" else text
    assert quantity in quantities_of(dressed)
    assert factor(dressed, quantity) == factor(text, quantity)


@given(st.text(max_size=20))
def test_any_text_is_a_unit_or_is_refused(text: str) -> None:
    assert is_same_unit(text, text)
    assert normalise_unit(normalise_unit(text)) is not None
    for quantity in quantities_of(text):
        with contextlib.suppress(UnitTextError):  # "кгсм" could be two
            assert factor(text, quantity) > 0
