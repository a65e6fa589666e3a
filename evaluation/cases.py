"""Cases of the second generator: drawn, made as large as is wanted, flown and written."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from evaluation.craft import CRAFTS, NOISE, WANDER_RAD, Array, Craft, as_built, vehicle_file
from evaluation.faults import Fault, Maker, drawn
from evaluation.flight import COMMAND_S, STEP_S, march
from evaluation.runs import codes_for, fly, pushes_for, snag, write_log

#: Kinds of cases, in turn.
KINDS = ("single", "single", "none", "single", "single", "outside", "single", "none")
SIZES = (1.6, 3.5, 3.5, 6.0, 12.0)
RUN_S, WINDOW_S = 60.0, 10.0
CHANNELS = ("u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "z")
#: Two runs are enough to find how large a fault must be; so often it is tried again.
SIZING_RUNS, TRIES = 2, 4


@dataclass(frozen=True)
class SecondCase:
    """A case on disk: `folder` has ``vehicle.yaml`` and ``pool``; runs, held-out and healthy ones.

    `ratios` are those of the generated blind check: with the fault's trace over the healthy floor.
    """

    number: int
    kind: str
    craft: Craft
    fault: Fault | None
    folder: Path
    runs: tuple[str, ...]
    holdout: tuple[str, ...]
    healthy: tuple[str, ...]
    ratios: dict[str, float]
    wanted: float
    exact: bool


@dataclass(frozen=True)
class _Flown:
    codes: Array
    pushes: Array
    states: Array


def make_case(number: int, seed: int, to: Path) -> SecondCase:
    """Draw, fly and write a case."""
    generator = np.random.default_rng([seed, number, 2])
    stated = CRAFTS[number % len(CRAFTS)]
    kind = KINDS[(number // len(CRAFTS)) % len(KINDS)]
    exact = bool(generator.random() < 0.5)
    real = stated if exact else as_built(stated, generator)
    kinds = [str(one) for one in generator.permutation(["steps", "waves", "steps", "waves"])]
    # of some cases the held-out runs show next to nothing of most faults
    held = ["straight", "straight"] if generator.random() < 0.4 else ["steps", "waves"]
    plans = [codes_for(stated, one, RUN_S, generator) for one in (*kinds, *held)]
    pushes = [pushes_for(stated, RUN_S, generator) for _ in plans]
    fault, wanted = None, 0.0
    flown_by = real
    if kind == "single":
        fault, wanted = _sized(stated, real, plans, pushes, generator)
        flown_by = fault.craft
    stated = replace(stated, voltage_logged=flown_by.voltage_logged)
    if kind == "outside":
        size_n = float(generator.uniform(0.06, 0.2)) * stated.ahead_n
        pushes = [push + snag(RUN_S, generator, size_n) for push in pushes]
    folder = to / "cases" / f"case_{number:05d}"
    (folder / "pool").mkdir(parents=True, exist_ok=True)
    (folder / "vehicle.yaml").write_text(vehicle_file(stated), encoding="utf-8")
    names: dict[str, list[str]] = {"run": [], "held": [], "healthy": []}
    roles = ["run"] * len(kinds) + ["held"] * len(held)
    trace = []
    for role, codes, push in zip(roles, plans, pushes, strict=True):
        made = _Flown(codes, push, fly(flown_by, codes, push))
        name = f"{role}_{len(names[role])}"
        write_log(folder / "pool" / f"{name}.mcap", flown_by, codes, made.states, generator)
        names[role].append(name)
        if role == "run":
            trace.append(made)
    if generator.random() < 0.6:
        for count in range(3):
            codes = codes_for(stated, kinds[count], RUN_S, generator)
            push = pushes_for(stated, RUN_S, generator)
            calm = replace(real, voltage_logged=stated.voltage_logged)
            name = f"healthy_{count}"
            write_log(
                folder / "pool" / f"{name}.mcap", calm, codes, fly(calm, codes, push), generator
            )
            names["healthy"].append(name)
    ratios = {} if fault is None else gap_ratios(stated, real, fault.craft, trace)
    return SecondCase(
        number,
        kind,
        stated,
        fault,
        folder,
        tuple(names["run"]),
        tuple(names["held"]),
        tuple(names["healthy"]),
        ratios,
        wanted,
        exact,
    )


def _sized(
    stated: Craft,
    real: Craft,
    plans: Sequence[Array],
    pushes: Sequence[Array],
    generator: np.random.Generator,
) -> tuple[Fault, float]:
    """Draw a fault until one shows, and find the size at which it opens the wanted gap."""
    fault = None
    for _ in range(6):
        maker, wanted = drawn(stated, generator), float(generator.choice(SIZES))
        fault, ratio = _grown(maker, wanted, stated, real, plans, pushes)
        if ratio > 1.3:
            break
    assert fault is not None  # noqa: S101 - the loop ran
    return fault, wanted


def _grown(  # noqa: PLR0917 - one caller
    maker: Maker,
    wanted: float,
    stated: Craft,
    real: Craft,
    plans: Sequence[Array],
    pushes: Sequence[Array],
) -> tuple[Fault, float]:
    share, ratio = 0.4, 1.0
    fault = maker(real, share)
    for _ in range(TRIES):
        flights = [
            _Flown(codes, push, fly(fault.craft, codes, push))
            for codes, push in zip(plans[:SIZING_RUNS], pushes[:SIZING_RUNS], strict=True)
        ]
        ratio = max(gap_ratios(stated, real, fault.craft, flights).values())
        if abs(ratio - wanted) < 0.1 * wanted or (share >= 1.0 and ratio < wanted):
            break
        grown = share * np.sqrt(max(wanted**2 - 1.0, 0.1) / max(ratio**2 - 1.0, 1e-3))
        share = float(np.clip(grown, 0.02, 1.0))
        fault = maker(real, share)
    return fault, ratio


def gap_ratios(
    stated: Craft, real: Craft, faulty: Craft, flights: Sequence[_Flown]
) -> dict[str, float]:
    """Gap over the healthy floor by channel, in windows of 10 s from the true motion."""
    steps, rows = round(WINDOW_S / STEP_S), round(WINDOW_S / COMMAND_S)
    trace: list[Array] = []
    floor: list[Array] = []
    for one in flights:
        for window in range(len(one.codes) // rows):
            codes = one.codes[window * rows : (window + 1) * rows]
            push = one.pushes[window * steps : (window + 1) * steps]
            start = one.states[window * steps, :-6]
            calm = np.zeros_like(push)
            at = window * WINDOW_S
            whole = len(one.codes) * COMMAND_S
            with_fault, without, healthy, file = (
                _seen(craft, march(craft, codes, forces, start, at, whole))
                for craft, forces in (
                    (faulty, calm),
                    (real, calm),
                    (real, push),
                    (stated, calm),
                )
            )
            trace.append(with_fault - without)
            floor.append(healthy - file)
    sensor = np.array(
        [NOISE["dvl"]] * 3
        + [NOISE["rate"]] * 3
        + [np.hypot(NOISE["attitude"], WANDER_RAD)] * 3
        + [NOISE["depth"]]
    )
    gap = np.mean(np.square(np.concatenate(trace)), axis=0)
    calm_gap = np.mean(np.square(np.concatenate(floor)), axis=0) + sensor**2
    ratio = np.sqrt((gap + calm_gap) / calm_gap)
    return dict(zip(CHANNELS, ratio.tolist(), strict=True))


def _seen(craft: Craft, states: Array) -> Array:
    """Velocities as the DVL shows them, rates, angles and depth (m, 10), at 10 Hz."""
    rows = states[:: round(COMMAND_S / STEP_S)]
    w, x, y, z = rows[:, 3:7].T
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - x * z), -1.0, 1.0))
    yaw = np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    return np.column_stack(
        [craft.dvl_scale * rows[:, 7:10], rows[:, 10:13], roll, pitch, yaw, rows[:, 2]]
    )
