"""The ``pool:`` section: what it accepts, and what it says of faults."""

from pathlib import Path

import pytest

from pipeline.errors import InputError
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

HEAD = """\
name: small
title: small
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {screw: {diameter_m: 0.14}}
drives: {motor: {code_min: -127, code_max: 127}}
tables: {propeller: screw, drive: motor}
thrusters:
  - {name: bow, propeller: screw, drive: motor, position_m: [0, 0, 0], direction: [1, 0, 0]}
pool:
  channels:
"""


def load(tmp_path: Path, *channels: str) -> Vehicle:
    lines = "".join(f"    - {{{channel}}}\n" for channel in channels)
    (tmp_path / "vehicle.yaml").write_text(HEAD + lines, encoding="utf-8")
    return load_vehicle(tmp_path)


def test_one_value_stands_for_a_list(tmp_path: Path) -> None:
    vehicle = load(
        tmp_path,
        'quantity: angular_velocity, topic: /a, field: "data[0:3]", sign: -1, index: 2',
        "quantity: position, topic: /b, field: [x, y, z], sign: [1, -1, 1], index: [2, 1, 0]",
    )
    first, second = vehicle.pool.channels
    assert (first.field, first.sign, first.index) == (("data[0:3]",), (-1,), (2,))
    assert (second.field, second.sign) == (("x", "y", "z"), (1, -1, 1))


def test_without_the_section_everything_is_default(tmp_path: Path) -> None:
    (tmp_path / "vehicle.yaml").write_text(HEAD.split("pool:", maxsplit=1)[0], encoding="utf-8")
    pool = load_vehicle(tmp_path).pool
    assert pool.defaults
    assert pool.channels == ()


@pytest.mark.parametrize(
    ("channel", "says"),
    [
        ("quantity: depht, topic: /a", "Expected one of thruster_command, shaft_speed"),
        ("quantity: depth", 'key "topic" is missing'),
        ("quantity: depth, topic: /a, unit: rpm", '"rpm" is not a unit of depth; it has m, dm'),
        ('quantity: depth, topic: /a, field: "a[1"', '"a[1" is not the path of a field'),
        ('quantity: depth, topic: /a, field: "a[3:3]"', "a range such as data[1:4] must rise"),
        ('quantity: depth, topic: /a, field: "a[0:101].b[0:100]"', "more than 10000 elements"),
        (
            'quantity: depth, topic: /a, clock_field: "t[0:2]", clock_unit: s',
            "names several elements; a time is one number",
        ),
        ("quantity: velocity, topic: /a, sign: [1, -1]", "sign has 2 entries, velocity has 3"),
        ("quantity: depth, topic: /a, thrusters: [bow]", "does not belong to thrusters"),
        ("quantity: shaft_speed, topic: /a, thrusters: [stern]", 'there is no thruster "stern"'),
        ("quantity: depth, topic: /a, clock_field: t", "clock_field and clock_unit go together"),
        ("quantity: depth, topic: /a, clock: gps", "Expected one of header, log"),
        ("quantity: depth, topic: /a, lowest: 1, highest: 1", "lowest must be below highest"),
        ("quantity: depth, topic: /a, felt: 1", 'unknown key "felt"'),
    ],
)
def test_faults_are_named_with_their_line(tmp_path: Path, channel: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        load(tmp_path, channel)
    assert says in str(caught.value)
    assert "row 11" in str(caught.value)
