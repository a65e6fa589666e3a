"""The weak vehicle flown before and after `rig2sea apply`: ``python -m evaluation.weak_thruster``.

The upper thruster of `mmt300` gives 0.69 of its thrust. The same course under the same disturbance
is flown by the allocator of the vehicle file as it was, and of the file with the finding in it;
what the thrusters give less what the allocator meant is its error.
"""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pipeline.inputs.simulated_vehicle import load_inverse, load_simulated
from pipeline.provenance import read_envelope
from pipeline.records.fits import InverseCharacteristic, StaticCharacteristic
from pipeline.simulate.applied_wrench import levers
from pipeline.simulate.context import BenchModel
from pipeline.simulate.pack import pack_vehicle
from pipeline.types import FloatArray
from pipeline.validate import plan
from pipeline.validate.closed_loop import ClosedLoop
from pipeline.validate.flight import Course, Flight, fly_course
from pipeline.vehicle.schema import Vehicle

WEAK, SHARE = "upper", 0.69
SPEED_MPS, DURATION_S = 1.0, 20.0


@dataclass(frozen=True)
class Flown:
    """One flight: the error of the wrench over time, (k, 6), and its root mean square."""

    flight: Flight
    error: FloatArray

    @property
    def rms(self) -> FloatArray:
        """(6,) [N], [N m]."""
        return np.asarray(np.sqrt(np.mean(self.error**2, axis=0)))


def corrected(vehicle: Vehicle, share: float = SHARE) -> Vehicle:
    """Return what `rig2sea apply` makes of the vehicle file."""
    gains = {"gain_ahead": share, "gain_reverse": share}
    every = [t.model_copy(update=gains if t.name == WEAK else {}) for t in vehicle.thrusters]
    return vehicle.model_copy(update={"thrusters": tuple(every)})


def fly_all(
    vehicle: Vehicle, bench: BenchModel, inverse: InverseCharacteristic
) -> Mapping[str, Flown]:
    """Fly the sound vehicle, the weak one as the file was, and the weak one with it corrected."""
    sound = ClosedLoop.of(vehicle, pack_vehicle(vehicle, bench), inverse, None)
    right = ClosedLoop.of(
        corrected(vehicle), pack_vehicle(corrected(vehicle), bench), inverse, None
    )
    matrix = levers(sound.packed)
    course = Course(
        SPEED_MPS, DURATION_S, plan.disturbance(sound.amplitude), roll_rad=sound.roll_rad
    )
    found = {}
    for name, truth, member in (
        ("sound", sound, sound),
        ("weak, file as it was", right, sound),
        ("weak, file corrected", right, right),
    ):
        flight = fly_course(truth.packed, member.member("compensated"), course)
        found[name] = Flown(flight, (flight.thrust_n - flight.wanted_n) @ matrix.T)
    return found


def table(flown: Mapping[str, Flown]) -> str:
    """Return the table of the docs."""
    lines = ["| flight | X [N] | M [N m] | depth [m] |", "|---|---|---|---|"]
    for name, one in flown.items():
        depth = one.flight.motion[:, 1] - one.flight.reference[:, 1]
        off = float(np.sqrt(np.mean(depth**2)))
        lines.append(f"| {name} | {one.rms[0]:.2f} | {one.rms[4]:.2f} | {off:.3f} |")
    return "\n".join(lines)


def draw(flown: Mapping[str, Flown], path: Path) -> None:
    """Draw the error of the pitch moment over time."""
    figure = Figure(figsize=(7.0, 2.6), layout="constrained")
    axes = figure.subplots()
    for name, one in flown.items():
        axes.plot(one.flight.time_s, one.error[:, 4], label=name, linewidth=1.2)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("M given less meant [N m]")
    axes.legend(fontsize="small")
    figure.savefig(path, metadata={"Date": None})


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly with the results of a working folder, print the table, draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=Path, help="the picture")
    to = parser.parse_args(arguments).to
    here = Path()
    one = load_simulated("mmt300", here / "raw", here)
    inverse = load_inverse("mmt300", here)
    static = read_envelope(
        here / "processed/mmt300/static.json", "static", StaticCharacteristic
    ).record
    flown = fly_all(one.vehicle, BenchModel(static, family=inverse.family), inverse)
    print(table(flown))
    if to is not None:
        draw(flown, to)


if __name__ == "__main__":
    main()
