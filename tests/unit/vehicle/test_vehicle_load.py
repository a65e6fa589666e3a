"""The vehicle file is read, or refused with one message that says how to mend it."""

import contextlib
import json
import math
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import InputError
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.yaml_text import MAX_BYTES, MAX_DEPTH, parse

GOOD = """\
name: mmt300
title: "MMT-300, four inclined thrusters"
water:
  density_kgpm3: 1000.62
  gravity_mps2: 9.81
propellers:
  screw: {diameter_m: 0.2, pitch_ratio: 0.8, blades: 3}
drives:
  motor: {code_min: -127, code_max: 127}
thrusters:
  - name: upper
    propeller: screw
    drive: motor
    position_m: [-1.0, 0, -0.1]
    direction: [0.9238795, 0, -0.3826834]
tables:
  propeller: screw
  drive: motor
columns:
  mooring:
    thrust: {header: "Упор", unit: kgf, sign: -1}
    only: {"Run": "up"}
"""


def write(folder: Path, text: str | bytes) -> Path:
    path = folder / "vehicle.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def message(folder: Path, text: str | bytes) -> str:
    """Return the refusal, with the folder cut off."""
    with pytest.raises(InputError) as caught:
        load_vehicle(write(folder, text))
    return str(caught.value).replace(f"{folder}/", "")


def replaced(old: str, new: str) -> str:
    assert GOOD.count(old) == 1
    return GOOD.replace(old, new)


def test_a_good_file_is_read(tmp_path: Path) -> None:
    vehicle = load_vehicle(write(tmp_path, GOOD))
    assert vehicle.water.density_kgpm3 == 1000.62
    assert vehicle.propeller.diameter_m == 0.2
    assert vehicle.drive.code_max == 127
    assert vehicle.thrusters[0].direction == (0.9238795, 0.0, -0.3826834)
    thrust = vehicle.columns.mooring.thrust
    assert thrust is not None
    assert (thrust.header, thrust.unit, thrust.sign) == ("Упор", "kgf", -1)
    assert vehicle.columns.mooring.only == {"Run": "up"}


