"""What is measured: one function a question, each returns plain figures."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import cases
from benchmarks.derivatives import FORTY_PARAMETERS, complex_step_jacobian, relative_errors
from benchmarks.measure import Timing, interleaved
from benchmarks.peer_c_library import PeerC
from benchmarks.peer_numpy import simulate_numpy
from benchmarks.sensitivity import BODY_CHANNELS, jacobian, parameter_scale
from pipeline.physics.parameters import offset, write
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Method, run
from pipeline.simulate.tether import LumpedMassTether
from pipeline.simulate.tethered import fly_tethered
from pipeline.types import FloatArray

Figures = dict[str, Any]
DT_S = 0.02
METHODS: tuple[Method, ...] = ("semi_implicit", "rk4")
#: The same compiled kernel each time; what is switched on differs.
CASES: dict[str, dict[str, bool]] = {
    "every effect neutral": {},
    "every effect on": {"effects": True},
    "every effect on, shafts in time": {"effects": True, "shafts": True},
}
_FIRST_CALL = """
import time
began = time.perf_counter()
from benchmarks import cases
from pipeline.simulate.run import run
imported = time.perf_counter()
packed, commands = cases.vehicle(), cases.multisine(100)
packed_at = time.perf_counter()
run(packed, commands, dt_s=0.02, start=cases.START, method="semi_implicit")
done = time.perf_counter()
print(imported - began, done - packed_at, done - began, time.process_time())
"""


def _kernel(packed: PackedVehicle, steps: int, method: Method) -> Callable[[], object]:
    commands = cases.multisine(steps, len(packed.thruster_names))
    return partial(run, packed, commands, dt_s=DT_S, start=cases.START, method=method)


def _side_by_side(
    packed: PackedVehicle, peers: dict[str, PeerC], steps: int, method: Method
) -> dict[str, Callable[[], object]]:
    """Return the same run by the kernel and by each C peer."""
    commands = cases.multisine(steps, len(packed.thruster_names))
    options: dict[str, Any] = {"dt_s": DT_S, "start": cases.START, "method": method}
    return {
        "kernel": _kernel(packed, steps, method),
        **{
            name: partial(peer.simulate, packed, commands, **options)
            for name, peer in peers.items()
        },
    }


def single_trajectory(peers: dict[str, PeerC], *, quick: bool) -> list[Figures]:
    """One run of five thrusters: the kernel, textbook NumPy, and C, in microseconds a step."""
    steps, numpy_steps, rounds = (2000, 60, 5) if quick else (10000, 400, 25)
    found = []
    for case, options in CASES.items():
        packed = cases.vehicle(**options)
        few = cases.multisine(numpy_steps)
        for method in METHODS:
            calls = _side_by_side(packed, peers, steps, method)
            calls["numpy"] = partial(
                simulate_numpy, packed, few, dt_s=DT_S, start=cases.START, method=method
            )
            times = interleaved(calls, rounds)
            per_step = {name: numpy_steps if name == "numpy" else steps for name in calls}
            found.append(
                {
                    "case": case,
                    "method": method,
                    "us_per_step": _each(times, per_step, lambda t: t.median_s),
                    "best_us_per_step": _each(times, per_step, lambda t: t.best_s),
                    "over_numpy": times["numpy"].times_slower_than(times["kernel"])
                    * steps
                    / numpy_steps,
                    "of_c": {
                        name: times[name].times_slower_than(times["kernel"]) for name in peers
                    },
                }
            )
    return found


def _each(
    times: dict[str, Timing], steps: dict[str, int], pick: Callable[[Timing], float]
) -> dict[str, float]:
    return {name: 1e6 * pick(timing) / steps[name] for name, timing in times.items()}


def two_cores(*, quick: bool) -> list[Figures]:
    """Many runs of 2000 steps on one thread and on two."""
    count, rounds = (8, 5) if quick else (64, 60)
    packed, commands = cases.vehicle(effects=True), cases.multisine(2000)
    vectors = [packed.vector.copy() for _ in range(count)]
    found = []
    for method in METHODS:
        many = partial(
            cases.run_many, packed, commands, vectors, dt_s=DT_S, start=cases.START, method=method
        )
        calls = {str(threads): partial(many, threads=threads) for threads in (1, 2)}
        times = interleaved(calls, rounds, time.perf_counter)
        used = interleaved(calls, rounds, time.process_time)
        found.append(
            {
                "method": method,
                "processor_time_ratio": used["2"].times_slower_than(used["1"]),
                "runs": count,
                "one_ms": 1e3 * times["1"].median_s,
                "two_ms": 1e3 * times["2"].median_s,
                "speed_up": times["1"].times_slower_than(times["2"]),
                "best_speed_up": times["1"].best_s / times["2"].best_s,
            }
        )
    return found


def first_call(*, quick: bool) -> Figures:
    """Start a new process: import and first run, from an empty cache and from a filled one."""
    root = Path(__file__).resolve().parent.parent

    def once(cache: str) -> list[float]:
        said = subprocess.run(  # noqa: S603 (this interpreter, our own text)
            [sys.executable, "-c", _FIRST_CALL],
            env={**os.environ, "RIG2SEA_CACHE": cache, "PYTHONPATH": str(root)},
            capture_output=True,
            text=True,
            check=True,
        )
        return [float(word) for word in said.stdout.split()]

    with tempfile.TemporaryDirectory() as cache:
        cold = once(cache)
        warm = np.array([once(cache) for _ in range(3 if quick else 9)])
    names = ("import_s", "first_run_s", "both_s", "processor_s")
    return {
        "compiling": dict(zip(names, cold, strict=True)),
        "from_cache": dict(zip(names, np.median(warm, axis=0).tolist(), strict=True)),
        "from_cache_best": dict(zip(names, warm.min(axis=0).tolist(), strict=True)),
    }


def growth_with_thrusters(peers: dict[str, PeerC], *, quick: bool) -> list[Figures]:
    """Cost of a step against the number of thrusters, every effect on."""
    steps, rounds = (1000, 3) if quick else (5000, 15)
    found = []
    for count in (1, 5, 12) if quick else range(1, 13):
        packed = cases.vehicle(count, effects=True)
        row: Figures = {"thrusters": count}
        for method in METHODS:
            calls = _side_by_side(packed, peers, steps, method)
            times = interleaved(calls, rounds)
            row[method] = _each(times, dict.fromkeys(calls, steps), lambda t: t.median_s)
        found.append(row)
    return found


def growth_with_trajectories(*, quick: bool) -> list[Figures]:
    """Time of many runs of 2000 steps, semi-implicit, every effect on, by threads."""
    rounds = 3 if quick else 25
    packed, commands = cases.vehicle(effects=True), cases.multisine(2000)
    found = []
    for count in (1, 8) if quick else (1, 2, 4, 8, 16, 32, 64, 128):
        vectors = [packed.vector] * count
        many = partial(
            cases.run_many,
            packed,
            commands,
            vectors,
            dt_s=DT_S,
            start=cases.START,
            method="semi_implicit",
        )
        calls = {f"threads_{threads}_ms": partial(many, threads=threads) for threads in (1, 2)}
        times = interleaved(calls, rounds, time.perf_counter)
        found.append(
            {"runs": count} | {name: 1e3 * timing.best_s for name, timing in times.items()}
        )
    return found


def growth_with_segments(*, quick: bool) -> list[Figures]:
    """Cost of a step of vehicle and lumped tether against the number of segments."""
    steps, rounds = (50, 3) if quick else (200, 9)
    packed = cases.vehicle(effects=True, walls=False)
    for name in ("tether_pull", "tether_drag_area", "tether_anchor"):
        write(packed.vector, name, 0.0)
    commands = cases.multisine(steps)
    found = []
    for count in (5, 10) if quick else (2, 5, 10, 15, 20, 30, 40):
        tether = LumpedMassTether(
            length_m=40.0,
            segments=count,
            diameter_m=0.012,
            mass_kgpm=0.12,
            normal_drag=1.2,
            tangential_drag=0.02,
            axial_stiffness_n=2e4,
            density_kgpm3=1000.0,
            gravity_mps2=cases.GRAVITY_MPS2,
        )

        # the first run finds the shape at rest, which is not what is timed
        before, hanging = fly_tethered(packed, commands, tether, dt_s=DT_S, start=cases.START)
        fly = partial(
            fly_tethered,
            packed,
            commands,
            tether,
            dt_s=DT_S,
            start=before.final_state,
            tether_start=hanging.final,
        )
        substeps = float(fly()[1].substeps.mean())
        calls: dict[str, Callable[[], object]] = {
            "tethered": fly,
            "free": _kernel(packed, steps, "rk4"),
        }
        times = interleaved(calls, rounds)
        us = _each(times, dict.fromkeys(calls, steps), lambda t: t.median_s)
        found.append(
            {
                "segments": count,
                "substeps": substeps,
                "us_per_step": us["tethered"],
                "us_per_substep": us["tethered"] / substeps,
                "free_us_per_step": us["free"],
            }
        )
    return found


def sensitivity(*, quick: bool) -> Figures:
    """64 runs with other parameters, the Jacobian of each, and its error against complex steps."""
    steps, runs, rounds = (300, 4, 3) if quick else (2000, 64, 9)
    parameters = FORTY_PARAMETERS[::5] if quick else FORTY_PARAMETERS
    packed, commands = cases.vehicle(effects=True), cases.multisine(steps)
    generator = np.random.default_rng(1)
    scale = np.array([parameter_scale(packed.vector, *parameter) for parameter in parameters])
    vectors = [_perturbed(packed, parameters, generator) for _ in range(runs)]
    method: Method = "semi_implicit"
    options: dict[str, Any] = {"dt_s": DT_S, "start": cases.START, "method": method}
    differentiate = partial(jacobian, packed, commands, parameters, **options)

    def all_jacobians() -> None:
        for vector in vectors:
            differentiate(vector=vector)

    calls: dict[str, Callable[[], object]] = {
        "runs": partial(cases.run_many, packed, commands, vectors, **options),
        "jacobian": partial(differentiate, vector=vectors[0]),
    }
    times = interleaved(calls, rounds, time.perf_counter)
    times |= interleaved({"all": all_jacobians}, 1 if quick else 3, time.perf_counter)
    exact = complex_step_jacobian(packed, commands, parameters, **options)
    found = differentiate()
    errors = relative_errors(found, exact, scale)
    channel, worst = np.unravel_index(int(errors.argmax()), errors.shape)
    return {
        "steps": steps,
        "runs": runs,
        "parameters": len(parameters),
        "runs_ms": 1e3 * times["runs"].median_s,
        "jacobian_ms": 1e3 * times["jacobian"].median_s,
        "all_jacobians_s": times["all"].median_s,
        "largest_error": float(errors.max()),
        "median_error": float(np.median(errors)),
        "worst": f"{BODY_CHANNELS[channel]} by {parameters[worst][0]}[{parameters[worst][1]}]",
    }


def _perturbed(
    packed: PackedVehicle, parameters: tuple[tuple[str, int], ...], generator: np.random.Generator
) -> FloatArray:
    """Vector with each of the parameters moved by up to 5 % of its scale."""
    vector = packed.vector.copy()
    for name, index in parameters:
        change = 0.05 * parameter_scale(vector, name, index) * generator.uniform(-1.0, 1.0)
        if (name, index) not in {("added_mass", 4), ("buoyancy", 0)}:  # stay symmetric, and afloat
            vector[offset(name) + index] += change
    return vector


def save(path: Path, figures: Figures) -> None:
    """Write the figures as JSON."""
    path.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
