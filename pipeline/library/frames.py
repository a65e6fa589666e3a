"""Frames of the library, with what they were made from beside them."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from pipeline.records.run_table import QUANTITIES, RunTable

#: Quantity -> columns of its frame; those of the commands are named after the thrusters.
_COLUMNS = {
    "angular_velocity": ("p_radps", "q_radps", "r_radps"),
    "specific_force": ("specific_force_x_mps2", "specific_force_y_mps2", "specific_force_z_mps2"),
    "attitude": ("attitude_w", "attitude_x", "attitude_y", "attitude_z"),
    "velocity": ("u_mps", "v_mps", "w_mps"),
    "depth": ("depth_m",),
    "position": ("north_m", "east_m", "down_m"),
    "voltage": ("voltage_v",),
    "current": ("current_a",),
}
_OF_THRUSTERS = {"command": "code", "shaft_speed": "rpm"}


def frame_of(run: RunTable) -> pd.DataFrame:
    """Put a run's channels side by side; readings that are not valid are left empty."""
    columns: dict[str, Any] = {}
    for quantity in QUANTITIES:
        if quantity not in run.valid:
            continue
        values, valid = run.values[quantity], run.valid[quantity]  # noqa: PD011 - no pandas object
        names: Sequence[str] = _COLUMNS.get(quantity, ())
        if quantity in _OF_THRUSTERS:
            names = [f"{quantity}_{one}_{_OF_THRUSTERS[quantity]}" for one in run.thrusters]
        for name, column in zip(names, values.T, strict=True):
            columns[name] = pd.Series(column).where(pd.Series(valid))
    frame = pd.DataFrame(columns)
    frame.index = pd.Index(run.time_s, name="time_s")
    return frame


def told(frame: pd.DataFrame, record: object, warnings: Sequence[str]) -> pd.DataFrame:
    """Keep what a frame was made from, and what was said of it, beside it."""
    frame.attrs["record"] = record
    frame.attrs["warnings"] = tuple(warnings)
    return frame
