"""What the gripper's latches carry in a run, and what their closing does.

The wrench of a held module is an inner one: the kernel moves vehicle and module as one body, so it
is computed from the motion afterwards and is not added to it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.physics.gripper import Latch, latch_reaction
from pipeline.physics.parameters import read
from pipeline.simulate.events import EventOutcome, held_payload
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.model_schema import LatchSection, Model, Payload


@dataclass(frozen=True)
class LatchLoad:
    """Wrench of a module on its latch at the k samples at which it is held.

    `time_s` (k,); `wrench` (k, 6) about the body origin, body axes [N, N m]; `share` (k,) of the
    latch's strength. `closing_n`, `closing_share`: largest force of the closings of the run, spread
    over the time of closing; zero where none was.
    """

    module: str
    time_s: FloatArray
    wrench: FloatArray
    share: FloatArray
    closing_n: float = 0.0
    closing_share: float = 0.0

    @property
    def largest_n(self) -> float:
        """Largest force while it is held. [N]."""
        return float(np.linalg.norm(self.wrench[:, :3], axis=1).max(initial=0.0))

    @property
    def largest_share(self) -> float:
        """Largest share of the strength, closings included; above 1 the latch fails."""
        return max(float(self.share.max(initial=0.0)), self.closing_share)


def latch_loads(
    trajectory: Trajectory,
    packed: PackedVehicle,
    model: Model,
    outcomes: Sequence[EventOutcome],
    *,
    vector: FloatArray,
) -> list[LatchLoad]:
    """Compute what every latch of the vehicle file carries.

    Parameters
    ----------
    trajectory : Trajectory
        The true motion.
    packed : PackedVehicle
        The nominal vehicle.
    model : Model
        Its model; modules without a latch are passed over.
    outcomes : sequence of EventOutcome
        What was attached and released.
    vector : ndarray
        The true parameter vector: current and density of the water.
    """
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_quat(trajectory.quaternion[:, [1, 2, 3, 0]])
    water = np.zeros_like(trajectory.nu)
    water[:, :3] = turn.apply(read(vector, "current"), inverse=True)
    rate = trajectory.nu_dot.copy()
    rate[:, :3] += np.cross(trajectory.nu[:, 3:], water[:, :3])
    down = turn.as_matrix()[:, 2, :]
    found = []
    for payload in model.payloads:
        if payload.latch is None:
            continue
        held = _held(payload, outcomes, trajectory.time_s)
        wrench = latch_reaction(
            held_payload(payload),
            nu_relative=(trajectory.nu - water)[held],
            nu_dot_relative=rate[held],
            down_body=down[held],
            gravity_mps2=packed.context.gravity_mps2,
            density_kgpm3=float(read(vector, "density")),
        )
        latch = _latch(payload, payload.latch)
        # a half sine with the impulse: its height is pi / 2 of its mean
        peaks = [
            np.pi / (2.0 * latch.closing_s) * one.impulse
            for one in outcomes
            if one.event.module == payload.name and one.event.action == "attach"
        ]
        found.append(
            LatchLoad(
                payload.name,
                trajectory.time_s[held],
                wrench,
                latch.load_shares(wrench),
                max((float(np.linalg.norm(peak[:3])) for peak in peaks), default=0.0),
                max((latch.load_share(peak) for peak in peaks), default=0.0),
            )
        )
    return found


def _latch(payload: Payload, section: LatchSection) -> Latch:
    place = payload.position_m if section.position_m is None else section.position_m
    return Latch(place, section.strength_n, section.strength_nm, section.closing_s)


def _held(payload: Payload, outcomes: Sequence[EventOutcome], time_s: FloatArray) -> BoolArray:
    """Whether a module is on board at each sample; that of an event is the one just after."""
    held = np.full(time_s.shape, payload.attached)
    for one in outcomes:
        if one.event.module == payload.name:
            held[time_s >= one.time_s - 1e-9] = one.event.action == "attach"
    return held
