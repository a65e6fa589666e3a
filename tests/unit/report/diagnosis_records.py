"""A diagnosis as the engine writes it, of made-up curves."""

import numpy as np

from pipeline.records.diagnosis import (
    ChannelGap,
    ChannelNoiseCheck,
    Detail,
    DiagnosisRecord,
    Evidence,
    Gap,
    GapFigures,
    Leftover,
    NextRun,
    ParameterEstimate,
    RankedEffect,
    RegimeGap,
    RegimeShare,
    Series,
    Shrink,
    ShrinkFigures,
    TimeShare,
    Verdict,
    Where,
)

UNITS = {
    "u": "m/s", "v": "m/s", "w": "m/s", "p": "rad/s", "q": "rad/s", "r": "rad/s",
    "phi": "rad", "theta": "rad", "psi": "rad", "z": "m", "x": "m", "y": "m",
}  # fmt: skip
RATIOS = dict(
    zip(UNITS, (1.2, 0.9, 14.3, 1.0, 2.1, 1.0, 0.8, 2.6, 1.1, 31.0, 1.2, 0.97), strict=True)
)
FLOOR = 0.01


def series(run: str, channel: str, *, windows: int = 30, seed: int = 0) -> tuple[Series, ...]:
    """Windows of 6 s at 5 Hz: what was measured, a model that drifts off, and one that does not."""
    generator = np.random.default_rng(seed)
    found = []
    for number in range(windows):
        time_s = 6.0 * number + np.arange(0.0, 6.0, 0.2)
        measured = np.sin(0.2 * time_s) * (3.0 if channel == "psi" else 0.3)
        noise = 0.004 * generator.standard_normal(time_s.size)
        off = RATIOS[channel] * FLOOR * (time_s - time_s[0]) / 4.0
        found.append(
            Series(
                run=run,
                channel=channel,
                unit=UNITS[channel],
                time_s=tuple(time_s.tolist()),
                measured=tuple((measured + noise).tolist()),
                before=tuple((measured + off).tolist()),
                after=tuple((measured + 0.1 * off).tolist()),
            )
        )
    return tuple(found)


def gap(channel: str, ratio: float) -> ChannelGap:
    def at(factor: float) -> GapFigures:
        own = 1.0 + (ratio - 1.0) * factor
        return GapFigures(rmse=own * FLOOR, sensor_floor=0.004, healthy_floor=FLOOR, ratio=own)

    return ChannelGap(
        **at(1.0).model_dump(),
        unit=UNITS[channel],
        horizons={"0.5": at(0.2), "2": at(0.7), "10": at(1.2), "run": at(1.6)},
    )


def regimes() -> tuple[RegimeGap, ...]:
    found = []
    for name, unit, edges in (
        ("speed_mps", "m/s", (0.0, 0.2, 0.6, 1.3)),
        ("turn_rate_radps", "rad/s", (0.0, 0.02, 0.1, 0.4)),
        ("depth_m", "m", (0.8, 1.4, 1.9, 3.1)),
        ("command_sign", "1", (-1.0, -0.2, 0.3, 1.0)),
    ):
        for number in range(3):
            own = {c: 1 + (r - 1) * (0.6 + 0.4 * number) for c, r in RATIOS.items()}
            found.append(
                RegimeGap(
                    regressor=name,
                    unit=unit,
                    range=(edges[number], edges[number + 1]),
                    share_of_time=1 / 3,
                    ratios=own,
                )
            )
    return tuple(found)


def ranked(effect: str, probability: float, evidence: float, **more: object) -> RankedEffect:
    values: dict[str, object] = {"parameters": {}, "gap_closed": None, **more}
    return RankedEffect(effect=effect, probability=probability, log_evidence=evidence, **values)  # type: ignore[arg-type]


def estimate(value: float, unit: str, half: float) -> ParameterEstimate:
    return ParameterEstimate(value=value, unit=unit, ci95=(value - half, value + half))


