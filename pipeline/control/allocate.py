"""The allocator as a whole: wrench demand and speed to codes, and codes to the real wrench."""

from dataclasses import dataclass

import numpy as np

from pipeline.control.allocation import (
    Demand,
    Form,
    asked_wrench,
    bow_thrust,
    demanded_channels,
    limited_channels,
)
from pipeline.control.inverse import Inverse, rounded
from pipeline.control.real_thrust import RealThruster
from pipeline.control.wrench import paper_wrench
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Allocator


@dataclass(frozen=True)
class Allocation:
    """Codes and what they are meant to give.

    `stern_code`, `stern_thrust_n` shape (..., 4): upper, lower, left, right; `bow_code`,
    `bow_thrust_n` shape (...); `asked` shape (..., 6): the wrench of those thrusts, SNAME.
    """

    stern_code: FloatArray
    bow_code: FloatArray
    stern_thrust_n: FloatArray
    bow_thrust_n: FloatArray
    asked: FloatArray


def allocate(
    demand: Demand,
    speed_mps: float,
    *,
    allocator: Allocator,
    inverse: Inverse,
    form: Form | None = None,
    round_codes: bool = False,
) -> Allocation:
    """Turn a wrench demand into control codes: eq. (6), then N(T) or N(T, V).

    Parameters
    ----------
    demand : Demand
        Wanted wrench, SNAME. [N], [N m]
    speed_mps : float
        Forward speed V_x through the water, used for every stern thruster as in the paper. The
        bow thruster lies across the motion and uses its characteristic at rest. [m/s]
    allocator : Allocator
        Geometry and portions.
    inverse : Inverse
        `MooringCubic` for the allocator without speed; `FirmwareGrid` or `SpeedCubic` with it.
    form : {"limit", "scaled"}, optional
        Overrides the allocator's.
    round_codes : bool
        Round to whole codes as the drive's interface does.

    Returns
    -------
    Allocation
        Codes, wanted thrusts and the wrench asked for.
    """
    limits = inverse.limits(speed_mps)
    channels = limited_channels(demanded_channels(demand, allocator), limits, allocator, form)
    bow = bow_thrust(demand, inverse.limits(0.0), allocator)
    stern = channels.stern_thrust_n()
    stern_code, bow_code = inverse.code(stern, speed_mps), inverse.code(bow, 0.0)
    if round_codes:
        stern_code, bow_code = rounded(stern_code), rounded(bow_code)
    return Allocation(
        stern_code=stern_code,
        bow_code=bow_code,
        stern_thrust_n=stern,
        bow_thrust_n=bow,
        asked=asked_wrench(channels, allocator, bow),
    )


def achieved_wrench(
    stern_code: FloatArray,
    speed_mps: float,
    *,
    allocator: Allocator,
    thruster: RealThruster,
    bow_code: FloatArray | float = 0.0,
    follow_axis: bool = False,
) -> FloatArray:
    r"""Wrench that codes really give at a speed, shape (..., 6), SNAME. [N], [N m].

    Parameters
    ----------
    stern_code : ndarray, shape (..., 4)
        Upper, lower, left, right.
    speed_mps : float
        Forward speed V_x through the water. [m/s]
    allocator : Allocator
        Geometry.
    thruster : RealThruster
        The same for all of them.
    bow_code : array_like, shape (...)
        Code of the bow thruster, whose inflow is taken as zero.
    follow_axis : bool
        Let the inflow of a stern thruster be :math:`V_x \cos\delta`, the speed along its axis,
        in place of the paper's V_x.
    """
    inflow = speed_mps * np.cos(np.radians(allocator.delta_deg)) if follow_axis else speed_mps
    return paper_wrench(
        thruster.thrust(stern_code, inflow), allocator, thruster.thrust(bow_code, 0.0)
    ).to_sname()