def test_the_folder_does_as_well_and_a_byte_order_mark_does_not_matter(tmp_path: Path) -> None:
    write(tmp_path, b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert load_vehicle(tmp_path) == load_vehicle(tmp_path / "vehicle.yaml")


def test_unknown_key_names_the_nearest_with_its_line(tmp_path: Path) -> None:
    text = message(tmp_path, replaced("  density_kgpm3", "  dencity_kgpm3"))
    assert text == (
        "vehicle.yaml: 2 faults.\n"
        '  row 3: key "density_kgpm3" is missing in water. '
        "Expected a number above 500 and below 1500.\n"
        '  row 4: unknown key "dencity_kgpm3" in water. '
        'Expected one of density_kgpm3, gravity_mps2. Did you mean "density_kgpm3"?'
    )


def test_one_fault_is_said_in_three_lines(tmp_path: Path) -> None:
    text = message(tmp_path, replaced("blades: 3", "blades: 3, blads: 3"))
    assert text == (
        'vehicle.yaml, row 7: unknown key "blads" in propellers.screw.\n'
        "Expected one of diameter_m, pitch_ratio, area_ratio, blades, source.\n"
        'Did you mean "blades"?'
    )


def test_unknown_key_like_nothing_known_has_no_guess(tmp_path: Path) -> None:
    text = message(tmp_path, "zzzz: 1\n" + GOOD)
    assert 'vehicle.yaml, row 1: unknown key "zzzz".' in text
    assert "Did you mean" not in text


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (
            "1000.62",
            '"1000.62"',
            'row 4: water.density_kgpm3 is "1000.62".\nExpected a number above 500 and below 1500',
        ),
        ("1000.62", '"1000.62"', "below 1500.\nRemove the quotes."),
        ("1000.62", "1000,62", "Write a decimal point: 1000.62"),
        ("1000.62", "1.2", "row 4: water.density_kgpm3 is 1.2.\nExpected a number above 500"),
        ("1000.62", "true", "row 4: water.density_kgpm3 is true.\nExpected a number"),
        ("1000.62", "", "row 4: water.density_kgpm3 is empty.\nExpected a number"),
        ("1000.62", ".nan", 'row 4: ".nan" as a value, which is refused.\nExpected a finite'),
        ("1000.62", "-.inf", "row 4"),
        ("1000.62", "1e999", "row 4: 1e999 is beyond the range of numbers"),
        ("1000.62", "[1, 2]", "row 4: water.density_kgpm3 is a list of 2."),
        ("diameter_m: 0.2", "diameter_m: 0,2", "write a decimal point instead of the comma"),
        ("[-1.0, 0, -0.1]", "[-1.0, 0]", "row 14: thrusters[1].position_m has too few entries"),
        ("[-1.0, 0, -0.1]", "[-1.0, 0, 1, 2]", "row 14: thrusters[1].position_m is a list of 4."),
        ("[-1.0, 0, -0.1]", "[-1.0, x, 1]", 'row 14: thrusters[1].position_m[2] is "x".'),
        ("-0.3826834", "0.9", "row 11: thrusters[1]: direction has length 1.2898, a unit"),
        ("code_max: 127", "code_max: 127.5", "drives.motor.code_max is 127.5.\nExpected a whole"),
        ("sign: -1", "sign: 2", "row 21: columns.mooring.thrust.sign is 2.\nExpected one of 1, -1"),
        ('"Run": "up"', '"Run": 5', "columns.mooring.only.Run is 5.\nExpected text.\nPut it in"),
        ("  screw: ", "  big screw: ", '"big screw" in propellers is refused'),
        ("name: mmt300", "name: ../etc", 'row 1: name is "../etc".\nExpected a name: a letter'),
        (
            "tables:\n  propeller: screw",
            "tables:\n  propeller: skrew",
            "row 17: tables.propeller: t",
        ),
        (
            "    drive: motor",
            "    drive: none",
            'row 13: thrusters[1].drive: there is no drive "no',
        ),
    ],
)
def test_wrong_values(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert expected in message(tmp_path, replaced(old, new))


def test_every_fault_is_in_the_one_message_in_order_of_lines(tmp_path: Path) -> None:
    text = GOOD.replace("9.81", "981").replace("code_max: 127", "code_max: -1")
    text = text.replace("name: upper", "nam: upper").replace("mmt300", "5")
    found = message(tmp_path, text)
    rows = [int(row) for row in re.findall(r"^  row (\d+):", found, flags=re.MULTILINE)]
    assert found.startswith("vehicle.yaml: 5 faults.")
    assert rows == sorted(rows)
    assert set(rows) == {1, 5, 9, 11}


def test_a_flood_of_faults_is_cut(tmp_path: Path) -> None:
    text = message(tmp_path, GOOD + "".join(f"k{n}: 1\n" for n in range(100)))
    assert "100 faults" in text
    assert "and 80 more" in text
    assert text.count("\n") == 21


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "the file is empty"),
        ("# nothing\n", "the file is empty"),
        ("- a\n- b\n", "row 1: the file does not hold keys with values"),
        ("name\n", "row 1: the file does not hold keys with values"),
        ("a: &x 1\nb: *x\n", 'row 1: anchor or alias "x"'),
        ("a: 1\nb: *x\n", 'row 2: anchor or alias "x"'),
        ("a: 1\nb: !!python/object:os.system 1\n", "row 2: tag"),
        ("a: !x {b: 1}\n", "row 1: tag"),
        ("a: 1\nb: 2\na: 3\n", 'row 3: key "a" stands twice, first in row 1'),
        ("a: 1\n---\nb: 1\n", "row 2: a second YAML document"),
        ("a:\n\tb: 1\n", "row 2: a tab is used for indentation"),
        ("a: [1, 2\nb: 1\n", "row 2: not valid YAML"),
        ('a: "never closed\n', "not valid YAML"),
        ("[1]: 2\n", "a list or section as a key"),
        ("? {a: b}\n: 2\n", "a list or section as a key"),
        ('a: 1\nb: "\\U00110000"\n', "not readable as YAML"),
        ('a: "\\ud800"\n', "half of a surrogate pair"),
        ('"\\ud800": 1\n', "half of a surrogate pair"),
        (b"a: 1\nb: \xff\n", "row 2: byte 0xff is not UTF-8"),
        ("a: 1\n".encode("utf-16"), "row 1: byte 0xff is not UTF-8"),
        (b"a: 1\nb: \x00\n", "row 2: control character 0x0"),
        ("a: " + "[" * 100_000, "nesting too deep"),
        ("{a: " * 100_000, "nesting too deep"),
        ("a: [" + "1," * 30_000 + "]", "too many entries"),
        (b"#" * (MAX_BYTES + 1), "the file is larger than 1000 kB"),
        ("%YAML 9.9\n---\na: 1\n", "row 1: not valid YAML"),
    ],
)
def test_hostile_and_broken_text(tmp_path: Path, text: str | bytes, expected: str) -> None:
    assert expected in message(tmp_path, text)


