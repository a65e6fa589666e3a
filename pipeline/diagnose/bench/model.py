"""What the thruster model says of a mooring test: thrust, shaft speed, current, voltage at rest."""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.cubic_inverse import mooring_curve, points_for_tables
from pipeline.records.fits import StaticCharacteristic
from pipeline.records.measurements import MooringPoint, MooringRecord
from pipeline.types import ArrayLike, FloatArray
from pipeline.vehicle.schema import Vehicle

#: Channels of a mooring table with their units, in the order of the answer.
UNITS = {"thrust": "N", "shaft_speed": "rpm", "current": "A", "voltage": "V"}
#: What two mooring tests of one healthy thruster may differ by in shape, of the largest thrust.
REPEATABILITY = 0.01
#: Share of the codes, below the largest, that the continuation beyond it is taken from.
_LAST = 0.15
_GRID = 401


@dataclass(frozen=True)
class ReferenceCurve:
    """One channel against the signed code: knots of shape (m,), rising in code.

    `std` is the standard error of the model, smooth along the code.
    """

    code: FloatArray
    value: FloatArray
    std: FloatArray
    level: bool = False
    """True for a channel that does not vanish at code 0 (voltage): clamped outside the knots."""

    def at(self, code: ArrayLike) -> FloatArray:
        """Value at signed codes; beyond the outermost knots along a power of the code.

        A supply above that of the model turns the drive faster than any code did; y ~ |N|^p with p
        from the last codes is what a propeller at rest does (thrust 2, shaft speed 1, current 3).
        """
        codes = np.asarray(code, float)
        inside = np.asarray(np.interp(codes, self.code, self.value))
        if self.level:
            return inside
        for end, sign in ((-1, 1.0), (0, -1.0)):
            last = float(self.code[end])
            beyond = sign * codes > sign * last
            if sign * last <= 0.0 or not beyond.any():
                continue
            before = last * (1.0 - _LAST)
            low = float(np.interp(before, self.code, self.value))
            high = float(self.value[end])
            power = np.log(high / low) / -np.log1p(-_LAST) if high * low > 0.0 else 1.0
            inside[beyond] = high * (codes[beyond] / last) ** power
        return inside

    def std_at(self, code: ArrayLike) -> FloatArray:
        """Return the standard error at signed codes, clamped to the knots."""
        return np.asarray(np.interp(np.asarray(code, float), self.code, self.std))


@dataclass(frozen=True)
class ThrusterAtRest:
    """One thruster of a vehicle at rest.

    `thrust` is always there; `mirrored` tells that one direction was measured and the other is
    its mirror image; `repeatability` is the share of the largest thrust by which another test of
    a healthy thruster may differ in shape.
    """

    name: str
    thrusters: tuple[str, ...]
    code_max: float
    channels: dict[str, ReferenceCurve]
    mirrored: bool
    repeatability: float
    source: str

    @property
    def thrust_max_n(self) -> float:
        """Largest size of thrust [N]."""
        return float(np.abs(self.channels["thrust"].value).max())


def bench_model(
    vehicle: Vehicle, static: StaticCharacteristic | None, mooring: MooringRecord | None
) -> ThrusterAtRest:
    """Gather what the vehicle's results say of a thruster at rest.

    Parameters
    ----------
    vehicle : Vehicle
        Codes, supply voltage, names.
    static : StaticCharacteristic or None
        The calculated family; its row at rest is the model where there is one, as in simulation.
    mooring : MooringRecord or None
        The vehicle's own mooring tests: the model where there is no family, and the source of
        shaft speed, current and voltage.

    Returns
    -------
    ThrusterAtRest

    Raises
    ------
    CannotComputeError
        When there is neither, or the mooring data carry no characteristic.
    """
    points: tuple[MooringPoint, ...] = ()
    if mooring is not None:
        try:
            points = points_for_tables(mooring, vehicle)
        except CannotComputeError:
            if static is None:
                raise
    if static is None and not points:
        raise CannotComputeError(
            f"{vehicle.name} has no thruster model: neither a static characteristic (open_water/ "
            "and load_test/) nor a mooring test of its own (mooring/). A new table can only be "
            f"judged against one. Put the data there and run `rig2sea run {vehicle.name}`."
        )
    channels = {"thrust": _from_points(points) if static is None else _from_family(static)}
    repeatability = REPEATABILITY
    if static is not None and points:
        # Its own mooring test shows how far the calculation is from what such a test reads.
        gap = [p.thrust_n - float(channels["thrust"].at(p.code)) for p in points]
        largest = float(np.abs(channels["thrust"].value).max())
        repeatability = max(repeatability, float(np.sqrt(np.mean(np.square(gap)))) / largest)
    channels |= _other_channels(points, vehicle)
    if static is not None and "shaft_speed" not in channels:
        row = np.array(static.shaft_speed_rpm[0])
        channels["shaft_speed"] = _mirrored(np.array(static.code), row, 0.01 * row)
    return ThrusterAtRest(
        name=vehicle.name,
        thrusters=tuple(one.name for one in vehicle.thrusters),
        code_max=float(vehicle.drive.code_max),
        channels=channels,
        mirrored=static is not None,
        repeatability=repeatability,
        source="the static characteristic at rest" if static is not None else "the mooring test",
    )


