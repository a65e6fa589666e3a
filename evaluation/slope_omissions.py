"""What each term that Potapov and Galyaev leave out does to the slope, on simulated runs.

The paper's vehicle, a cylinder of 15 cm radius and 17 cm height in a frame, is simulated with one
term switched on at a time, and the added mass is read from the slope of acceleration against force
as the paper does. These are simulated runs: the paper's own data do not exist, and so does neither
its speed, its course, its force nor the dry mass. Its measured 18.92 kg can therefore not be taken
apart; the table shows how far each omission alone could have moved it, and which way.

    python -m evaluation.slope_omissions

prints the table.

Assumed, as the paper says nothing: a dry mass of the cylinder's and frame's water (neutral), drag
of a short cylinder across the flow (1.1 on its side), a force that swings as two sines, a pool wall
along the course.
"""

from dataclasses import dataclass, field

import numpy as np

from pipeline.effects.effect import EffectContext
from pipeline.identify.smoothing import smooth, smoother_of_bandwidth
from pipeline.identify.straight_line import plain_slope
from pipeline.physics.added_mass_shapes import potapov_galyaev
from pipeline.physics.parameters import neutral_vector, write
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory, initial_state, run
from pipeline.types import FloatArray

RADIUS_M, HEIGHT_M, DENSITY, GRAVITY = 0.15, 0.17, 1000.0, 9.81
#: Assumed: neutral, the frame's tubes weigh what their water does.
MASS_KG = 12.5
#: Assumed: drag coefficient of a short cylinder across the flow, Hoerner 1965.
DRAG_COEFFICIENT = 1.1
DURATION_S, STEP_S, BANDWIDTH_HZ = 40.0, 0.02, 1.0
#: Force: two sines, shares of its largest value and frequencies [Hz].
FORCE = ((0.6, 0.05), (0.4, 0.13))
#: Usual largest force. [N]
LARGEST_N = 3.0
PUBLISHED_KG = 18.92
TRUTH_KG = potapov_galyaev().surge_kg


@dataclass(frozen=True)
class OmissionShift:
    """A term switched on alone: what the slope then says, and how far that is from the truth."""

    term: str
    size: str
    added_mass_kg: float
    shift_kg: float


@dataclass(frozen=True)
class _Case:
    term: str
    size: str
    slots: dict[str, float | FloatArray] = field(default_factory=dict)
    largest_n: float = LARGEST_N
    yaw_rate: float = 0.0
    thrust_arm_m: float = 0.0
    distance_m: float = 0.0


def paper_body(**slots: float | FloatArray) -> PackedVehicle:
    """Build the paper's vehicle without thrusters, drag or residual buoyancy; slots overwrite.

    Axes: x_1 and y_1 in the plane of the frame, z_1 the cylinder's axis, taken as SNAME's z.
    """
    masses = potapov_galyaev()
    surge, heave, tilt = masses.surge_kg, masses.heave_formula_kg, masses.tilt_kgm2
    across = MASS_KG * (3 * RADIUS_M**2 + HEIGHT_M**2) / 12
    vector = neutral_vector()
    values: dict[str, float | FloatArray] = {
        "mass": MASS_KG,
        "inertia": np.diag([across, across, MASS_KG * RADIUS_M**2 / 2]),
        "weight": MASS_KG * GRAVITY,
        "buoyancy": MASS_KG * GRAVITY,
        "centre_of_buoyancy": np.array([0.0, 0.0, -0.02]),
        "added_mass": np.diag([surge, surge, heave, tilt, tilt, 0.0]),
        "density": DENSITY,
    }
    for name, value in (values | slots).items():
        write(vector, name, value)
    return PackedVehicle(
        name="Potapov and Galyaev, simulated",
        vector=vector,
        strips=np.zeros((0, 3)),
        thrust_tables=np.zeros((1, 2, 1, 2)),
        screws=np.array([[1.0, 0, 0, 0, 0, 0, 0, 1.0]]),
        torque_tables=np.zeros((1, 2, 2)),
        steps=np.ones((1, 2)),
        context=EffectContext(
            thruster_names=(),
            thrust_falls_with_speed=False,
            coriolis=True,
            strips=False,
            walls=False,
            gravity_mps2=GRAVITY,
        ),
        code_limits=np.zeros((0, 2)),
    )


def omission_shifts() -> tuple[OmissionShift, ...]:
    """Simulate the cases and read each one's added mass from its slope."""
    return tuple(_shift(case) for case in _cases())