def diagnosis(
    *, channels: tuple[str, ...] = ("u", "w", "theta", "psi", "z"), windows: int = 30
) -> DiagnosisRecord:
    """Residual buoyancy, not quite to be told from a payload."""
    runs = ("pool-3",)
    buoyancy = {"force_n": estimate(4.12, "N", 0.31)}
    return DiagnosisRecord(
        vehicle="mmt300",
        runs=("pool-1", "pool-2"),
        holdout=runs,
        gap=Gap(
            channels={name: gap(name, ratio) for name, ratio in RATIOS.items()},
            where=Where(
                channels=("z", "w", "theta"),
                regimes=(
                    RegimeShare(
                        regressor="speed_mps",
                        unit="m/s",
                        range=(0.0, 0.2),
                        share=0.61,
                        share_of_time=0.33,
                    ),
                ),
                times=(TimeShare(run="pool-1", from_s=0.0, to_s=174.0, share=0.52),),
            ),
            by_regime=regimes(),
        ),
        verdict=Verdict(
            effects=("residual_buoyancy",),
            probability=0.962,
            ambiguous_with=("payload",),
            detail=Detail(),
            sentence="residual_buoyancy (lighter or heavier in water than stated) (probability "
            "0.96): force_n = 4.12 N [3.81, 4.43]. These runs cannot tell it from payload.",
        ),
        ranking=(
            ranked("residual_buoyancy", 0.962, 48.2, parameters=buoyancy, gap_closed=0.94),
            ranked(
                "payload",
                0.031,
                44.9,
                parameters={
                    "mass_kg": estimate(1.4, "kg", 0.9),
                    "volume_m3": estimate(1.8e-3, "m^3", 4e-4),
                },
                gap_closed=0.92,
            ),
            ranked("cg_shift+residual_buoyancy", 0.006, 47.0, gap_closed=0.945),
            ranked("unknown", 8e-4, 30.0),
            ranked("tether", 1e-4, 22.0, gap_closed=0.4),
            ranked("thruster_degraded", 1e-5, 9.0, thruster="upper", gap_closed=0.1),
            ranked("added_mass", 1e-7, 3.0, axes=("heave",), gap_closed=-0.03),
            ranked("none", 1e-12, 0.0),
        ),
        shrink=Shrink(
            before=9.4,
            after=1.5,
            noise_floor=1.0,
            gap_closed=0.94,
            ci95=(0.9, 0.97),
            channels={
                name: ShrinkFigures(
                    before=r * FLOOR,
                    after=0.012,
                    noise_floor=FLOOR,
                    gap_closed=0.9 if r > 1.1 else None,
                    ci95=None,
                )
                for name, r in RATIOS.items()
            },
            held_out="the run pool-3, given with --holdout",
        ),
        confusable=(("residual_buoyancy", "payload", 0.995), ("tether", "current", 0.93)),
        next_run=NextRun(
            manoeuvre="heave_steps",
            separates=("residual_buoyancy", "payload"),
            expected_separation_sigma=7.3,
        ),
        leftover=Leftover(
            axes={"surge": 0.4, "sway": 0.3, "heave": 1.1, "roll": 0.2, "pitch": 0.6, "yaw": 0.3},
            worst_axis="heave",
            time_course="about alike all the time",
            depends_on="speed_mps",
            correlation=-0.55,
        ),
        evidence=Evidence(
            windows=58,
            window_s=6.0,
            readings=41200,
            linearisations=2,
            force_scale=0.9,
            noise={
                "velocity": ChannelNoiseCheck(variance=1.04, lag1=0.03, widened_by=1.0),
                "depth": ChannelNoiseCheck(variance=1.6, lag1=0.22, widened_by=1.41),
            },
            stages={
                "kinematics": "velocity, gyro, attitude and depth agree: no measurement effect",
                "actuators": "skipped: neither shaft speed nor current was measured",
                "dynamics": "a steady force of 4 N down",
            },
            calibrated="thresholds of 600 generated cases, seeds 1 to 600",
            healthy_runs=(),
        ),
        series=tuple(
            one
            for number, channel in enumerate(channels)
            for one in series(runs[0], channel, windows=windows, seed=number)
        ),
        notes=("Neither shaft speed nor current was measured: a thruster's loss shows late.",),
        elapsed_s=17.4,
    )
