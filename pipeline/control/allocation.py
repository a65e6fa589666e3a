r"""From a wanted wrench to the thrust of each thruster: Kostenko 2023, eq. (6) with portions.

Two forms. "scaled" is eq. (6) as printed: every demand is multiplied by its portion, even when
nothing saturates. "limit" takes the portion only as the limit of the channel, |T| <= Pi T_max, and
is the default: a demand within reach is realised. Both keep the same bound, so thrusters shared by
two channels never saturate when the portions sum to at most one.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.types import ArrayLike, BoolArray, FloatArray
from pipeline.vehicle.schema import Allocator


@dataclass(frozen=True)
class Demand:
    """Wanted wrench in SNAME axes, arrays that broadcast together. [N], [N m]."""

    surge_n: ArrayLike
    pitch_nm: ArrayLike = 0.0
    yaw_nm: ArrayLike = 0.0


@dataclass(frozen=True)
class ThrustLimits:
    """Largest thrust of one stern thruster at a speed, by sign, both positive. [N]."""

    forward_n: float
    reverse_n: float

    @property
    def both_n(self) -> float:
        """What the thruster can do in either sign."""
        return min(self.forward_n, self.reverse_n)


@dataclass(frozen=True)
class ChannelThrusts:
    """Thrust per thruster that each channel asks: T_x, T_phi, T_psi of eq. (6). [N].

    Signs are the paper's: `heading_n` positive with M_y (to port), `pitch_n` with M_z (nose up).
    """

    surge_n: FloatArray
    heading_n: FloatArray
    pitch_n: FloatArray

    @property
    def stern(self) -> list[FloatArray]:
        """Upper, lower, left, right: T_x -+ T_psi, T_x -+ T_phi, each of its own shape. [N]."""
        return [
            self.surge_n - self.pitch_n,
            self.surge_n + self.pitch_n,
            self.surge_n - self.heading_n,
            self.surge_n + self.heading_n,
        ]

    def stern_thrust_n(self) -> FloatArray:
        """Return the same as one array (..., 4). [N]."""
        parts = self.stern
        if not any(np.ndim(one) for one in parts):  # stacking takes ten times as long
            return np.array(parts, float)
        return np.stack(np.broadcast_arrays(*parts), axis=-1)


def demanded_channels(demand: Demand, allocator: Allocator) -> ChannelThrusts:
    r"""Thrusts [N] of the demand on each channel before any limit or portion.

    .. math:: \frac{F_x}{4 \cos\delta}, \quad \frac{M_y}{2 L_s \sin\delta}, \quad
              \frac{M_z}{2 L_s \sin\delta}, \qquad M_y = -N,\ M_z = M
    """
    delta = np.radians(allocator.delta_deg)
    moment_per_newton = 2.0 * allocator.stern_arm_m * np.sin(delta)
    return ChannelThrusts(
        surge_n=np.asarray(demand.surge_n, float) / (4.0 * np.cos(delta)),
        heading_n=-np.asarray(demand.yaw_nm, float) / moment_per_newton + 0.0,
        pitch_n=np.asarray(demand.pitch_nm, float) / moment_per_newton,
    )


def limited_channels(
    demanded: ChannelThrusts, limits: ThrustLimits, allocator: Allocator
) -> ChannelThrusts:
    r"""Apply eq. (6), portions and limits: what is asked of the thrusters. [N].

    "scaled": :math:`\Pi\,\mathrm{clip}(T, \pm T_{max})`; "limit":
    :math:`\mathrm{clip}(T, \pm \Pi T_{max})`. The surge channel has a limit for each sign; heading
    and pitch push one thruster forward and its partner back and take the smaller limit. `limits`
    are T_max: fixed from the mooring test, or T_max(V) with speed compensation [N].

    References
    ----------
    Kostenko 2023, eq. (6); its last condition prints "<=" where ">=" is meant.
    """
    portions = allocator.portions

    def limited(
        thrust: FloatArray, portion: float, reverse_n: float, forward_n: float
    ) -> FloatArray:
        # `np.clip` takes several times as long for one demand
        if allocator.form == "scaled":
            return np.asarray(portion * np.minimum(np.maximum(thrust, -reverse_n), forward_n))
        return np.minimum(np.maximum(thrust, -portion * reverse_n), portion * forward_n)

    both = limits.both_n
    return ChannelThrusts(
        surge_n=limited(demanded.surge_n, portions.surge, limits.reverse_n, limits.forward_n),
        heading_n=limited(demanded.heading_n, portions.heading, both, both),
        pitch_n=limited(demanded.pitch_n, portions.pitch, both, both),
    )


def within_reach(demanded: ChannelThrusts, limits: ThrustLimits, allocator: Allocator) -> BoolArray:
    """Tell where no channel is cut: below Pi T_max in "limit", below T_max in "scaled"."""
    slack = 1.0 + 1e-9  # a demand exactly at the limit is within reach in spite of rounding
    portions = allocator.portions

    def inside(thrust: FloatArray, portion: float, reverse_n: float, forward_n: float) -> BoolArray:
        share = portion * slack if allocator.form == "limit" else slack
        return np.asarray((thrust <= share * forward_n) & (thrust >= -share * reverse_n))

    both = limits.both_n
    return np.asarray(
        inside(demanded.surge_n, portions.surge, limits.reverse_n, limits.forward_n)
        & inside(demanded.heading_n, portions.heading, both, both)
        & inside(demanded.pitch_n, portions.pitch, both, both)
    )


def at_limit(code: FloatArray, lowest: ArrayLike, highest: ArrayLike) -> BoolArray:
    """Tell which codes are at an end of their range, within half a code.

    A drive that turns one way only idles at its low end: that is no limit.

    >>> at_limit(np.array([127.0, -60.0, 60.0]), -60, 127).tolist()
    [True, True, False]
    >>> at_limit(np.array([0.0, 199.6]), 0, 200).tolist()
    [False, True]
    """
    low, high = np.asarray(lowest, float), np.asarray(highest, float)
    return np.asarray((code >= high - 0.5) | ((low < 0) & (code <= low + 0.5)))


def beyond_dead_zone(code: ArrayLike, lost: ArrayLike, code_max: ArrayLike) -> FloatArray:
    """Codes to send so that `code` takes effect where a thruster loses `lost` at either side of 0.

    Full code still is full code: d + (N_max - d) |N| / N_max, and 0 for 0; not rounded.

    >>> beyond_dead_zone([0.0, 50.0, -100.0], 10.0, 100.0).tolist()
    [0.0, 55.0, -100.0]
    """
    size, lost, largest = np.abs(code), np.asarray(lost, float), np.asarray(code_max, float)
    return np.asarray(np.sign(code) * (lost + size * (1.0 - lost / largest)) + 0.0)
