"""Numbers that say where they are from: read as the number, written with interval and source."""

from pathlib import Path

import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.errors import InputError
from pipeline.records.base import FileChange
from pipeline.vehicle.change_list import listed_changes, text_with
from pipeline.vehicle.estimates import Estimate, estimates_of, with_plain_values
from pipeline.vehicle.load import load_checked, load_vehicle
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.write_back import updated_vehicle_text
from pipeline.vehicle.yaml_text import parse


def rov8_text() -> str:
    found = bundled_vehicle("rov8")
    file = found if found.is_file() else found / "vehicle.yaml"
    return file.read_text(encoding="utf-8")


def test_changes_are_read_back_with_interval_and_source(tmp_path: Path) -> None:
    changes = (
        FileChange(path="thrusters.1.gain_ahead", old=1.0, value=0.69, ci95=(0.63, 0.76)),
        FileChange(path="model.damping.linear.2", old=1.0, value=31.5, ci95=(31.4999999, 40.0)),
        FileChange(path="model.supply.drop", old=0.0, value=0.1),
        *(
            FileChange(path=f"model.current_ned_mps.{axis}", old=0.0, value=value)
            for axis, value in enumerate((0.2, 0.0, -0.1))
        ),
        FileChange(path="sensors.dvl.scale", old=1.0, value=1.02, ci95=(1.01, 1.03)),
    )
    text = text_with(rov8_text(), changes, "diagnosis of a, b", "why")
    file = tmp_path / "vehicle.yaml"
    file.write_text(text, encoding="utf-8")
    vehicle = load_vehicle(file)
    assert vehicle.model is not None
    assert vehicle.sensors is not None
    assert vehicle.sensors.dvl is not None
    assert vehicle.thrusters[1].gain_ahead == 0.69
    assert vehicle.model.damping.linear[2] == 31.5
    assert vehicle.model.supply.drop == 0.1
    assert vehicle.model.current_ned_mps == (0.2, 0.0, -0.1)
    assert vehicle.sensors.dvl.scale == 1.02
    stated = estimates_of(file)
    assert stated["thrusters.1.gain_ahead"].ci95 == (0.63, 0.76)
    assert stated["model.damping.linear.2"].ci95 == (31.5, 40.0)
    assert {one.source for one in stated.values()} == {"diagnosis of a, b"}
    # once more over it: the estimate is replaced, nothing else moves
    again = text_with(text, changes[:1], "diagnosis of c")
    assert again == text.replace(
        'ci95: [0.63, 0.76], from: "diagnosis of a, b"',
        'ci95: [0.63, 0.76], from: "diagnosis of c"',
    )


def test_an_estimate_in_block_style_is_replaced_whole() -> None:
    text = "a:\n  b:\n    value: 1.0\n    from: me\n  # stays\n  c: 2\n"
    new = updated_vehicle_text(text, {"a.b": Estimate(2.0, (1.0, 3.0), "x")}, "")
    assert parse(new.encode(), "a.yaml").plain() == {
        "a": {"b": {"value": 2.0, "ci95": [1.0, 3.0], "from": "x"}, "c": 2}
    }
    assert "  # stays\n  c: 2\n" in new


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: {value: x, from: y}", "a: its value is no number"),
        ("a: {value: 1, ci95: [2, 3]}", "the interval 2 to 3 does not hold 1"),
        ("a: {value: 1, ci95: 3}", "a: ci95 is no pair of numbers"),
        ("a: {value: 1, from: 3}", "a: from is no text"),
    ],
)
def test_what_is_no_estimate_is_refused_at_its_line(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as error:
        with_plain_values(parse(f"b: 1\n{text}".encode(), "a.yaml"), "a.yaml")
    assert "row 2" in str(error.value)


def test_intervals_of_keys_are_those_of_the_parameters(tmp_path: Path) -> None:
    file = tmp_path / "vehicle.yaml"
    file.write_text(rov8_text(), encoding="utf-8")
    vehicle = load_checked(file, Vehicle, expected="", remedy="")
    old = vehicle.sensors.dvl.position_m if vehicle.sensors and vehicle.sensors.dvl else None
    assert old is not None
    key, x = "sensors.dvl.position_m", old[0]
    changes = {key: (x + 0.2, *old[1:]), "model.supply.drop": 0.2}
    first = ({key: (x + 0.17, *old[1:])}, {key: (x + 0.23, *old[1:])})
    second = (
        changes | {key: (x + 0.16, *old[1:])},
        changes | {key: (x + 0.24, *old[1:]), "model.supply.drop": 0.3},
    )
    found = {one.path: one for one in listed_changes(vehicle, changes, (first, second))}
    assert set(found) == {f"{key}.0", "model.supply.drop"}
    assert found[f"{key}.0"].ci95 == pytest.approx((x + 0.15, x + 0.25))
    assert found["model.supply.drop"].ci95 == pytest.approx((0.0, 0.3))