def _mirrored(code: FloatArray, value: FloatArray, std: FloatArray) -> ReferenceCurve:
    zero = np.zeros(1)
    return ReferenceCurve(
        np.concatenate([-code[::-1], zero, code]),
        np.concatenate([-value[::-1], zero, value]),
        np.concatenate([std[::-1], zero, std]),
    )


def _from_family(static: StaticCharacteristic) -> ReferenceCurve:
    met = np.array([status != "no_working_point" for status in static.status[0]])
    code, thrust = np.array(static.code)[met], np.array(static.thrust_n[0])[met]
    return _mirrored(code, np.maximum(thrust, 0.0), np.array(static.thrust_std_n[0])[met])


def _from_points(points: tuple[MooringPoint, ...]) -> ReferenceCurve:
    """Curve of each sign through the mooring points; the scatter about it is its error."""
    branches = []
    for sign in (-1, 1):
        curve = mooring_curve(points, sign)
        code = np.linspace(0.0, float(curve.code[-1]), _GRID)[1:]
        used = [p for p in points if sign * p.code > 0]
        gap = [abs(p.thrust_n) - float(curve.thrust(abs(p.code))) for p in used]
        std = np.full(code.size, float(np.sqrt(np.mean(np.square(gap)))) / np.sqrt(2.0))
        branches.append((sign * code, sign * curve.thrust(code), std))
    (nc, nv, ns), (pc, pv, ps) = branches
    zero = np.zeros(1)
    return ReferenceCurve(
        np.concatenate([nc[::-1], zero, pc]),
        np.concatenate([nv[::-1], zero, pv]),
        np.concatenate([ns[::-1], zero, ps]),
    )


def _other_channels(
    points: tuple[MooringPoint, ...], vehicle: Vehicle
) -> dict[str, ReferenceCurve]:
    """Shaft speed, current and voltage as the vehicle's own mooring tests read them, by code."""
    found: dict[str, ReferenceCurve] = {}
    for channel, field in (
        ("shaft_speed", "shaft_speed_rpm"),
        ("current", "current_a"),
        ("voltage", "voltage_v"),
    ):
        read = [(p.code, getattr(p, field)) for p in points if getattr(p, field) is not None]
        codes = np.unique([code for code, _ in read])
        if codes.size < 4 or codes.min() >= 0.0 or codes.max() <= 0.0:
            continue
        mean = np.array([np.mean([value for at, value in read if at == code]) for code in codes])
        level = channel == "voltage"
        if not level:
            if not np.abs(mean).max() > 0.0:
                continue
            keep = codes != 0.0
            middle = int(np.searchsorted(codes[keep], 0.0))
            codes, mean = (
                np.insert(codes[keep], middle, 0.0),
                np.insert(mean[keep], middle, 0.0),
            )
        found[channel] = ReferenceCurve(codes, mean, np.zeros(codes.size), level=level)
    stated = vehicle.tables.supply_voltage_v
    if "voltage" not in found and stated is not None:
        ends = np.array([vehicle.drive.code_min, vehicle.drive.code_max], float)
        found["voltage"] = ReferenceCurve(ends, np.full(2, stated), np.zeros(2), level=True)
    return found
