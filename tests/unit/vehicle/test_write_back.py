"""Numbers changed in a vehicle file's text: exactly those, and nothing else."""

import difflib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.errors import CannotComputeError
from pipeline.vehicle.write_back import Value, updated_vehicle_text
from pipeline.vehicle.yaml_text import parse

TEXT = """\
# a comment
model:
  body: # another
    mass_kg: 12.5   # as weighed
    centre_m: [0.0, 0.1, -0.2] # measured
  list:
    - {a: 1, b: 2}
    - {a: 3, b: 4}
  rows:
    - 1.0
    - 2.0
"""


def plain(text: str) -> dict[str, object]:
    found: dict[str, object] = parse(text.encode(), "a.yaml").plain()
    return found


def test_only_the_numbers_change() -> None:
    new = updated_vehicle_text(
        TEXT,
        {
            "model.body.mass_kg": 13.25,
            "model.body.centre_m.2": 0.3,
            "model.list.1.a": 7.5,
            "model.rows": [8.0, 9.5],
        },
        "by hand\nin two lines",
    )
    assert new.startswith("# by hand\n# in two lines\n# a comment\n")
    expected = TEXT.replace("12.5 ", "13.25 ").replace("-0.2]", "0.3]").replace("a: 3", "a: 7.5")
    expected = expected.replace("- 1.0", "- 8").replace("- 2.0", "- 9.5")
    assert new.split("\n", 2)[2] == expected


def test_a_file_with_a_byte_order_mark_stays_readable() -> None:
    """Some editors write the mark; the readers take it, but only as the first character."""
    changes = {"model.body.mass_kg": 13.25}
    new = updated_vehicle_text("\ufeff" + TEXT, changes, "by hand")
    assert new == updated_vehicle_text(TEXT, changes, "by hand")
    assert plain(new) == plain(TEXT.replace("12.5 ", "13.25 "))


@pytest.mark.parametrize(
    ("path", "value", "line"),
    [
        ("model.body.volume_m3", 0.0125, "    volume_m3: 0.0125"),
        ("model.list.0.c", [1.0, 2.5], "    - {c: [1, 2.5], a: 1, b: 2}"),
        ("note", 'say "so"', 'note: "say \\"so\\""'),
    ],
)
def test_a_key_that_the_file_leaves_out_is_put_into_its_section(
    path: str, value: Value, line: str
) -> None:
    new = updated_vehicle_text(TEXT, {path: value}, "")
    assert line in new.splitlines()
    left = [one for one in new.splitlines() if one not in TEXT.splitlines()]
    assert left == [line]


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("model.hull.mass_kg", 1.0, "no model.hull"),
        ("model.list.5.a", 1.0, "no model.list.5"),
        ("model.body", 1.0, "a section, not a value"),
        ("model.body.centre_m", [1.0, 2.0], "no list of 2 numbers"),
        ("model.body.mass_kg.0", 1.0, "no model.body.mass_kg.0"),
    ],
)
def test_a_path_that_leads_nowhere_is_said(path: str, value: Value, says: str) -> None:
    with pytest.raises(CannotComputeError, match=says):
        updated_vehicle_text(TEXT, {path: value}, "")


@given(st.floats(-1e12, 1e12, allow_nan=False).filter(lambda x: x == 0.0 or abs(x) > 1e-12))
def test_every_number_is_read_back_as_a_number(value: float) -> None:
    back = plain(updated_vehicle_text("a: 1\n", {"a": value}, ""))["a"]
    assert isinstance(back, int | float)
    assert back == pytest.approx(value, rel=1e-6)


def test_a_whole_vehicle_file_keeps_every_other_line() -> None:
    text = (Path(bundled_vehicle("rov8")) / "vehicle.yaml").read_text(encoding="utf-8")
    new = updated_vehicle_text(text, {"model.added_mass.diagonal.0": 5.5}, "")
    changed = [
        line for line in difflib.ndiff(text.splitlines(), new.splitlines()) if line[0] in "+-"
    ]
    assert changed == [
        "-     diagonal: [6.36, 7.12, 18.68, 0.189, 0.135, 0.222]",
        "+     diagonal: [5.5, 7.12, 18.68, 0.189, 0.135, 0.222]",
    ]
