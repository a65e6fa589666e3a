"""A tether of lumped masses: its description, its state, and what a run of it gives.

It hangs at rest and moves with the vehicle in `tethered`; the equations are in
`kernel_tether`.
"""

from dataclasses import dataclass, fields

import numpy as np

from pipeline.types import FloatArray
from pipeline.vehicle.attachment_schema import Tether


@dataclass(frozen=True)
class LumpedMassTether:
    """A cable cut into segments, and the water it is in; checked where the vehicle file is.

    `length_m` is paid out at the start [m], in `segments` whose length stays: a winch changes their
    number. Drag coefficients C_n, C_t are referred to the diameter; `axial_stiffness_n` is EA [N];
    `density_kgpm3` of the water, 0 for a vacuum; `added_mass` C_a across the cable, 1 for a
    cylinder in unbounded water; `axial_damping` the damping ratio of the shortest axial wave, two
    segments long: longer waves are damped less, in proportion to their frequency.
    """

    length_m: float
    segments: int
    diameter_m: float
    mass_kgpm: float
    normal_drag: float
    tangential_drag: float
    axial_stiffness_n: float
    density_kgpm3: float
    gravity_mps2: float
    added_mass: float = 1.0
    axial_damping: float = 0.5

    @property
    def segment_m(self) -> float:
        """Unstretched length of a segment. [m]."""
        return self.length_m / self.segments

    @property
    def wet_weight_npm(self) -> float:
        """Weight less buoyancy of a metre; negative floats. [N/m]."""
        section = np.pi / 4 * self.diameter_m**2
        return float(self.gravity_mps2 * (self.mass_kgpm - self.density_kgpm3 * section))

    @property
    def wave_speed_mps(self) -> float:
        """Speed of an axial wave, (EA / m)^(1/2). [m/s]."""
        return float(np.sqrt(self.axial_stiffness_n / self.mass_kgpm))

    def numbers(self, current_mps: FloatArray) -> FloatArray:
        """Return the kernel's vector for this cable in a current (3,)."""
        half = 0.5 * self.density_kgpm3 * self.diameter_m
        section = np.pi / 4 * self.diameter_m**2
        return np.array(
            [
                self.mass_kgpm,
                self.wet_weight_npm,
                half * self.normal_drag,
                half * self.tangential_drag,
                self.axial_stiffness_n,
                self.axial_damping * np.sqrt(self.axial_stiffness_n * self.mass_kgpm),
                self.added_mass * self.density_kgpm3 * section,
                self.segment_m,
                *current_mps,
            ]
        )


def lumped_tether(tether: Tether, *, density_kgpm3: float, gravity_mps2: float) -> LumpedMassTether:
    """Return the lumped cable of a vehicle file's tether section, whose mass is in air."""
    # named as in the file, but for the water and what the file does not state
    own = {one.name for one in fields(LumpedMassTether)}
    stated = tether.model_dump(include=own)
    return LumpedMassTether(**stated, density_kgpm3=density_kgpm3, gravity_mps2=gravity_mps2)


@dataclass(frozen=True)
class TetherState:
    """Where a tether is and how it moves; n segments in use, from the top down.

    Nodes at `position_ned_m` with `velocity_ned_mps` (n + 1, 3) [m, m/s], segments of unstretched
    lengths `rest_length_m` (n,) [m]; `drum_speed_radps` of the winch, positive pays out [rad/s];
    `owed_m` was put off when a node was taken out, and is given back within seconds [m].
    """

    position_ned_m: FloatArray
    velocity_ned_mps: FloatArray
    rest_length_m: FloatArray
    drum_speed_radps: float = 0.0
    owed_m: float = 0.0

    @property
    def paid_out_m(self) -> float:
        """Unstretched length between winch and vehicle. [m]."""
        return float(self.rest_length_m.sum() + self.owed_m)


@dataclass(frozen=True)
class TetherHistory:
    """A tether's run, sampled at every step, m + 1 samples.

    Nodes beyond those in use are NaN; with a winch the top stays node 0 and the lower end is node
    ``segments[k]``. `position_ned_m` (m + 1, nodes, 3) [m]; `tension_n` (m + 1, nodes - 1) of the
    segments [N]; `force_on_top_ned_n`, `force_below_ned_n` (m + 1, 3) of the cable on the bodies at
    its ends, tension with weight and drag of the half segment, without its inertia [N];
    `wrench_on_vehicle` (m + 1, 6) all that the tether does to the vehicle, inertia of the half
    segment included, body axes, about the body origin, zeros without a vehicle [N, N m]; `segments`
    in use, `paid_out_m`, `drum_speed_radps`, and `substeps` of the step that begins at the sample,
    (m + 1,). `final` is to go on from.
    """

    time_s: FloatArray
    position_ned_m: FloatArray
    tension_n: FloatArray
    force_on_top_ned_n: FloatArray
    force_below_ned_n: FloatArray
    wrench_on_vehicle: FloatArray
    segments: FloatArray
    paid_out_m: FloatArray
    drum_speed_radps: FloatArray
    substeps: FloatArray
    final: TetherState

    @property
    def top_tension_n(self) -> FloatArray:
        """Tension of the top segment, shape (m + 1,). [N]."""
        return np.asarray(self.tension_n[:, 0], dtype=float)

    @property
    def lower_tension_n(self) -> FloatArray:
        """Tension of the lowest segment, shape (m + 1,). [N]."""
        rows = np.arange(len(self.time_s))
        return np.asarray(self.tension_n[rows, self.segments.astype(int) - 1], dtype=float)
