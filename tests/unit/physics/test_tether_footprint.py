"""Tables 2 to 4 of Kostenko and Mokeeva 2009, honestly: what follows and what does not."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.physics.tether_cable import Cable
from pipeline.physics.tether_footprint import (
    VARIANTS,
    Footprint,
    Variant,
    footprint_cable,
    largest_pull,
    ned_from_paper,
    paper_from_ned,
)
from pipeline.physics.tether_static import solve_tether

#: Table 4 as printed: largest |T_x|, |T_y|, |T_z|, |T| at the vehicle. [N]
PRINTED_TABLE_4_N = (166.0, 132.0, 107.0, 213.0)
#: Table 3 as printed: angle [deg]; at the garage T_x, T_y, T_z, |T|; at the vehicle the same. [N]
PRINTED_TABLE_3 = (
    (0, -142, 23, -23, 146, -112, 76, -76, 155),
    (30, -77, 10, -2, 78, -70, 41, -40, 90),
    (60, -36, 3, 15, 39, -43, 24, -22, 54),
    (90, -42, 8, 49, 65, -64, 35, -29, 79),
    (120, -61, 20, 113, 130, -116, 67, -43, 141),
    (150, -95, 28, 159, 187, -159, 103, -44, 195),
    (180, -133, 25, 158, 208, -166, 127, -39, 213),
    (210, -153, 18, 123, 197, -144, 132, -42, 200),
    (240, -164, 14, 86, 186, -122, 130, -58, 188),
    (270, -184, 17, 56, 193, -118, 132, -83, 196),
    (300, -205, 24, 21, 208, -128, 129, -107, 211),
    (330, -194, 28, -14, 197, -133, 110, -105, 202),
)
PRINTED = np.array(PRINTED_TABLE_3, float)
#: Pull at the vehicle by a second, separate solution of the same equations. [N]
SECOND_SOLUTION = {
    "paper": [110, 78, 57, 72, 104, 128, 135, 128, 122, 126, 134, 132],
    "uniform": [210, 138, 91, 123, 195, 251, 268, 254, 241, 250, 267, 259],
}


ANGLES = tuple(range(0, 360, 30))


def pulls(
    footprint: Footprint, variant: Variant, angles: Sequence[float] = ANGLES
) -> tuple[np.ndarray, np.ndarray]:
    """Force of the cable on vehicle and garage (n, 3), in the paper's frame. [N]"""
    cables = [footprint_cable(footprint, variant, angle) for angle in angles]
    ends = [(one.force_on_start_n, one.force_on_end_n) for one in cables]
    on_vehicle, on_garage = paper_from_ned(np.array(ends)).swapaxes(0, 1)
    return on_vehicle, on_garage


def out_of_plane_n(footprint: Footprint, angle: float, force: np.ndarray) -> float:
    """Return the part of a force across the plane of the flow and the vehicle's place. [N]"""
    flow = np.array(footprint.current_mps) - np.array(footprint.vehicle_velocity_mps)
    normal = np.cross(flow, footprint.position_m(angle))
    return float(force @ normal / np.linalg.norm(normal))


@pytest.mark.parametrize("variant", ["paper", "uniform"])
def test_pull_at_the_vehicle_equals_a_second_solution(variant: Variant) -> None:
    size = np.linalg.norm(pulls(Footprint(), variant)[0], axis=1)
    assert size == pytest.approx(SECOND_SOLUTION[variant], abs=1.0)


def test_printed_pull_lies_between_the_readings_at_eleven_of_twelve_angles() -> None:
    """At 60 deg the paper prints 54 N, less than either."""
    footprint = Footprint()
    low = np.linalg.norm(pulls(footprint, "paper")[0], axis=1)
    high = np.linalg.norm(pulls(footprint, "uniform")[0], axis=1)
    between = (low < PRINTED[:, 8]) & (PRINTED[:, 8] < high)
    assert np.flatnonzero(~between).tolist() == [2]


def test_method_page_holds_the_computed_table() -> None:
    """docs/methods/tether.md: angle, |T_a| printed and of each reading, |T_n| likewise."""
    page = Path(__file__).parents[3] / "docs" / "methods" / "tether.md"
    cells = [line.strip("| ").split("|") for line in page.read_text("utf-8").splitlines()]
    rows = np.array([r for r in cells if len(r) == 9 and r[0].strip().isdigit()], float)
    assert rows[:, [0, 1, 5]] == pytest.approx(PRINTED[:, [0, 8, 4]])
    variants: tuple[Variant, ...] = ("paper", "vector", "uniform")
    for column, variant in enumerate(variants, start=2):
        sizes = [np.linalg.norm(force, axis=1) for force in pulls(Footprint(), variant)]
        assert rows[:, column] == pytest.approx(sizes[0], abs=0.51)
        assert rows[:, column + 4] == pytest.approx(sizes[1], abs=0.51)


