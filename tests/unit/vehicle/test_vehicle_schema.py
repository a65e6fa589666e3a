"""What the vehicle's models refuse, and what they notice about the geometry."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from pipeline.vehicle.notes import vehicle_notes
from pipeline.vehicle.schema import Vehicle


def description(delta_deg: float = 22.5, stern_arm_m: float = 1.1) -> dict[str, Any]:
    """Four inclined thrusters on the axis and a bow one, as in fig. 8 of the paper."""
    delta = math.radians(delta_deg)
    c, s = math.cos(delta), math.sin(delta)
    directions = {
        "upper": (c, 0.0, -s),
        "lower": (c, 0.0, s),
        "left": (c, -s, 0.0),
        "right": (c, s, 0.0),
        "bow": (0.0, 0.0, -1.0),
    }
    return {
        "name": "v",
        "title": "",
        "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.81},
        "propellers": {"p": {"diameter_m": 0.2}},
        "drives": {"d": {"code_min": -127, "code_max": 127}},
        "thrusters": tuple(
            {
                "name": name,
                "propeller": "p",
                "drive": "d",
                "position_m": (1.0 if name == "bow" else -stern_arm_m, 0.0, 0.0),
                "direction": direction,
            }
            for name, direction in directions.items()
        ),
        "allocator": {
            "delta_deg": delta_deg,
            "stern_arm_m": stern_arm_m,
            "bow_arm_m": 1.0,
            "portions": {"surge": 0.5, "heading": 0.5, "pitch": 0.5},
            **{name: name for name in directions},
        },
        "tables": {"propeller": "p", "drive": "d"},
    }


def changed(index: int, **values: object) -> dict[str, Any]:
    tree = description()
    thrusters = list(tree["thrusters"])
    thrusters[index] = thrusters[index] | values
    return tree | {"thrusters": tuple(thrusters)}


def notes(tree: dict[str, Any]) -> tuple[str, ...]:
    return vehicle_notes(Vehicle.model_validate(tree))


@given(st.floats(5, 85), st.floats(0.1, 10))
def test_the_geometry_of_the_paper_agrees_with_itself(delta_deg: float, arm_m: float) -> None:
    assert notes(description(delta_deg, arm_m)) == ()


def test_no_allocator_no_notes() -> None:
    assert notes(description() | {"allocator": None}) == ()


@pytest.mark.parametrize(
    ("index", "role"), tuple(enumerate(("upper", "lower", "left", "right", "bow")))
)
def test_a_reversed_thruster_is_noticed(index: int, role: str) -> None:
    direction = tuple(-part for part in description()["thrusters"][index]["direction"])
    (note,) = notes(changed(index, direction=direction))
    assert note.startswith(f"thruster {role} ({role}): direction is 180.0 deg away")
    assert "check the sign" in note


def test_upper_and_lower_swapped_is_noticed() -> None:
    tree = description()
    tree["allocator"] |= {"upper": "lower", "lower": "upper"}
    assert [note.split(":")[0] for note in notes(tree)] == [
        "thruster lower (upper)",
        "thruster upper (lower)",
    ]
    assert "45.0 deg away" in notes(tree)[0]


def test_wrong_angle_and_wrong_arm_are_noticed() -> None:
    tree = description()
    tree["allocator"]["delta_deg"] = 20.0
    assert all("2.5 deg away" in note for note in notes(tree))
    assert len(notes(tree)) == 4
    (note,) = notes(changed(3, position_m=(-0.9, 0.0, 0.0)))
    assert "yaw arm of 0.900 m, allocator.stern_arm_m is 1.1 m" in note
    (note,) = notes(changed(4, position_m=(0.8, 0.0, 0.0)))
    assert "pitch arm of 0.800 m, allocator.bow_arm_m is 1 m" in note


def test_an_offset_from_the_axis_counts_into_the_arm() -> None:
    """Upper thruster 0.1 m above the axis: its surge share pitches the nose down as well."""
    delta = math.radians(22.5)
    (note,) = notes(changed(0, position_m=(-1.1, 0.0, -0.1)))
    assert f"pitch arm of {1.1 + 0.1 / math.tan(delta):.3f} m" in note


def test_roll_is_noticed() -> None:
    (note,) = notes(changed(0, position_m=(-1.1, 0.2, 0.0)))
    assert "roll moment of -0.077 N m per newton" in note


def test_other_notes() -> None:
    tree = description()
    tree["propellers"]["q"] = {"diameter_m": 0.1}
    thrusters = list(tree["thrusters"])
    thrusters[4] = thrusters[4] | {"propeller": "q"}
    tree["thrusters"] = tuple(thrusters)
    tree["allocator"] |= {"bow": None}
    found = notes(tree)
    assert found[0].startswith("thruster bow has propeller q and drive d; the tables are computed")
    assert found[1] == "allocator: it does not use the thrusters bow."
    tree["allocator"] |= {"bow": "bow", "bow_arm_m": None, "left": "right"}
    found = notes(tree)
    assert "allocator: thruster right is named for left, right; each needs its own." in found
    assert any("no bow_arm_m" in note for note in found)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"thrusters": description()["thrusters"][:1] * 2}, '"upper" is there twice'),
        ({"tables": {"propeller": "x", "drive": "d"}}, 'no propeller "x"; propellers has p'),
        ({"tables": {"propeller": "p", "drive": "x"}}, 'no drive "x"; drives has d'),
        ({"thrusters": ()}, 'no thruster "upper"; thrusters has none'),
        ({"tables": {"propeller": "p", "drive": "d", "speed_mps": (0.5, 1.0)}}, "must start at 0"),
        ({"tables": {"propeller": "p", "drive": "d", "speed_mps": (0.0, 0.0)}}, "must start at 0"),
        ({"surprise": 1}, "Extra inputs"),
        (
            {
                "published": {
                    "source": "",
                    "table2": {"speed_mps": (0, 1), "KF0": (1, 2), "KF1": (1,), "KF2": (1, 2)},
                }
            },
            "KF1 has 1 entries, speed_mps has 2",
        ),
        (
            {
                "published": {
                    "source": "",
                    "table4": dict.fromkeys(("T_max_n", "KN0", "KN1", "KN2", "KN3"), (1, 2))
                    | {"speed_mps": (0,)},
                }
            },
            "T_max_n has 2 entries, speed_mps has 1",
        ),
    ],
)
def test_what_does_not_fit_is_refused(change: dict[str, Any], expected: str) -> None:
    with pytest.raises(ValidationError, match=expected):
        Vehicle.model_validate(description() | change)


@given(st.floats(0.01, 1), st.floats(0.01, 1))
def test_portions_share_a_thruster(surge: float, heading: float) -> None:
    tree = description()
    tree["allocator"]["portions"] = {"surge": surge, "heading": heading, "pitch": 0.001}
    if surge + heading > 1.001:
        with pytest.raises(ValidationError, match="surge \\+ heading"):
            Vehicle.model_validate(tree)
    elif surge + heading <= 0.999:
        Vehicle.model_validate(tree)


def test_frozen() -> None:
    vehicle = Vehicle.model_validate(description())
    with pytest.raises(ValidationError):
        vehicle.water.density_kgpm3 = 1.0  # type: ignore[misc]
