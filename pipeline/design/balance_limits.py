"""What a thruster can give at a speed of inflow, and how much of it a load takes."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from pipeline.control.real_thrust import RealThruster
from pipeline.design.balance_input import LimitInput
from pipeline.errors import CannotComputeError
from pipeline.records.design import ThrusterLoad
from pipeline.records.fits import StaticCharacteristic
from pipeline.types import FloatArray

#: Where a thruster gives nothing any more, this stands for a use without bound.
MOST_USE = 1e3


@dataclass(frozen=True)
class StatedLimits:
    """Limits from the file: thrust, or shaft power by eq. (10), N = F V / eta."""

    stated: LimitInput

    @property
    def kind(self) -> str:
        """What limits, in words; empty: nothing is stated."""
        parts = []
        if self.stated.thrust_max_n is not None:
            parts.append(f"{self.stated.thrust_max_n:g} N of thrust")
        if self.stated.power_max_w is not None:
            parts.append(f"{self.stated.power_max_w:g} W of shaft power")
        return " and ".join(parts)

    def power_w(self, thrust_n: float, speed_mps: float) -> float | None:
        """Shaft power, eq. (10). [W]."""
        efficiency = self.stated.propeller_efficiency
        return None if efficiency is None else abs(thrust_n) * speed_mps / efficiency

    def limit_n(self, speed_mps: float) -> float | None:
        """Largest thrust at a speed. [N]."""
        limits = [] if self.stated.thrust_max_n is None else [self.stated.thrust_max_n]
        if self.stated.power_max_w is not None and self.stated.propeller_efficiency is not None:
            limits.append(self.stated.power_max_w * self.stated.propeller_efficiency / speed_mps)
        return min(limits) if limits else None

    def use(self, thrust_n: float, inflow_mps: float, speed_mps: float) -> float | None:
        """Share of the stated limit, above 1 it saturates; None where none is stated."""
        del inflow_mps
        limit = self.limit_n(speed_mps)
        return None if limit is None else abs(thrust_n) / limit

    def load(
        self, thruster: str, thrust_n: float, inflow_mps: float, speed_mps: float
    ) -> ThrusterLoad:
        """Load with power by eq. (10)."""
        return ThrusterLoad(
            thruster=thruster,
            thrust_n=thrust_n,
            inflow_mps=inflow_mps,
            power_w=self.power_w(thrust_n, speed_mps),
            limit_n=self.limit_n(speed_mps),
            use=self.use(thrust_n, inflow_mps, speed_mps),
        )


@dataclass(frozen=True)
class TableLimits:
    """Limits from the identified family T(N, V) of a vehicle's thruster.

    Against the motion the row at rest holds.
    """

    real: RealThruster
    shaft_rpm: FloatArray
    torque_nm: FloatArray
    code_max: float
    code_min: float
    """Largest code backwards, not above 0; 0 where the drive does not turn backwards."""
    vehicle: str

    @property
    def kind(self) -> str:
        """What limits, in words."""
        if self.code_min == -self.code_max:
            return f"the identified T(N, V) of {self.vehicle}, code {self.code_max:g}"
        return (
            f"the identified T(N, V) of {self.vehicle}, codes {self.code_min:g} to "
            f"{self.code_max:g}"
        )

    @property
    def fastest_mps(self) -> float:
        """Speed at which the family ends. [m/s]."""
        return float(self.real.speed_mps[-1])

    def _end(self, thrust_n: float) -> tuple[float, float]:
        """Sign of a load and the size of the largest code that way."""
        return (-1.0, -self.code_min) if thrust_n < 0 else (1.0, self.code_max)

    def limit_n(self, thrust_n: float, inflow_mps: float) -> float:
        """Largest thrust of the load's sign. [N]."""
        sign, end = self._end(thrust_n)
        # a drive that does not turn that way gives nothing there, whatever the table begins with
        return abs(float(self.real.thrust(sign * end, inflow_mps))) if end > 0 else 0.0

    def use(self, thrust_n: float, inflow_mps: float, speed_mps: float) -> float | None:
        """Load over the largest thrust at its inflow."""
        del speed_mps
        limit = self.limit_n(thrust_n, inflow_mps)
        return min(abs(thrust_n) / limit, MOST_USE) if limit > 0 else MOST_USE

    def code(self, thrust_n: float, inflow_mps: float) -> float | None:
        """Code that gives the thrust, or None beyond the largest."""
        sign, end = self._end(thrust_n)
        if end == 0:
            return None
        codes = np.append(self.real.code[self.real.code < end], end)
        thrust = np.abs(self.real.thrust(sign * codes, inflow_mps))
        if abs(thrust_n) > thrust[-1]:
            return None
        first = max(int(np.argmax(thrust > 0.0)) - 1, 0)
        return sign * float(np.interp(abs(thrust_n), thrust[first:], codes[first:]))

    def load(
        self, thruster: str, thrust_n: float, inflow_mps: float, speed_mps: float
    ) -> ThrusterLoad:
        """Load with code, shaft speed, torque and shaft power from the bench's working points."""
        code = self.code(thrust_n, inflow_mps)
        rpm = torque = power = None
        if code is not None:
            sign = 1.0 if code >= 0 else -1.0
            rpm = self._at(self.shaft_rpm, abs(code), max(sign * inflow_mps, 0.0))
            torque = self._at(self.torque_nm, abs(code), max(sign * inflow_mps, 0.0))
            power = 2.0 * np.pi * rpm / 60.0 * torque
        return ThrusterLoad(
            thruster=thruster,
            thrust_n=thrust_n,
            inflow_mps=inflow_mps,
            power_w=power,
            shaft_speed_rpm=rpm,
            torque_nm=torque,
            code=code,
            limit_n=self.limit_n(thrust_n, inflow_mps),
            use=self.use(thrust_n, inflow_mps, speed_mps),
        )

    def _at(self, table: FloatArray, code: float, inflow_mps: float) -> float:
        speeds, codes = self.real.speed_mps, self.real.code
        look = RegularGridInterpolator((speeds, codes), table)
        point = (np.clip(inflow_mps, 0, speeds[-1]), np.clip(code, codes[0], codes[-1]))
        return float(look([point])[0])


BalanceLimits = StatedLimits | TableLimits


def table_limits(
    static: StaticCharacteristic | None, code_max: float, code_min: float, vehicle: str
) -> TableLimits | None:
    """Limits of a vehicle with bench tables and the codes of its drive, or None without them.

    Raises
    ------
    CannotComputeError
        When the family has no thrust at all.
    """
    if static is None:
        return None
    if not static.speed_mps:
        raise CannotComputeError(f"the static family of {vehicle} has no speeds")
    return TableLimits(
        RealThruster.from_record(static),
        np.array(static.shaft_speed_rpm),
        np.array(static.torque_nm),
        code_max,
        code_min,
        vehicle,
    )
