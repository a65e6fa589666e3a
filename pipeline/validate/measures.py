"""What is measured of a flight."""

import numpy as np

from pipeline.control.allocation import at_limit
from pipeline.physics.parameters import read
from pipeline.records.validation import KeepingFlight, StepFlight, Variant
from pipeline.simulate.applied_wrench import settled_thrust
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.validate.flight import AXIS_ROWS, Flight, effective_codes, wrench_of
from pipeline.validate.power import PowerModel

#: Below this share of the range nothing worth a ratio was wanted on an axis (rms).
LEAST_WANTED = 0.01
#: A thruster that pushes against a slower flow than this is not counted as opposed. [m/s]
OPPOSED_MPS = 0.1
#: A demand is cut on an axis when this share of the range is missing.
_CUT = 1e-3


def keeping(
    packed: PackedVehicle,
    variant: Variant,
    flight: Flight,
    *,
    range_n_nm: FloatArray,
    power: PowerModel | None,
) -> KeepingFlight:
    """Errors, cuts and power of one flight by a variant, "ideal", "mooring" or "compensated".

    `range_n_nm` (4,) is the largest surge, heave, pitch, yaw at this speed, 0 where there is none
    [N, N m]; `power` is given where the bench knows it.
    """
    error = flight.reference - flight.motion
    rms = np.sqrt(np.mean(error**2, axis=0))
    last = flight.motion[-(len(flight.motion) // 3) :, 0]
    base = {
        "variant": variant,
        "speed_mps": flight.course.speed_mps,
        "reached_mps": float(last.mean()),
        "speed_error_mps": float(rms[0]),
        "depth_error_m": float(rms[1]),
        "heading_error_deg": float(np.degrees(rms[2])),
        "pitch_error_deg": float(np.degrees(rms[3])),
    }
    if variant == "ideal":
        return KeepingFlight.model_validate(base)
    wanted = wrench_of(packed, flight.wanted_n)
    given = wrench_of(packed, settled_thrust(packed, flight.codes, flight.inflow_mps))
    demanded = flight.demand[:, AXIS_ROWS]
    missing = np.abs(demanded - wanted) > _CUT * np.where(range_n_nm > 0.0, range_n_nm, np.inf)
    ends = at_limit(flight.codes, *packed.code_limits.T)
    opposed = np.sign(flight.codes) * flight.inflow_mps < -OPPOSED_MPS
    shaft, electrical = (None, None)
    if power is not None:
        at_blades = flight.inflow_mps * read(packed.vector, "inflow_fraction")[: len(opposed[0])]
        shaft, electrical = power.means(effective_codes(packed, flight), at_blades)
    return KeepingFlight.model_validate(
        base
        | {
            "wrench_error": tuple(_share(given - wanted, range_n_nm).tolist()),
            "wrench_gain": tuple(
                _gain(given[:, i], wanted[:, i], float(range_n_nm[i])) for i in range(4)
            ),
            "cut_share": float(flight.cut.mean()),
            "cut_surge_share": float((flight.cut & missing[:, 0]).mean()),
            "code_end_share": float(ends.any(axis=1).mean()),
            "largest_code": float(np.abs(flight.codes).max(initial=0.0)),
            "opposed_share": float(opposed.any(axis=1).mean()),
            "thrust_power_w": float((flight.thrust_n * flight.inflow_mps).sum(axis=1).mean()),
            "shaft_power_w": shaft,
            "electrical_power_w": electrical,
        }
    )


def _share(error: FloatArray, range_n_nm: FloatArray) -> FloatArray:
    """Root mean square (4,) as a share of the range, 0 where there is none."""
    rms = np.sqrt(np.mean(error**2, axis=0))
    return np.divide(rms, range_n_nm, out=np.zeros(4), where=range_n_nm > 0.0)


def _gain(given: FloatArray, wanted: FloatArray, available: float) -> float | None:
    power = float(np.mean(wanted**2))
    if available <= 0.0 or power < (LEAST_WANTED * available) ** 2:
        return None
    return float(np.mean(given * wanted) / power)


def stepping(
    packed: PackedVehicle,
    variant: Variant,
    flight: Flight,
    *,
    without: Flight,
    ideal: Flight,
    range_n_nm: FloatArray,
) -> StepFlight:
    """Say what a step did to the channels that were not stepped; arguments as of `keeping`.

    `flight` is with the step, `without` the same without it, `ideal` the step with ideal thrusters.
    """
    heading = flight.course.heading_rad != 0.0
    off = np.abs(flight.motion - without.motion).max(axis=0)
    own = 2 if heading else 1
    off[own] = np.abs(flight.motion[:, own] - ideal.motion[:, own]).max()
    wrench: tuple[float, ...] = ()
    if variant != "ideal":
        more = _settled_error(packed, flight) - _settled_error(packed, without)
        size = np.abs(more).max(axis=0)
        share = np.divide(size, range_n_nm, out=np.zeros(4), where=range_n_nm > 0.0)
        wrench = tuple(share.tolist())
    return StepFlight(
        variant=variant,
        speed_at_mps=flight.course.speed_mps,
        step="heading" if heading else "depth",
        speed_mps=float(off[0]),
        depth_m=float(off[1]),
        heading_deg=float(np.degrees(off[2])),
        pitch_deg=float(np.degrees(off[3])),
        wrench=wrench,
        cut_share=float(flight.cut.mean()),
    )


def _settled_error(packed: PackedVehicle, flight: Flight) -> FloatArray:
    given = settled_thrust(packed, flight.codes, flight.inflow_mps)
    return wrench_of(packed, given - flight.wanted_n)
