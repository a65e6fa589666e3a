"""What the reader should know of the data, and how much rests on what."""

from collections.abc import Iterator, Sequence

from pipeline.diagnose.case import Case
from pipeline.diagnose.conclude.shaft_speeds import ShaftsSeen
from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.judging.hypotheses import prior_of
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.kinematics.dead_reckoning import MEASUREMENT
from pipeline.diagnose.linear.evidence import fit
from pipeline.identify.channel_noise import was_measured
from pipeline.records.run_table import RunTable

_COSTS = {
    "velocity": "speed shows only in what it leads to; drag and current are hard to tell",
    "position": "a current and a scale error of the DVL are hard to tell",
    "specific_force": "added mass and thrust are hard to tell",
    "angular_velocity": "turning is known from attitude alone",
    "attitude": "trim and list cannot be judged",
    "depth": "buoyancy shows only in vertical speed",
}
#: Standard deviations, and departures in half of what is plausible, from which on what no file
#: states is told.
_SURE, _MUCH = 3.0, 0.5


def notes_on(case: Case, found: Search, top: Candidate) -> tuple[str, ...]:
    """List what is missing and what it costs, what is ordinary, and which noise was widened."""
    have = {rows.channel.quantity for rows in found.setting.bench.stack.rows}
    absent = (name for name in _COSTS if name not in have)
    notes = [f"{name} was not measured: {_COSTS[name]}" for name in absent]
    notes.append(
        f"what is ordinary was learned from {_healthy_runs(len(case.healthy))}"
        if case.healthy
        else "no healthy runs were given: what is ordinary rests on the uncertainties and sensor "
        "figures of the vehicle file"
    )
    if case.errors is not None:
        wrong = ", ".join(case.errors.effects)
        notes.append(
            f"dead reckoning by the DVL disagrees with the measured place ({wrong}), whatever "
            "moves the vehicle: everything else was asked with that known"
        )
    notes.extend(
        f"{name}: readings scatter more than stated, or go together (variance "
        f"{one.variance:.2f}, lag-1 {one.lag1:.2f}); they count as if their noise were "
        f"{one.widen:.2f} times larger"
        for name, one in found.noise.items()
        if one.widen > 1.0
    )
    if found.setting.scatter.any():
        notes.append(
            "each run fits with somewhat other parameters than the others, so the model lacks "
            "something beside any effect; an effect counts as far as the runs agree on it"
        )
    notes.extend(_what_no_file_states(found, top))
    return tuple(notes)


def _what_no_file_states(found: Search, top: Candidate) -> Iterator[str]:
    best = fit(top.judged.found, prior_of(found.prior, top.finding))
    for one, mean, std in zip(found.setting.coordinates, best.mean, best.std, strict=True):
        if not one.effect.unstated or abs(mean) < max(_SURE * std, _MUCH):
            continue
        value = one.parameter.neutral + min(float(mean) * one.unit_size, 1.0)
        yield {
            "dead_share": f"{value:.0%} of the thrusters' dead zone comes before their lag, by "
            "these runs. The vehicle file says nothing of it, so that is no fault",
            "power": f"what lags in a thruster is the code to the power of {value:.2g}, by these "
            "runs. The vehicle file says nothing of it, so that is no fault",
            "fall": f"the lag of the thrusters falls with the code to the power of {value:.2g}, by "
            "these runs. The vehicle file says nothing of it, so that is no fault",
            "opposed_share": "against the motion thrusters give more than at rest, by "
            f"{value:.0%} of what they lose along it, by these runs. The vehicle file says "
            "nothing of it, so that is no fault",
        }[one.parameter.name]


def _healthy_runs(count: int) -> str:
    return "1 healthy run" if count == 1 else f"{count} healthy runs"


def stages_told(
    case: Case,
    runs: Sequence[RunTable],
    found: Search,
    answered: Answers,
    shafts: ShaftsSeen | None,
) -> dict[str, str]:
    """Say for each stage what it had and what came out; but for the shafts all are one likelihood.

    `shafts` is what their speeds showed of the supply.
    """

    def has(quantity: str) -> bool:
        return any(was_measured(run, quantity) for run in runs)

    told = {}
    others = [q for q in ("position", "specific_force", "depth") if has(q)]
    if not has("velocity"):
        told["kinematics"] = "skipped: no velocity over ground was measured"
    elif not others:
        told["kinematics"] = "skipped: nothing to compare the DVL with"
    elif case.errors is not None:
        against = [name for name in others if name != "specific_force"]
        told["kinematics"] = (
            f"dead reckoning by the DVL against {', '.join(against)}, whatever moves the vehicle: "
            f"{', '.join(case.errors.effects)}, log evidence {case.errors.log_evidence:.0f} over a "
            "DVL that is well; what follows was asked beside it"
        )
    else:
        total = sum(one.probability for one in answered.ranking if one.name in MEASUREMENT)
        told["kinematics"] = (
            f"DVL against {', '.join(others)}: probability {total:.2f} of a measurement effect"
        )
    if has("voltage"):
        told["actuators"] = "supply voltage compared with its nominal value and the load"
    elif shafts is not None:
        told["actuators"] = (
            f"the shafts of {shafts.thrusters.size} thrusters turn as with {shafts.middle:.1%} of "
            f"their codes, by {shafts.against}; a healthy one differs by {shafts.deviation:.1%}"
        )
    elif has("shaft_speed"):
        told["actuators"] = (
            "skipped: no supply voltage was measured, and neither the bench nor healthy runs say "
            "how fast the shafts should turn"
        )
    else:
        told["actuators"] = "skipped: neither supply voltage nor shaft speeds were measured"
    told["dynamics"] = (
        f"{int(found.chosen.sum())} windows of {case.name}, "
        f"{len(found.groups)} effects and targets tried"
    )
    return told
