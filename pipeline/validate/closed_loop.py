"""The vehicle, everyone who flies it, and the flights that they fly."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pipeline.control.autopilot import Autopilot
from pipeline.control.inverse import firmware_grid
from pipeline.control.paper_allocator import (
    corrections_of,
    inflow_of_velocity,
    other_inverses,
    rest_inverse,
)
from pipeline.errors import CannotComputeError
from pipeline.records.fits import InverseCharacteristic
from pipeline.records.validation import KeepingFlight, PortionFlight, StepFlight, Variant
from pipeline.simulate.context import model_of
from pipeline.simulate.fly import CodeAllocator, autopilot_for
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.validate import plan
from pipeline.validate.controllers import Controllers, general_controllers, paper_controllers
from pipeline.validate.flight import AXIS_ROWS, Course, Flight, fly_course
from pipeline.validate.measures import keeping, stepping
from pipeline.validate.power import PowerModel
from pipeline.vehicle.model_schema import FromBollard
from pipeline.vehicle.schema import Allocator, Vehicle

VARIANTS: tuple[Variant, ...] = ("ideal", "mooring", "compensated")


@dataclass(frozen=True)
class ClosedLoop:
    """The vehicle, everyone who flies it, and what is the same for all flights."""

    packed: PackedVehicle
    controllers: Controllers
    autopilot: Autopilot
    power: PowerModel | None
    speeds: tuple[float, ...]
    ranges: dict[float, FloatArray]
    amplitude: FloatArray
    roll_rad: float | None
    geometry: Allocator | None
    portions: tuple[float, ...]
    explanations: tuple[str, ...]

    @classmethod
    def of(
        cls,
        vehicle: Vehicle,
        packed: PackedVehicle,
        inverse: InverseCharacteristic | None,
        power: PowerModel | None,
        others: Mapping[str, InverseCharacteristic] = MappingProxyType({}),
    ) -> "ClosedLoop":
        """Choose allocator, speeds and disturbance of a vehicle.

        Parameters as `validate_allocator` takes them.
        """
        calm = plan.calm_vehicle(packed)
        model = model_of(vehicle)
        bollard = any(
            isinstance(model.thrusters[t.drive].characteristic, FromBollard)
            for t in vehicle.thrusters
        )
        texts: list[str] = []
        geometry: Allocator | None
        if vehicle.allocator is not None and not bollard and inverse is not None:
            flow, own = inflow_of_velocity(vehicle), corrections_of(vehicle)
            beside = (
                other_inverses(vehicle, others, rest_inverse),
                other_inverses(vehicle, others, lambda record, _: firmware_grid(record)),
            )
            moored = rest_inverse(inverse, vehicle)
            controllers = paper_controllers(
                calm, vehicle.allocator, inverse, flow, own, moored=moored, others=beside
            )
            portions = vehicle.allocator.portions
            shares: tuple[float, ...] = (portions.surge, portions.heading, portions.pitch)
            geometry = vehicle.allocator
            texts.append(
                "The inflow of a thruster is its own speed along its axis, V cos(delta) straight "
                "ahead for a stern one, and the allocator takes it there. Told V_x, as in the "
                "paper, it asks for more code than is needed; the table of settings shows that "
                "flight."
            )
        else:
            controllers, shares, geometry = general_controllers(calm), (), None
            texts.append(
                "Flown by the general allocator (pseudo-inverse): portions, Tables 3 and 4 and "
                "the firmware grid play no part."
            )
        if not model.terms.thrust_falls_with_speed:
            texts.append(
                "The model of vehicle.yaml leaves out that thrust falls with speed "
                "(thrust_falls_with_speed: false). It is flown here with thrust that falls as its "
                "characteristic says, or there would be nothing to compensate."
            )
        if model.pool is not None:
            texts.append("The walls of the pool are left out of these flights.")
        texts += _without_reverse(calm, by_paper=geometry is not None)
        speeds = speeds_to_fly(vehicle, calm, controllers, bollard=bollard)
        full = {v: plan.axis_range(calm, controllers.thrust_of_wrench, v) for v in speeds}
        top = full[speeds[-1]]
        autopilot = autopilot_for(calm)
        return cls(
            packed=calm,
            controllers=controllers,
            autopilot=autopilot,
            power=power,
            speeds=speeds,
            ranges={v: one[list(AXIS_ROWS)] for v, one in full.items()},
            amplitude=plan.push(autopilot.design, top[list(AXIS_ROWS)]),
            roll_rad=0.0 if top[3] > 0.0 else None,
            geometry=geometry,
            portions=shares,
            explanations=(*controllers.explanations, *texts),
        )

    def member(self, name: Variant) -> CodeAllocator | None:
        """Who flies a variant; nobody where the thrusters are ideal."""
        if name == "ideal":
            return None
        return self.controllers.mooring if name == "mooring" else self.controllers.compensated

    def fly(self, member: CodeAllocator | None, speed_mps: float) -> Flight:
        """Keep course, depth and speed against the disturbance."""
        course = Course(
            speed_mps, plan.KEEPING_S, plan.disturbance(self.amplitude), roll_rad=self.roll_rad
        )
        return fly_course(self.packed, member, course)

    def step(
        self,
        member: CodeAllocator | None,
        speed_mps: float,
        *,
        heading_deg: float = 0.0,
        depth_m: float = 0.0,
    ) -> Flight:
        """Step, undisturbed; with no step at all the flight to compare with."""
        course = Course(
            speed_mps,
            plan.STEP_FLIGHT_S,
            plan.calm,
            heading_rad=float(np.radians(heading_deg)),
            depth_m=depth_m,
            step_s=plan.STEP_AT_S,
            roll_rad=self.roll_rad,
        )
        return fly_course(self.packed, member, course)

    def keeping(self, name: Variant, flight: Flight) -> KeepingFlight:
        """Measure a keeping flight."""
        return keeping(
            self.packed,
            name,
            flight,
            range_n_nm=self.ranges[flight.course.speed_mps],
            power=self.power,
        )

    def steps(self, speed_mps: float) -> list[StepFlight]:
        """Both steps with every variant at a speed."""
        out = []
        holds = {name: self.step(self.member(name), speed_mps) for name in VARIANTS}
        for heading, depth in ((plan.HEADING_STEP_DEG, 0.0), (0.0, plan.DEPTH_STEP_M)):
            flown = {
                name: self.step(self.member(name), speed_mps, heading_deg=heading, depth_m=depth)
                for name in VARIANTS
            }
            out += [
                stepping(
                    self.packed,
                    name,
                    flown[name],
                    without=holds[name],
                    ideal=flown["ideal"],
                    range_n_nm=self.ranges[speed_mps],
                )
                for name in VARIANTS
            ]
        return out

    def portioned(self, speed_mps: float) -> list[PortionFlight]:
        """Other portions: keeping, and a large turn."""
        out = []
        for portions, member in self.controllers.portioned:
            turn = self.step(member, speed_mps, heading_deg=plan.LARGE_STEP_DEG)
            out.append(
                PortionFlight(
                    surge=portions.surge,
                    heading=portions.heading,
                    pitch=portions.pitch,
                    flight=self.keeping("compensated", self.fly(member, speed_mps)),
                    heading_step_cut_share=float(turn.cut.mean()),
                    heading_step_reached_deg=float(np.degrees(turn.motion[:, 2].max())),
                )
            )
        return out


def _without_reverse(packed: PackedVehicle, *, by_paper: bool) -> list[str]:
    """Say what becomes of demands of reverse thrust where a thruster gives none."""
    without = plan.thrust_limits(packed, 0.0)[1] <= 0.0
    if not without.any():
        return []
    who = "No thruster gives reverse thrust"
    if not without.all():
        names = zip(packed.thruster_names, without.tolist(), strict=True)
        listed = ", ".join(name for name, lacks in names if lacks)
        who = f"These thrusters give no reverse thrust: {listed}"
    if by_paper:
        return [
            (
                f"{who}. Moments that need one to push back are out of reach, and demands of them "
                "count as cut. The autopilot stops its integrals while a demand is cut, so speed "
                "errors are partly its doing."
            )
        ]
    return [
        (
            f"{who}. What a demand asks of them in reverse is left out by both allocators alike: "
            "the others give their own share, and what is missing shows in the error of the "
            "force, not among the demands cut."
        )
    ]


def speeds_to_fly(
    vehicle: Vehicle, packed: PackedVehicle, controllers: Controllers, *, bollard: bool
) -> tuple[float, ...]:
    """Speeds of the tables, or shares of what the vehicle can keep. [m/s]."""
    stated = tuple(sorted(vehicle.tables.speed_mps))
    if len(stated) > 1 and not bollard:
        return stated
    fastest = plan.fastest_kept_mps(packed, controllers.thrust_of_wrench)
    if fastest < 0.1:
        if lacking := plan.without_needed_reverse(packed, controllers.thrust_of_wrench):
            raise CannotComputeError(
                f"Surge ahead and nothing else needs reverse thrust of {', '.join(lacking)}, but "
                "their drives give none: the allocator can keep no speed. If they turn both ways, "
                "state a negative code_min under drives."
            )
        raise CannotComputeError(
            "The thrusters make no surge force along the x axis: there is no speed to keep."
        )
    return tuple(round(share * fastest, 2) for share in plan.SPEED_SHARES)
