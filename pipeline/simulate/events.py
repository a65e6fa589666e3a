r"""Payload modules that are attached and released in flight.

Between events the vehicle is one rigid body with the modules on board: mass, centre of mass,
inertia about the origin, weight, buoyancy and its centre are packed anew at each event.

Release. The module leaves with the velocity that it has as a part of the vehicle. The latch only
lets go: it pushes neither of the two, so neither velocity jumps, and the momentum of both together
stays. What changes is the acceleration: weight, buoyancy and inertia of the module are gone.

Attachment. The latch is rigid, so both move as one afterwards (inelastic), and the momentum of
both together stays: :math:`(M + M_p)\,\nu^+ = M \nu + M_p \nu_p`, velocities relative to the
water. M holds the added mass of the vehicle: in so short a time the water about the hull moves
with it. The vehicle file gives modules no added mass of their own, so M_p is the dry module.
"""

import difflib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.gripper import HeldPayload, Latch, close_on, latch_reaction
from pipeline.physics.parameters import read
from pipeline.records.run_table import Conditions
from pipeline.simulate.kernel_alone import fill_rotation
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.simulate.pack_hull import vector_under, write_body
from pipeline.simulate.run import Trajectory
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.attachment_schema import Payload
from pipeline.vehicle.model_schema import Model

Action = Literal["attach", "release"]


@dataclass(frozen=True)
class PayloadEvent:
    """A module is attached or released at a time of the run [s]; before it lies still."""

    time_s: float
    action: Action
    module: str


@dataclass(frozen=True)
class EventOutcome:
    """What an event did: the `impulse` (6,) that the latch gave the vehicle [N s, N m s].

    `time_s` is when it happened: an event waits for the run to ask for what is due [s].
    """

    event: PayloadEvent
    time_s: float
    impulse: FloatArray


@dataclass
class PayloadSchedule:
    """Changes state and parameter vector of a run as its events come.

    `true_vector` turns the vector of a vehicle with its modules into the one that is simulated
    (effects switched on); `carried` says what ballast and water make of it at a time, which changes
    at `carried_from_s`; `outcomes` collects what happened.
    """

    packed: PackedVehicle
    model: Model
    events: Sequence[PayloadEvent]
    true_vector: Callable[[FloatArray], FloatArray] = np.copy
    outcomes: list[EventOutcome] = field(default_factory=list)
    carried: Callable[[float], Conditions] | None = None
    carried_from_s: Sequence[float] = ()
    now_s: float = 0.0

    def __post_init__(self) -> None:
        """Refuse events that cannot happen, in the order of time."""
        self.events = checked_events(self.events, self.model, self.packed.name)

    @cached_property
    def _modules(self) -> dict[str, Payload]:
        return {payload.name: payload for payload in self.model.payloads}

    @cached_property
    def _attached(self) -> set[str]:
        return {payload.name for payload in self.model.payloads if payload.attached}

    @property
    def times_s(self) -> tuple[float, ...]:
        """When something changes after the start. [s]."""
        times = {event.time_s for event in self.events} | set(self.carried_from_s)
        return tuple(sorted(times - {0.0} if not self.due(0.0) else times))

    def vector(self) -> FloatArray:
        """Parameter vector that is simulated with what is on board now."""
        vector = self.true_vector(
            vector_with_modules(self.packed, self.model, frozenset(self._attached))
        )
        return vector if self.carried is None else vector_under(self.carried(self.now_s), vector)

    def due(self, until_s: float) -> list[PayloadEvent]:
        """Events up to a time that have not happened yet."""
        return [e for e in self.events[len(self.outcomes) :] if e.time_s <= until_s + 1e-9]

    def change(self, time_s: float, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Let the events up to a time [s] happen; return state and parameter vector from then on.

        `state` is the kernel's and is not changed.
        """
        for event in self.due(time_s):
            # what it carries now was carried before the event, too
            self.now_s = time_s
            state = self._happen(event, time_s, state)
        self.now_s = time_s
        return state, self.vector()

    def _happen(self, event: PayloadEvent, time_s: float, state: FloatArray) -> FloatArray:
        after, impulse = state.copy(), np.zeros(6)
        if event.action == "release":
            self._attached.remove(event.module)
        else:
            before = self.vector()
            rotation = np.empty((3, 3))
            fill_rotation(state, rotation)
            water = np.concatenate([rotation.T @ read(before, "current"), np.zeros(3)])
            held = held_payload(self._modules[event.module])
            common, impulse = close_on(mass_of(before), held, state[7:13] - water, -water)
            after[7:13] = common + water
            self._attached.add(event.module)
        self.outcomes.append(EventOutcome(event, time_s, impulse))
        return after


def checked_events(events: Sequence[PayloadEvent], model: Model, name: str) -> list[PayloadEvent]:
    """Return events, in any order, in the order of time.

    `model` has the modules that are on board at the start; `name` is the vehicle's, for messages.

    Raises
    ------
    CannotComputeError
        For one that cannot happen.
    """
    found = sorted(events, key=lambda event: event.time_s)
    modules = [payload.name for payload in model.payloads]
    on_board = {payload.name for payload in model.payloads if payload.attached}
    for event in found:
        what = f"{event.action} {event.module} at {event.time_s:g} s"
        if event.module not in modules:
            near = difflib.get_close_matches(event.module, modules, n=1)
            hint = f'\nDid you mean "{near[0]}"?' if near else ""
            raise CannotComputeError(
                f"{what}: {name} has no such module; it has {', '.join(modules) or 'none'}.{hint}"
            )
        if not (np.isfinite(event.time_s) and event.time_s >= 0.0):
            raise CannotComputeError(f"{what}: a time from 0 on is expected.")
        if (event.module in on_board) == (event.action == "attach"):
            now = "is already on board" if event.module in on_board else "is not on board"
            raise CannotComputeError(f"{what}: it {now} then.")
        (set.add if event.action == "attach" else set.discard)(on_board, event.module)
    return found


def held_payload(payload: Payload) -> HeldPayload:
    """Return the module of a vehicle file as the gripper holds it."""
    return HeldPayload(payload.mass_kg, payload.volume_m3, payload.position_m, payload.inertia_kgm2)


def vector_with_modules(
    packed: PackedVehicle, model: Model, on_board: frozenset[str]
) -> FloatArray:
    """Return the nominal parameter vector with these modules on board and no other."""
    payloads = tuple(
        payload.model_copy(update={"attached": payload.name in on_board})
        for payload in model.payloads
    )
    vector = packed.vector.copy()
    write_body(
        vector,
        model.model_copy(update={"payloads": payloads}),
        packed.context.gravity_mps2,
        float(read(packed.vector, "density")),
    )
    return vector


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
    """Compute what every latch of the vehicle file carries along a true motion.

    Modules of the model without a latch are passed over. `outcomes` say what was attached and
    released, `vector` is the true one: current and density of the water.
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
        section = payload.latch
        place = payload.position_m if section.position_m is None else section.position_m
        latch = Latch(place, section.strength_n, section.strength_nm, section.closing_s)
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


def _held(payload: Payload, outcomes: Sequence[EventOutcome], time_s: FloatArray) -> BoolArray:
    """Whether a module is on board at each sample; that of an event is the one just after."""
    held = np.full(time_s.shape, payload.attached)
    for one in outcomes:
        if one.event.module == payload.name:
            held[time_s >= one.time_s - 1e-9] = one.event.action == "attach"
    return held
