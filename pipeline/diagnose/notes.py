"""What the reader should know of the data, and how much rests on what."""

from pipeline.diagnose.case import Case
from pipeline.diagnose.search import Search

_COSTS = {
    "velocity": "speed shows only in what it leads to; drag and current are hard to tell",
    "position": "a current and a scale error of the DVL are hard to tell",
    "specific_force": "added mass and thrust are hard to tell",
    "angular_velocity": "turning is known from attitude alone",
    "attitude": "trim and list cannot be judged",
    "depth": "buoyancy shows only in vertical speed",
}


def notes_on(case: Case, found: Search) -> tuple[str, ...]:
    """List what is missing and what it costs, what is ordinary, and which noise was widened."""
    have = {rows.channel.quantity for rows in found.setting.bench.stack.rows}
    notes = [f"no {name}: {cost}" for name, cost in _COSTS.items() if name not in have]
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
        f"{name}: readings scatter more than stated (variance {one.variance:.2f}, lag-1 "
        f"{one.lag1:.2f}); they count as if their noise were {one.widen:.2f} times larger"
        for name, one in found.noise.items()
        if one.widen > 1.0
    )
    return tuple(notes)


def _healthy_runs(count: int) -> str:
    return "1 healthy run" if count == 1 else f"{count} healthy runs"
