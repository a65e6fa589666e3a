"""A vehicle that is flown on its tether, piece by piece: what `fly` and `run_changing` move."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.winch import Winch
from pipeline.simulate.fly import join, stacked
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory
from pipeline.simulate.tether import LumpedMassTether, TetherHistory, TetherState
from pipeline.simulate.tethered import fly_tethered
from pipeline.types import FloatArray
from pipeline.vehicle.attachment_schema import Tether
from pipeline.vehicle.model_schema import Model

#: A longer piece is cut: the shape of the cable at every step takes memory.
_STEPS_AT_A_TIME = 500


@dataclass(frozen=True)
class WinchOrder:
    """From a time on the drum is driven for a speed of the cable; 0 sets its brake.

    `speed_mps` is what the drum makes without load, positive pays out: the pull of the cable makes
    it pay out faster and haul in slower. [s], [m/s]
    """

    time_s: float
    speed_mps: float


@dataclass(frozen=True)
class TetherLog:
    """What a tether did to a vehicle, at every sample of the run, m + 1 samples.

    `wrench_on_vehicle` (m + 1, 6) body axes, about the body origin, inertia of the cable's lower
    end included [N, N m]; `top_tension_n`, `lower_tension_n` of the segments at the upper end and
    at the vehicle [N]; `paid_out_m` [m]; `payout_mps` [m/s].
    """

    time_s: FloatArray
    wrench_on_vehicle: FloatArray
    top_tension_n: FloatArray
    lower_tension_n: FloatArray
    paid_out_m: FloatArray
    payout_mps: FloatArray


@dataclass
class TetheredMover:
    """Moves a vehicle and its tether together; see `Mover`.

    `winch` at the upper end, without it the length stays; `orders` are what it is told, before the
    first it is braked; `state` of the tether now, at rest at first.
    """

    cable: Tether | LumpedMassTether
    winch: Winch | None = None
    orders: Sequence[WinchOrder] = ()
    state: TetherState | None = None
    _pieces: list[TetherLog] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Refuse orders that the winch cannot follow."""
        self.orders = sorted(self.orders, key=lambda order: order.time_s)
        for order in self.orders:
            what = f"winch at {order.speed_mps:g} m/s from {order.time_s:g} s on"
            if self.winch is None:
                raise CannotComputeError(
                    f"{what}: the tether has no winch.\nState one, model.tether.winch in the "
                    "vehicle file, or leave the order out."
                )
            fastest = self.winch.no_load_radps * self.winch.drum_radius_m
            if not (np.isfinite(order.time_s) and order.time_s >= 0.0):
                raise CannotComputeError(f"{what}: a time from 0 on is expected.")
            if not abs(order.speed_mps) <= fastest * (1.0 + 1e-9):
                raise CannotComputeError(
                    f"{what}: its drum makes {fastest:.3g} m/s at most, without load."
                )

    def __call__(
        self,
        packed: PackedVehicle,
        commands: FloatArray,
        *,
        dt_s: float,
        vector: FloatArray | None = None,
        start: FloatArray | None = None,
        start_time_s: float = 0.0,
        external: FloatArray | None = None,
    ) -> Trajectory:
        """Simulate commands (m, n); arguments and errors as of `fly_tethered`.

        `external` is one wrench (1, 6), held over all of them.
        """
        pieces: list[Trajectory] = []
        for first in range(0, max(len(commands), 1), _STEPS_AT_A_TIME):
            part = commands[first : first + _STEPS_AT_A_TIME]
            begin_s = start_time_s + first * dt_s
            time_s = begin_s + dt_s * np.arange(len(part), dtype=float)
            flown, swung = fly_tethered(
                packed,
                part,
                self.cable,
                dt_s=dt_s,
                vector=vector,
                start=start if not pieces else pieces[-1].final_state,
                external=external,
                tether_start=self.state,
                winch=self.winch,
                winch_command=self._winch_commands(time_s),
                start_time_s=begin_s,
            )
            self.state = swung.final
            self._pieces.append(self._log(swung))
            pieces.append(flown)
        return join(pieces)

    def log(self) -> TetherLog:
        """Return what the tether did in all calls so far, as one run.

        Raises
        ------
        CannotComputeError
            Before the first call.
        """
        if not self._pieces:
            raise CannotComputeError("nothing was flown on the tether yet")
        return TetherLog(**stacked(self._pieces, [one.name for one in fields(TetherLog)]))

    def _winch_commands(self, time_s: FloatArray) -> FloatArray:
        """Command u (k,) of the winch at the times of steps (k,); 0 is braked."""
        if self.winch is None or not self.orders:
            return np.zeros(len(time_s))
        last = np.searchsorted([order.time_s for order in self.orders], time_s + 1e-9, "right") - 1
        speed = np.array([0.0, *(order.speed_mps for order in self.orders)])[last + 1]
        fastest = self.winch.no_load_radps * self.winch.drum_radius_m
        return np.clip(speed / fastest, -1.0, 1.0)

    def _log(self, swung: TetherHistory) -> TetherLog:
        radius = 0.0 if self.winch is None else self.winch.drum_radius_m
        # copies: views would keep the cable's shape of every step in memory
        return TetherLog(
            time_s=swung.time_s,
            wrench_on_vehicle=swung.wrench_on_vehicle,
            top_tension_n=swung.top_tension_n.copy(),
            lower_tension_n=swung.lower_tension_n,
            paid_out_m=swung.paid_out_m.copy(),
            payout_mps=radius * swung.drum_speed_radps,
        )


def nominal_mover(model: Model, orders: Sequence[WinchOrder] = ()) -> TetheredMover | None:
    """Return what moves a vehicle whose nominal model has a tether; None where it has none.

    Raises
    ------
    CannotComputeError
        For orders without a winch in the nominal model, or that it cannot follow.
    """
    tether = model.tether
    if tether is None or not tether.in_nominal:
        if orders:
            raise CannotComputeError(
                f"winch at {orders[0].speed_mps:g} m/s: the nominal model has no tether.\nState "
                "model.tether with in_nominal: true in the vehicle file, or leave the order out."
            )
        return None
    section = tether.winch
    winch = None if section is None else Winch(**section.model_dump(exclude={"source"}))
    return TetheredMover(tether, winch, orders)
