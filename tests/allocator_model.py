"""Models of the exported allocator: single precision to the bit, fixed point to the integer.

Both take many calls at once and do for each what the C code does, in the same order. Tables are
those of the types of thruster, in the order of `AllocatorLayout.kind`.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

import fixed_model
import numpy as np
import single_model as single_precision
from bounded_model import FixedModel, FloatModel, Model, bounded_thrusts

from pipeline.control.bounded_allocation import Floats
from pipeline.export import fixed_point
from pipeline.export.allocator_layout import AllocatorLayout, PaperConstants
from pipeline.export.c_text import SingleTables
from pipeline.export.fixed_point import INT32_MAX, LARGEST_PAPER, FixedTables
from pipeline.export.grid_check import FLAG
from pipeline.types import IntArray
from pipeline.vehicle.schema import Allocator

T = TypeVar("T", SingleTables, FixedTables)


def allocate_single(
    layout: AllocatorLayout, tables: Sequence[SingleTables], wrench: Floats, velocity: Floats
) -> tuple[Floats, IntArray, IntArray]:
    """Thrusts (m, n) [N], codes (m, n), flags (m,) of wrenches (m, 6), velocities (m, 3)."""
    do = FloatModel(np.float32)
    nan = np.isnan(wrench).any(axis=1) | np.isnan(velocity).any(axis=1)
    held = [np.where(nan[:, None], do.zero, x.astype(np.float32)) for x in (wrench, velocity)]
    with np.errstate(invalid="ignore", over="ignore"):
        along = _along(do, layout, held[1])
    nan = nan | np.isnan(along).any(axis=1)
    held[0], along = (np.where(nan[:, None], do.zero, x) for x in (held[0], along))
    gain = do.small(layout.gain, 24)
    high, low = (
        by_type(layout, tables, partial(single_precision.thrust_limit, sign=sign), along)
        * gain[:, side]
        for sign, side in ((1, 0), (-1, 1))
    )
    thrust, flags = _divide(do, layout, held[0], low, high)
    divisor = do.small(layout.divisor, 24)
    own = thrust / np.where(thrust < 0, divisor[:, 1], divisor[:, 0])
    codes = _sent(layout, by_type(layout, tables, single_precision.code_from_thrust, own, along))
    flags = flags | _told(by_type(layout, tables, single_precision.thrust_flags, own, along))
    return (
        np.where(nan[:, None], do.zero, thrust),
        np.where(nan[:, None], 0, codes),
        np.where(nan, FLAG["NOT_A_NUMBER"], flags),
    )


def allocate_fixed(
    layout: AllocatorLayout,
    tables: Sequence[FixedTables],
    wrench_q16: IntArray,
    velocity_q16: IntArray,
) -> tuple[IntArray, IntArray, IntArray]:
    """Thrusts (m, n) Q16.16 [N], codes (m, n), flags (m,); arguments in Q16.16."""
    do = FixedModel(layout.shift)
    wrench, velocity = wrench_q16.astype(np.int64), velocity_q16.astype(np.int64)
    along = np.clip(_along(do, layout, velocity), -INT32_MAX, INT32_MAX)
    gain, over = do.small(layout.gain, 24), do.small(1.0 / layout.divisor, 24)
    high, low = (
        do.times(
            by_type(layout, tables, partial(fixed_model.thrust_limit, sign=sign), along),
            gain[:, side],
            24,
        )
        for sign, side in ((1, 0), (-1, 1))
    )
    thrust, flags = _divide(do, layout, wrench, low, high)
    own = do.times(thrust, np.where(thrust < 0, over[:, 1], over[:, 0]), 24)
    codes = _sent(layout, by_type(layout, tables, fixed_point.code_from_thrust, own, along))
    told = _told(by_type(layout, tables, fixed_flags, own, along))
    return thrust, codes, flags | told


def by_type(
    layout: AllocatorLayout, tables: Sequence[T], ask: Callable[..., Floats], *values: Floats
) -> Floats:
    """Ask the tables of the type of each thruster; `values` (m, n)."""
    out: Floats | None = None
    for place, one in enumerate(tables):
        columns = np.array(layout.kind) == place
        found = ask(one, *(value[:, columns] for value in values))
        out = np.empty(values[0].shape, found.dtype) if out is None else out
        out[:, columns] = found
    assert out is not None
    return out


def _sent(layout: AllocatorLayout, codes: IntArray) -> IntArray:
    """Codes beyond the dead zones that thrusters have of their own, as the C code rounds them."""
    lost, largest = layout.lost_q8, np.rint(layout.corrections.code_max).astype(np.int64)
    if not lost.any():
        return codes
    size = np.abs(codes.astype(np.int64))
    moved = (lost * largest + size * (256 * largest - lost) + 128 * largest) // (256 * largest)
    sent = np.where((size == 0) | (lost == 0), codes, np.sign(codes) * moved)
    return np.maximum(sent, np.array(layout.code_range)[:, 0])


def _told(flags: IntArray) -> IntArray:
    """Collect what holds for any thruster; whether a limit cut, the division tells."""
    told: IntArray = np.bitwise_or.reduce(flags & ~FLAG["SATURATED"], axis=1)
    return told


def _along(do: Model, layout: AllocatorLayout, velocity: Floats) -> Floats:
    """Speed along each thruster, (m, n)."""
    d = do.small(layout.flow, 30)
    parts = [do.times(velocity[:, k : k + 1], d[:, k], 30) for k in range(3)]
    return np.asarray(parts[0] + parts[1] + parts[2])


def _divide(
    do: Model, layout: AllocatorLayout, wrench: Floats, low: Floats, high: Floats
) -> tuple[Floats, IntArray]:
    """Thrusts within limits, and the flags of what cut."""
    if layout.paper is not None:
        return _divide_by_paper(do, layout, layout.paper, wrench, (low, high))
    thrust, cut = bounded_thrusts(
        layout.allocation, wrench, low, high, largest_n=layout.largest_n, arithmetic=do
    )
    return thrust, FLAG["SATURATED"] * cut.astype(np.int64)


def _divide_by_paper(
    do: Model,
    layout: AllocatorLayout,
    geometry: Allocator,
    wrench: Floats,
    limits: tuple[Floats, Floats],
) -> tuple[Floats, IntArray]:
    """Divide by eqs. (5) and (6)."""
    low, high = limits
    one, largest = PaperConstants.of(geometry), do.large(LARGEST_PAPER)
    tau = np.clip(wrench, -largest, largest)

    def by(x: Floats, constant: float) -> Floats:
        return do.times(x, do.small(constant, 24), 24)

    flags = np.zeros(len(tau), np.int64)

    def held(x: Floats, least: Floats, most: Floats, flag: str) -> Floats:
        nonlocal flags
        flags = flags | np.where((x < least) | (x > most), FLAG[flag], 0)
        return np.clip(x, least, most)

    thrust, pitch = np.zeros_like(low), tau[:, 4]
    if layout.bow is not None:
        up = by(pitch - by(tau[:, 2], one.stern_arm_m), one.bow_share_1pm)
        pitch = by(tau[:, 2] + up, one.stern_arm_m)
        thrust[:, layout.bow] = held(up, low[:, layout.bow], high[:, layout.bow], "SATURATED")
    forward = high[:, layout.stern].min(axis=1)
    reverse = (-low[:, layout.stern]).min(axis=1)
    both = np.minimum(forward, reverse)
    scaled = geometry.form == "scaled"

    def channel(x: Floats, back: Floats, ahead: Floats, portion: float) -> Floats:
        share = 1.0 if scaled else portion
        flag = "SATURATED" if scaled else "LIMITED_BY_PORTION"
        kept = held(x, -by(back, share), by(ahead, share), flag)
        return by(kept, portion) if scaled else kept

    surge = channel(by(tau[:, 0], one.surge), reverse, forward, one.portions[0])
    heading = channel(-by(tau[:, 5], one.moment_1pm), both, both, one.portions[1])
    swing = channel(by(pitch, one.moment_1pm), both, both, one.portions[2])
    for place, value in zip(
        layout.stern, (surge - swing, surge + swing, surge - heading, surge + heading), strict=True
    ):
        thrust[:, place] = np.clip(value, low[:, place], high[:, place])
    return thrust, flags


def fixed_flags(tables: FixedTables, thrust_q16: IntArray, speed_q16: IntArray) -> IntArray:
    """Do what ``<vehicle>_thruster_flags_q`` does."""
    thrust, speed = np.broadcast_arrays(
        np.asarray(thrust_q16, np.int64), np.asarray(speed_q16, np.int64)
    )
    most, least = (fixed_model.thrust_limit(tables, speed, sign=sign) for sign in (1, -1))
    live = np.abs(thrust) > tables.thrust_dead_q16
    flags: IntArray = (
        FLAG["SATURATED"] * ((thrust > most) | (thrust < least))
        + FLAG["OUT_OF_TESTED_RANGE"] * (np.abs(speed) > tables.tested_q16)
        + FLAG["IN_DEAD_ZONE"] * (~live & (thrust != 0))
        + FLAG["AGAINST_THE_MOTION"] * (live & (np.sign(thrust) * np.sign(speed) < 0))
    )
    return flags