def pull_with_fall(angle_deg: float, fall_mps: float) -> float:
    """Return |T_a| if the flow, of one direction, falls by a given speed towards the garage."""
    footprint = Footprint()
    flow = ned_from_paper(np.array([-1.0, 0.5, -0.5]))
    speed = float(np.linalg.norm(flow))
    vehicle = ned_from_paper(footprint.position_m(angle_deg))
    ahead = flow / speed
    ordinate = vehicle - (vehicle @ ahead) * ahead

    def field(position: np.ndarray) -> np.ndarray:
        share = position @ ordinate / (ordinate @ ordinate)
        return ahead * (speed - fall_mps * (1 - share[:, None]))

    solved = solve_tether(
        footprint.cable, start_m=vehicle, end_m=np.zeros(3), flow=field, density_kgpm3=1025.0
    )
    return float(solved.tension_size_n[0])


@pytest.mark.parametrize(("angle", "fall"), [(0, 0.41), (90, 0.69), (180, 0.295)])
def test_no_one_fall_of_the_flow_explains_the_printed_pull(angle: int, fall: float) -> None:
    """The fall that would meet the printed |T_a| differs from angle to angle."""
    printed = PRINTED[angle // 30, 8]
    assert pull_with_fall(angle, fall) == pytest.approx(printed, rel=5e-3)


def test_at_60_deg_the_flow_would_have_to_fall_by_more_than_the_vehicles_own_speed() -> None:
    own_speed = float(np.linalg.norm(Footprint().vehicle_velocity_mps))
    sizes = [pull_with_fall(60.0, fall) for fall in np.linspace(0.0, own_speed, 6)]
    assert (np.diff(sizes) < 0).all()
    assert sizes[-1] > 54.0 > pull_with_fall(60.0, 1.1)


def test_printed_pull_at_the_vehicle_lies_in_the_plane_and_at_the_garage_mostly_not() -> None:
    footprint = Footprint()
    at_vehicle = [abs(out_of_plane_n(footprint, row[0], row[5:8])) for row in PRINTED]
    at_garage = [abs(out_of_plane_n(footprint, row[0], row[1:4])) for row in PRINTED]
    assert max(at_vehicle) < 1.5  # rounding of whole newtons
    assert sum(force > 10 for force in at_garage) == 11


@pytest.mark.parametrize("variant", ["paper", "uniform"])
def test_our_pulls_stay_in_the_plane_of_the_flow(variant: Variant) -> None:
    footprint = Footprint()
    for angle, a, b in zip(ANGLES, *pulls(footprint, variant), strict=True):
        assert abs(out_of_plane_n(footprint, angle, a)) < 1e-3
        assert abs(out_of_plane_n(footprint, angle, b)) < 1e-3


def test_vector_reading_leaves_the_plane() -> None:
    footprint = Footprint()
    _, on_garage = pulls(footprint, "vector", [90.0])
    assert abs(out_of_plane_n(footprint, 90.0, on_garage[0])) > 1.0


@pytest.mark.parametrize("variant", VARIANTS)
def test_without_own_speed_all_readings_are_one(variant: Variant) -> None:
    still = Footprint(vehicle_velocity_mps=(0.0, 0.0, 0.0))
    pull, _ = pulls(still, variant, [0.0, 120.0])
    assert pull == pytest.approx(pulls(still, "uniform", [0.0, 120.0])[0], abs=1e-6)


def test_frames_are_a_rotation_with_y_up_turned_to_down() -> None:
    axes = ned_from_paper(np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert ned_from_paper(np.array([0.0, -50.0, 0.0])).tolist() == [0.0, 0.0, 50.0]
    assert paper_from_ned(axes) == pytest.approx(np.eye(3))


def test_vehicle_is_dragged_with_the_flow_and_up() -> None:
    """The flow past the vehicle is (-1, 0.5, -0.5): so are the signs of nearly all pulls."""
    pull, _ = pulls(Footprint(), "paper")
    assert (pull[:, 0] < 0).all()
    assert (pull[:, 1] > 0).all()
    assert (np.sign(PRINTED[:, 5:7]) == [-1, 1]).all()


def test_short_cable_is_refused() -> None:
    message = r"^Footprint at angle 0 deg, radius 50 m: .*60 m long.*70\.7107 m apart"
    with pytest.raises(CannotComputeError, match=message):
        footprint_cable(Footprint(cable=Cable(60.0, 0.014, 1.8, 0.025)), "paper", 0.0)


def test_table_4_follows_from_table_3() -> None:
    assert largest_pull(PRINTED[:, 5:8]) == pytest.approx(PRINTED_TABLE_4_N, abs=0.7)