def test_no_file_and_no_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        load_vehicle(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"vehicle\.yaml: there is no such file"):
        load_vehicle(tmp_path)
    (tmp_path / "vehicle.yaml").mkdir()
    with pytest.raises(InputError, match="this is not a file"):
        load_vehicle(tmp_path)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-07", -7),
        ("0x1F", 31),
        ("0o17", 15),
        ("1e3", 1000.0),
        ("1.", 1.0),
        (".5", 0.5),
        ("+1.5E-1", 0.15),
        ("true", True),
        ("yes", "yes"),
        ("1_000", "1_000"),
        ("12:30", "12:30"),
        ("~", None),
        ("", None),
        ("'1'", "1"),
        ("1,5", "1,5"),
    ],
)
def test_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    found = parse(f"a: {text}\n".encode(), "x").plain()["a"]
    assert found == value
    assert type(found) is type(value)


@given(st.binary(max_size=200))
def test_any_bytes_give_a_tree_or_one_message(data: bytes) -> None:
    with contextlib.suppress(InputError):
        assert isinstance(parse(data, "x.yaml").plain(), dict)


@given(st.text(alphabet="ab:-[]{}&*!|>'\"\n #,?%@1.~<", max_size=60))
def test_any_yaml_like_text_gives_a_tree_or_one_message(text: str) -> None:
    with contextlib.suppress(InputError):
        assert isinstance(parse(text.encode(), "x.yaml").plain(), dict)


@given(
    st.recursive(
        st.floats(allow_nan=False, allow_infinity=False) | st.text("abc ", max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3) | st.dictionaries(st.text("xy", min_size=1), inner)
        ),
        max_leaves=10,
    )
)
def test_what_json_can_say_comes_back(tree: object) -> None:
    """JSON is YAML: a tree written as JSON is read as it was."""
    text = json.dumps({"top": tree})
    if max((text[:n].count("[") - text[:n].count("]")) for n in range(len(text))) < MAX_DEPTH - 4:
        found = parse(text.encode(), "x.yaml").plain()
        assert found == {"top": tree}


def test_line_numbers_are_those_of_an_editor() -> None:
    tree = parse(b"# comment\na:\n  b: 1\n  c:\n    - 2\n    - d: 3\n", "x").value
    assert isinstance(tree, dict)
    inner = tree["a"].value
    assert isinstance(inner, dict)
    assert (tree["a"].key_line, inner["b"].line, inner["c"].key_line) == (2, 3, 4)
    items = inner["c"].value
    assert isinstance(items, list)
    assert [item.line for item in items] == [5, 6]


def test_numbers_are_finite_after_reading(tmp_path: Path) -> None:
    vehicle = load_vehicle(write(tmp_path, GOOD))
    assert math.isfinite(vehicle.water.gravity_mps2)


def test_a_file_of_another_kind_is_said_to_be_one(tmp_path: Path) -> None:
    """A parameter file of another program is no vehicle file with many faults."""
    other = "\n".join(f"motor_{number}: {{gain: 1.0}}" for number in range(12))
    with pytest.raises(InputError) as refused:
        load_vehicle(write(tmp_path, f"name: mmt300\n{other}\n"))
    problem = refused.value.problem
    assert "12 of its 13 keys do not belong here (motor_0, motor_1" in problem.what
    assert "thrusters" in problem.expected
