"""What the notes of a run say of the vehicle, as the simulation takes it.

The same for `simulate --run`, `identify`, `diagnose` and the run pages: one reading of the notes,
from which a flight takes payload events, orders of the winch and what the vehicle carries, and a
fit the conditions of each stretch of time.
"""

import math
from dataclasses import dataclass, replace

from pipeline.errors import CannotComputeError
from pipeline.records.pool_run import BallastItem, RunNotes
from pipeline.records.run_table import AS_STATED, Conditions, KnownBody
from pipeline.simulate.events import PayloadEvent, checked_events
from pipeline.simulate.pack_hull import vector_under
from pipeline.simulate.tethered_mover import WinchOrder
from pipeline.types import FloatArray
from pipeline.vehicle.attachment_schema import Payload, Tether
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vehicle

#: Densities nearer than this are one. [kg/m^3]
_SAME_DENSITY = 1e-6
#: As many segments as a vehicle file may state.
_MOST_SEGMENTS = 200


@dataclass(frozen=True)
class RunSetup:
    """A vehicle as it was in a run.

    `model` is that of the vehicle file with the modules on board at the start and the tether of the
    day (None, or not in the nominal model, where none is simulated). `events`, `orders` and
    `ballast` (from a time on, put on then) come by time of the log, from its start [s]. `notes` say
    what of the notes could not be taken.
    """

    stated: Model
    model: Model
    density_kgpm3: float | None
    gravity_mps2: float
    ballast: tuple[tuple[float, KnownBody], ...] = ()
    events: tuple[PayloadEvent, ...] = ()
    orders: tuple[WinchOrder, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def times_s(self) -> tuple[float, ...]:
        """When something begins to hold, from 0 on."""
        later = {time_s for time_s, _ in self.ballast} | {event.time_s for event in self.events}
        return tuple(sorted({0.0, *later}))

    def carried(self, time_s: float) -> Conditions:
        """Return ballast and water at a time, modules left out. [s]."""
        bodies = tuple(body for from_s, body in self.ballast if from_s <= time_s + 1e-9)
        if not bodies and self.density_kgpm3 is None:
            return AS_STATED
        return Conditions(bodies, self.density_kgpm3, self.gravity_mps2)

    def conditions(self, time_s: float) -> Conditions:
        """Return all by which the vehicle differs from its file at a time, modules too. [s]."""
        on_board = {one.name for one in self.model.payloads if one.attached}
        for event in self.events:
            if event.time_s <= time_s + 1e-9:
                change = set.add if event.action == "attach" else set.discard
                change(on_board, event.module)
        modules = tuple(
            module_body(one, 1.0 if one.name in on_board else -1.0)
            for one in self.stated.payloads
            if one.attached != (one.name in on_board)
        )
        known = self.carried(time_s)
        if not modules and known.as_stated:
            return AS_STATED
        return Conditions((*modules, *known.bodies), self.density_kgpm3, self.gravity_mps2)

    def later(self, by_s: float) -> "RunSetup":
        """Count times from a begin that is `by_s` earlier; what came before is there at 0. [s]."""
        return replace(
            self,
            ballast=tuple((max(at + by_s, 0.0), body) for at, body in self.ballast),
            events=tuple(replace(e, time_s=max(e.time_s + by_s, 0.0)) for e in self.events),
            orders=tuple(replace(o, time_s=max(o.time_s + by_s, 0.0)) for o in self.orders),
        )

    def checked(self, vector: FloatArray) -> None:
        """Refuse ballast with which nothing of the vehicle's mass or buoyancy is left.

        Raises
        ------
        CannotComputeError
            Naming the ballast.
        """
        for time_s in self.times_s:
            vector_under(self.conditions(time_s), vector)


def run_setup(vehicle: Vehicle, model: Model, notes: RunNotes | None) -> RunSetup:
    """Read what the notes of a run, if any, say of its vehicle.

    Raises
    ------
    CannotComputeError
        For modules that the vehicle has not, and events that cannot happen.
    """
    gravity = vehicle.water.gravity_mps2
    if notes is None:
        return RunSetup(model, model, None, gravity)
    told: list[str] = []
    density = None if notes.water is None else notes.water.density_kgpm3
    stated_density = vehicle.water.density_kgpm3
    if density is not None and abs(density - stated_density) < _SAME_DENSITY:
        density = None
    of_water = stated_density if density is None else density
    items = [(0.0, one) for one in notes.ballast]
    items += [(one.at_s, one.ballast) for one in notes.events if one.ballast is not None]
    ballast = [
        (from_s, body)
        for from_s, item in items
        if (body := _body(item, model, of_water, told)) is not None
    ]
    of_the_day = _with_modules(model, notes)
    of_the_day = of_the_day.model_copy(update={"tether": _tether(model, notes, told)})
    moved = [PayloadEvent(e.at_s, "attach", e.attach) for e in notes.events if e.attach is not None]
    moved += [
        PayloadEvent(e.at_s, "release", e.release) for e in notes.events if e.release is not None
    ]
    try:
        events = checked_events(moved, of_the_day, vehicle.name)
    except CannotComputeError as error:
        raise CannotComputeError(f"{notes.file or 'the notes of the run'}: {error}") from None
    orders = tuple(
        WinchOrder(one.at_s, one.winch_mps)
        for one in sorted(notes.events, key=lambda one: one.at_s)
        if one.winch_mps is not None
    )
    tether = of_the_day.tether
    if orders and (tether is None or not tether.in_nominal or tether.winch is None):
        told.append("the winch of the events is left out: the vehicle file has no tether with one.")
        orders = ()
    return RunSetup(
        model,
        of_the_day,
        density,
        gravity,
        tuple(sorted(ballast, key=lambda one: one[0])),
        tuple(events),
        orders,
        tuple(f"{notes.file or 'notes of the run'}: {text}" for text in told),
    )


def module_body(payload: Payload, sign: float) -> KnownBody:
    """Return a module that is put on (1) or taken off (-1) as a body."""
    xx, yy, zz = payload.inertia_kgm2
    return KnownBody(
        payload.name,
        sign * payload.mass_kg,
        sign * payload.volume_m3,
        payload.position_m,
        (sign * xx, sign * yy, sign * zz),
    )


def _body(
    item: BallastItem, model: Model, density_kgpm3: float, told: list[str]
) -> KnownBody | None:
    """Return ballast as a body; None, with the reason told, where too little of it is known."""
    volume = item.volume_m3
    if volume is None and item.displaced_kg is not None:
        volume = item.displaced_kg / density_kgpm3
    if volume is None:
        if item.mass_kg != 0.0:
            told.append(
                f'ballast "{item.what}" is shown and not simulated: displaced_kg (or volume_m3) '
                "says what it weighs in water, 0 inside the hull."
            )
        return None
    if item.mass_kg == 0.0 and volume == 0.0:
        return None
    place = item.position_m
    if place is None:
        place = model.rigid_body.centre_of_mass_m
        told.append(
            f'ballast "{item.what}" has no position_m and is taken to sit at the centre of mass: '
            "its trim is not simulated."
        )
    return KnownBody(f'ballast "{item.what}"', item.mass_kg, volume, place)


def _with_modules(model: Model, notes: RunNotes) -> Model:
    """Return the model with the modules on board that the notes name."""
    if notes.payloads is None:
        return model
    known = [one.name for one in model.payloads]
    unknown = [name for name in notes.payloads if name not in known]
    if unknown:
        raise CannotComputeError(
            f"{notes.file or 'the notes of the run'}: payloads: the vehicle has no module "
            f"{', '.join(unknown)}; model.payloads of its file has {', '.join(known) or 'none'}."
        )
    payloads = [
        one.model_copy(update={"attached": one.name in notes.payloads}) for one in model.payloads
    ]
    return model.model_copy(update={"payloads": tuple(payloads)})


def _tether(model: Model, notes: RunNotes, told: list[str]) -> Tether | None:
    """Return the tether of the day; None where there was none."""
    section, said = model.tether, notes.tether
    if said is None:
        return section
    if not said.attached:
        return None
    if section is None:
        told.append(
            "a tether was attached and is not simulated: the vehicle file has no model.tether "
            "that says what it is like."
        )
        return None
    length = said.paid_out_m or section.length_m
    segments = section.segments
    if section.winch is not None:
        # its drum takes whole segments: two of them must be left where it stops
        segments = max(segments, math.ceil(2.0 * length / section.winch.shortest_m))
    segments = min(segments, _MOST_SEGMENTS)
    changes = {"in_nominal": True, "length_m": length, "segments": segments}
    return section.model_copy(update=changes)