def slope_added_mass(force_n: FloatArray, surge_mps: FloatArray, step_s: float) -> float:
    """Read the added mass [kg] from the slope, noise-free, both sides through one smoother."""
    smoother = smoother_of_bandwidth("moving_average", BANDWIDTH_HZ, step_s)
    impulse = np.concatenate([[0.0], np.cumsum(force_n * step_s)])[: surge_mps.size]
    speed = smooth(surge_mps, smoother)
    push = smooth(impulse, smoother)
    keep = speed.valid
    slope = plain_slope(
        push.derivative[keep],
        speed.derivative[keep],
        np.zeros(int(keep.sum()), int),
        smoother.derivative.size,
    )
    return 1.0 / float(slope.coefficients[0]) - MASS_KG


def _area() -> float:
    return 2 * RADIUS_M * HEIGHT_M


def _cases() -> list[_Case]:
    quadratic = 0.5 * DENSITY * DRAG_COEFFICIENT * _area()
    sway_drag = np.array([0.0, quadratic, 0.0, 0.0, 0.0, 0.0])
    cases = [_Case("none", "thrust and inertia alone")]
    cases += [
        _Case(
            "rotation",
            f"yaw rate {rate:g} rad/s",
            {"quadratic_damping": sway_drag},
            yaw_rate=rate,
        )
        for rate in (0.05, 0.1, 0.2)
    ]
    drag = np.array([quadratic, 0.0, 0.0, 0.0, 0.0, 0.0])
    cases += [
        _Case(
            "drag",
            f"{quadratic:.0f} N s^2/m^2, force up to {force:g} N",
            {"quadratic_damping": drag},
            largest_n=force,
        )
        for force in (0.1, 0.3, 1.0, 3.0)
    ]
    # a force off the centre tilts the body, and its residual weight then pulls along the axis;
    # without rotation terms, which the tilting would bring in as well
    cases += [
        _Case(
            "buoyancy",
            f"{net:+g} N, force 2 cm below the centre",
            {
                "buoyancy": MASS_KG * GRAVITY + net,
                "linear_damping": np.diag([0, 0, 200.0, 1, 1, 1]),
                "coriolis_fraction": 0.0,
            },
            thrust_arm_m=0.02,
        )
        for net in (-4.0, -2.0, 2.0, 4.0)
    ]
    cases += [
        _Case("walls", f"two walls {distance:g} m off", {"wall_strength": 1.0}, distance_m=distance)
        for distance in (1.0, 0.5, 0.3)
    ]
    return cases


def _walls(distance_m: float) -> dict[str, float | FloatArray]:
    points, normals = np.zeros((5, 3)), np.zeros((5, 3))
    points[0], normals[0] = (0.0, distance_m, 0.0), (0.0, -1.0, 0.0)
    points[1], normals[1] = (0.0, 0.0, distance_m), (0.0, 0.0, -1.0)
    return {
        "wall_count": 2.0,
        "wall_radius": RADIUS_M,
        "wall_point": points,
        "wall_normal": normals,
    }


def _force(time_s: FloatArray, largest_n: float) -> FloatArray:
    swing = sum(share * np.sin(2 * np.pi * rate * time_s) for share, rate in FORCE)
    return np.asarray(largest_n * swing)


def _shift(case: _Case) -> OmissionShift:
    slots = dict(case.slots)
    if case.distance_m:
        slots |= _walls(case.distance_m)
    body = paper_body(**slots)
    trajectory = _pushed(body, case)
    force = _force(np.arange(0.0, DURATION_S - STEP_S / 2, STEP_S), case.largest_n)
    added = slope_added_mass(force, trajectory.nu[:, 0], STEP_S)
    return OmissionShift(case.term, case.size, added, added - TRUTH_KG)


def _pushed(body: PackedVehicle, case: _Case) -> Trajectory:
    """Run under the force along x; yaw goes on at its first rate, as nothing damps it."""
    time_s = np.arange(0.0, DURATION_S - STEP_S / 2, STEP_S)
    external = np.zeros((time_s.size, 6))
    external[:, 0] = _force(time_s, case.largest_n)
    # below the centre a forward force lifts the bow: the moment z F about y
    external[:, 4] = case.thrust_arm_m * external[:, 0]
    start = initial_state(nu=(0.0, 0.0, 0.0, 0.0, 0.0, case.yaw_rate))
    return run(body, np.zeros((time_s.size, 0)), dt_s=STEP_S, start=start, external=external)


def main() -> None:
    """Print a line for each case."""
    print("Added mass from the slope with one term switched on at a time, kg:")
    for one in omission_shifts():
        print(f"  {one.term:10} {one.size:42} {one.added_mass_kg:7.2f} ({one.shift_kg:+.2f})")
    print(f"True in these runs: {TRUTH_KG:.2f}; measured in the paper: {PUBLISHED_KG:.2f}.")


if __name__ == "__main__":
    main()
