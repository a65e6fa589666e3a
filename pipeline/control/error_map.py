"""Wrench error of the allocator over demand and speed, without and with speed compensation.

The paper's thesis in numbers: with the mooring inverse the thrusters give less and less of what is
asked as the vehicle gathers speed; with N(T, V) they give it.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.control.allocation import (
    Demand,
    ThrustLimits,
    demanded_channels,
    limited_channels,
    within_reach,
)
from pipeline.control.inverse import Inverse, firmware_grid
from pipeline.control.paper_allocator import rest_inverse
from pipeline.control.real_thrust import RealThruster
from pipeline.errors import CannotComputeError
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.records.validation import AllocationMap, SpeedError
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Allocator, Vehicle

#: Demands on each axis of the grid.
SURGE_DEMANDS, MOMENT_DEMANDS = 41, 21


@dataclass(frozen=True)
class DemandGrid:
    """Demands on the three axes, SNAME: shapes (s,), (p,), (y,). [N], [N m]."""

    surge_n: FloatArray
    pitch_nm: FloatArray
    yaw_nm: FloatArray

    def open(self) -> Demand:
        """Return the axes shaped to broadcast to (s, p, y)."""
        return Demand(
            self.surge_n[:, None, None], self.pitch_nm[None, :, None], self.yaw_nm[None, None, :]
        )


def demand_grid(allocator: Allocator, rest: ThrustLimits) -> DemandGrid:
    """Demands up to what the form can ask at rest: Pi T_max in "limit", T_max in "scaled".

    Surge has a reach of its own for each sign, as it has a limit; a moment needs both signs of
    thrust at once. An axis without any reach has the one demand zero. `rest` are T_max at rest. [N]
    """
    delta = np.radians(allocator.delta_deg)
    full = allocator.form == "scaled"
    portions = allocator.portions
    moment = 2.0 * np.sin(delta) * allocator.stern_arm_m * rest.both_n
    surge = 4.0 * np.cos(delta) * (1.0 if full else portions.surge)
    pitch = moment * (1.0 if full else portions.pitch)
    yaw = moment * (1.0 if full else portions.heading)
    return DemandGrid(
        _axis(-surge * rest.reverse_n, surge * rest.forward_n, SURGE_DEMANDS),
        _axis(-pitch, pitch, MOMENT_DEMANDS),
        _axis(-yaw, yaw, MOMENT_DEMANDS),
    )


def _axis(least: float, largest: float, count: int) -> FloatArray:
    """Return `count` demands from end to end, zero among them, as even as that allows."""
    if largest <= least:
        return np.zeros(1)
    below = round((count - 1) * -least / (largest - least))
    below = min(max(below, int(least < 0.0)), count - 1 - int(largest > 0.0))
    negative = np.linspace(least, 0.0, below + 1)[:-1]
    return np.concatenate([negative, np.linspace(0.0, largest, count - below)])


#: Spacing of the map's speeds. [m/s]
SPEED_STEP_MPS = 0.1

_COMPONENTS = ("surge", "pitch", "yaw")


@dataclass(frozen=True)
class _Setting:
    allocator: Allocator
    thruster: RealThruster
    thrust_dead_n: float


def allocation_map(
    vehicle: Vehicle,
    inverse: InverseCharacteristic,
    static: StaticCharacteristic,
) -> AllocationMap:
    r"""Compare what is asked with what the thrusters give: one score per speed and variant.

    For every speed and every demand (X, M, N) of a fixed grid: eq. (6) gives the wanted thrusts,
    an inverse characteristic the codes, the static family T(N, V) the real thrusts and eq. (5) the
    real wrench. The grid spans what the chosen form can ask at rest, in surge each way as far as
    that goes; the same demands are given to both variants.

    Without Table 3 the mooring variant uses the row at rest of the firmware grid; `static` is the
    real thruster where `inverse` has no family in which measurements have a part.

    Raises
    ------
    CannotComputeError
        Without an allocator in the vehicle file, or without the compensated inverse.
    """
    if vehicle.allocator is None:
        raise CannotComputeError(
            "The allocator's error map needs the geometry of the stern thrusters: the vehicle file "
            "has no section 'allocator'."
        )
    allocator, dead = vehicle.allocator, vehicle.tables.thrust_dead_n
    thruster = (
        RealThruster.from_record(static)
        if inverse.family is None
        else RealThruster.from_family(inverse.family)
    )
    compensated: Inverse = firmware_grid(inverse)
    mooring = rest_inverse(inverse, vehicle)
    setting = _Setting(allocator, thruster, dead)
    rest = compensated.limits(0.0)
    grid = demand_grid(allocator, rest)
    speeds = map_speeds(vehicle.tables.speed_mps)

    def scores(by: Inverse) -> tuple[SpeedError, ...]:
        return tuple(_score(setting, grid, v, by, compensated.limits(v)) for v in speeds)

    return AllocationMap(
        form=allocator.form,
        portions=(
            allocator.portions.surge,
            allocator.portions.heading,
            allocator.portions.pitch,
        ),
        mooring=scores(mooring),
        compensated=scores(compensated),
        speed_mps=tuple(speeds),
        explanations=_explanations(setting, inverse, static, rest),
        mooring_inverse=mooring.name,
        compensated_inverse=compensated.name,
        thrust_dead_n=dead,
    )


def map_speeds(table_speed_mps: tuple[float, ...]) -> list[float]:
    """Every 0.1 m/s up to the last tabulated speed, and the tabulated ones. [m/s].

    >>> map_speeds((0.0, 0.25))
    [0.0, 0.1, 0.2, 0.25]
    """
    steps = int(np.floor(table_speed_mps[-1] / SPEED_STEP_MPS + 1e-9))
    even = np.round(np.arange(steps + 1) * SPEED_STEP_MPS, 9)
    return [float(v) for v in np.unique(np.concatenate([even, np.array(table_speed_mps)]))]


def _wrench(stern: list[FloatArray], allocator: Allocator) -> FloatArray:
    """(X, M, N) of eq. (5) in SNAME axes, shape (s, p, y, 3), from open arrays."""
    upper, lower, left, right = stern
    delta = np.radians(allocator.delta_deg)
    arm = np.sin(delta) * allocator.stern_arm_m
    parts = [
        (upper + lower + left + right) * np.cos(delta),
        -(upper - lower) * arm,
        -(right - left) * arm,
    ]
    return np.stack(np.broadcast_arrays(*parts), axis=-1) + 0.0


def _score(
    setting: _Setting, grid: DemandGrid, speed_mps: float, inverse: Inverse, limits: ThrustLimits
) -> SpeedError:
    """Score one speed; `limits` say what is within reach there, the same for both variants.

    The upper and lower thruster see surge and pitch only, the left and right one surge and yaw
    only: each is evaluated on its two axes, and the sums broadcast to three. Asked and achieved
    (X, M, N) have shape (s, p, y, 3).
    """
    allocator, dead_n = setting.allocator, setting.thrust_dead_n
    demanded = demanded_channels(grid.open(), allocator)
    wanted = limited_channels(demanded, inverse.limits(speed_mps), allocator).stern
    real = [setting.thruster.thrust(inverse.code(t, speed_mps), speed_mps) for t in wanted]
    asked, achieved = _wrench(wanted, allocator), _wrench(real, allocator)
    shape = asked.shape[:-1]

    def any_of(each: list[BoolArray]) -> BoolArray:
        return np.broadcast_to(each[0] | each[1] | each[2] | each[3], shape)

    opposed = any_of([-np.sign(speed_mps) * t > dead_n for t in wanted])
    in_dead_band = any_of([(np.abs(t) <= dead_n) & (np.abs(t) > 1e-12) for t in wanted])
    reachable = np.broadcast_to(within_reach(demanded, limits, allocator), shape)
    delta = np.radians(allocator.delta_deg)
    largest = setting.thruster.thrust_max_n(speed_mps)
    moment = 2.0 * largest * np.sin(delta) * allocator.stern_arm_m
    available = np.array([4.0 * largest * np.cos(delta), moment, moment])
    if largest <= 0.0:
        available = np.full(3, np.inf)  # nothing is within reach; no error to normalise
    error = (achieved - asked) / available
    same_sign = reachable & ~opposed
    scored = same_sign & ~in_dead_band
    size = np.where(scored[..., None], np.abs(error), 0.0)
    s, p, y, component = np.unravel_index(int(np.argmax(size)), size.shape)
    count = int(scored.sum())
    return SpeedError(
        speed_mps=speed_mps,
        worst=float(size.max()),
        rms=float(np.sqrt((size**2).sum() / (3 * count))) if count else 0.0,
        worst_demand=(float(grid.surge_n[s]), float(grid.pitch_nm[p]), float(grid.yaw_nm[y])),
        reachable_share=float(reachable.mean()),
        opposed_share=float((reachable & opposed).mean()),
        worst_component=_COMPONENTS[component],
        worst_asked=tuple(asked[s, p, y].tolist()),
        worst_achieved=tuple(achieved[s, p, y].tolist()),
        worst_with_dead_band=float(np.abs(error[same_sign]).max(initial=0.0)),
        worst_opposed=float(np.abs(error[reachable & opposed]).max(initial=0.0)),
        range_n_nm=tuple(available.tolist()) if largest > 0.0 else (0.0, 0.0, 0.0),
    )


def _explanations(
    setting: _Setting,
    inverse: InverseCharacteristic,
    static: StaticCharacteristic,
    rest: ThrustLimits,
) -> tuple[str, ...]:
    texts = [
        (
            "The inflow of every stern thruster is taken as V_x, as in the paper (along its "
            "inclined axis the speed is V_x cos(delta), "
            f"{100 * (1 - np.cos(np.radians(setting.allocator.delta_deg))):.0f} % less)."
        ),
        (
            f"A wanted thrust of at most {setting.thrust_dead_n:g} N gets code 0 (eqs. 7 and 8); "
            "demands that put a thruster there are scored apart (worst_with_dead_band)."
        ),
        (
            "Thrust against the motion is modelled by the mooring branch; demands that need it are "
            "scored apart (worst_opposed): there the score compares a model with itself."
        ),
    ]
    if rest.reverse_n <= 0.0:
        texts.append(
            "The drive gives no reverse thrust at rest: surge astern, pitch and yaw are not scored "
            "(a moment needs one stern thruster of a pair to push back)."
        )
    unmet = sum(row.count("no_working_point") for row in static.status)
    if unmet:
        texts.append(
            f"The static family has no working point at {unmet} of its nodes; the thrust is taken "
            "as zero there, and an error near them is one of the family, not of the allocator."
        )
    if inverse.table3_positive is None and inverse.table3_negative is None:
        texts.append(
            "There is no mooring test: the variant without compensation uses the row at rest of "
            "the calculated N(T, V)."
        )
    elif inverse.table3_positive is None or inverse.table3_negative is None:
        texts.append("The mooring test covers one sign of thrust; the other is mirrored from it.")
    return tuple(texts)
