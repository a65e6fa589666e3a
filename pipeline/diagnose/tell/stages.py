"""What each kind of evidence had to say: kinematics, actuators, dynamics."""

from collections.abc import Sequence

from pipeline.diagnose.case import Case
from pipeline.diagnose.conclude.shaft_speeds import ShaftsSeen
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.kinematics.dead_reckoning import MEASUREMENT
from pipeline.identify.channel_noise import was_measured
from pipeline.records.run_table import RunTable


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
