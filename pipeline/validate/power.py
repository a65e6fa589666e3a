"""Power of the thrusters in flight: at the shafts from the static family, and at the supply."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.records.fits import StaticCharacteristic
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord
from pipeline.records.validation import ElectricalModel
from pipeline.types import FloatArray

#: Fewer usable points with current and voltage than this give no model of the input power.
FEWEST_POINTS = 20


@dataclass(frozen=True)
class Grid:
    """Values (rows, columns) on a regular grid from (0, 0); beyond the last row along its slope."""

    values: FloatArray
    row_step: float
    column_step: float

    def at(self, row: FloatArray, column: FloatArray) -> FloatArray:
        """Bilinear values at places in the units of the steps."""
        rows, columns = self.values.shape
        c = np.clip(column / self.column_step, 0.0, columns - 1.0)
        j = np.minimum(c.astype(int), columns - 2)
        c = c - j
        if rows == 1:
            return np.asarray(self.values[0, j] * (1 - c) + self.values[0, j + 1] * c)
        r = np.maximum(row / self.row_step, 0.0)
        i = np.minimum(r.astype(int), rows - 2)
        r = r - i
        low = self.values[i, j] * (1 - c) + self.values[i, j + 1] * c
        high = self.values[i + 1, j] * (1 - c) + self.values[i + 1, j + 1] * c
        return np.asarray(low + r * (high - low))


@dataclass(frozen=True)
class PowerModel:
    """Shaft speed and torque over speed along the thrust and code, and the input power.

    `shaft_rps`, `torque_nm` on a regular grid, for all thrusters but the `others`, by place.
    """

    shaft_rps: Grid
    torque_nm: Grid
    electrical: ElectricalModel | None
    others: Mapping[int, "PowerModel"] = field(default_factory=dict)

    def means(self, codes: FloatArray, inflow_mps: FloatArray) -> tuple[float, float | None]:
        """Mean shaft and electrical power, summed over thrusters, of samples (k, n). [W].

        A thruster at code 0 counts nothing: the bench did not measure a drive that waits.
        """
        if self.others:
            own = [i for i in range(codes.shape[1]) if i not in self.others]
            parts = [replace(self, others={}).means(codes[:, own], inflow_mps[:, own])]
            for i, other in self.others.items():
                parts.append(other.means(codes[:, [i]], inflow_mps[:, [i]]))
            drawn = [electrical for _, electrical in parts if electrical is not None]
            whole = sum(drawn) if len(drawn) == len(parts) else None
            return sum(shaft for shaft, _ in parts), whole
        on = codes != 0.0
        along = np.maximum(np.sign(codes[on]) * inflow_mps[on], 0.0)
        shaft = np.maximum(self.shaft_rps.at(along, np.abs(codes[on])), 0.0)
        torque = np.maximum(self.torque_nm.at(along, np.abs(codes[on])), 0.0)
        out = 2.0 * np.pi * shaft * torque
        mean_shaft = float(out.sum() / len(codes))
        if self.electrical is None:
            return mean_shaft, None
        model = self.electrical
        loss = model.constant_w + model.speed_ws * shaft + model.torque_w_per_nm2 * torque**2
        return mean_shaft, float((out + loss).sum() / len(codes))


def power_model(static: StaticCharacteristic, load_test: LoadTestRecord | None) -> PowerModel:
    """Take shaft speed and torque from the static family, the losses from the load test."""
    rows = [i for i, v in enumerate(static.speed_mps) if abs(v / 0.1 - round(v / 0.1)) < 1e-6]
    code_step = float(static.code[1] - static.code[0])

    def grid(values: FloatArray) -> Grid:
        # code 0 is not in the family: there the shaft rests
        return Grid(
            np.concatenate([np.zeros((len(rows), 1)), values[rows]], axis=1), 0.1, code_step
        )

    return PowerModel(
        shaft_rps=grid(np.array(static.shaft_speed_rpm) / 60.0),
        torque_nm=grid(np.array(static.torque_nm)),
        electrical=None if load_test is None else electrical_model(load_test.points),
    )


def electrical_model(points: tuple[LoadTestPoint, ...]) -> ElectricalModel | None:
    r"""Fit the drive's losses to the load test; None without current and voltage.

    .. math:: P_{in} - 2 \pi n M = a_0 + a_1 n + a_2 M^2

    a constant, a part that grows with speed (iron, seals) and copper, by least squares over the
    points that the load test marks nothing against.
    """
    usable = [p for p in points if not p.marks and _input_power(p) is not None]
    if len(usable) < FEWEST_POINTS:
        return None
    shaft = np.abs([p.shaft_speed_rpm / 60.0 for p in usable])
    torque = np.abs([p.torque_nm for p in usable])
    power = np.array([_input_power(p) for p in usable], float)
    terms = np.stack([np.ones_like(shaft), shaft, torque**2], axis=1)
    loss = power - 2.0 * np.pi * shaft * torque
    found, _, rank, _ = np.linalg.lstsq(terms, loss, rcond=None)
    if rank < terms.shape[1]:
        return None
    return ElectricalModel(
        constant_w=float(found[0]),
        speed_ws=float(found[1]),
        torque_w_per_nm2=float(found[2]),
        points=len(usable),
        residual_rms_w=float(np.sqrt(np.mean((loss - terms @ found) ** 2))),
    )


def _input_power(point: LoadTestPoint) -> float | None:
    if point.input_power_w is not None:
        return point.input_power_w
    if point.current_a is None or point.voltage_v is None:
        return None
    return abs(point.current_a * point.voltage_v)
