"""What an engineer should know first of a run that was compared with its simulation."""

from pipeline.records.trial import RunTrial

#: A thruster this long at the end of its range has no control left. [share of the time]
LONG_AT_LIMIT = 0.2
#: Gaps in the commands of less than this in all are not worth a warning. [s]
LONG_WITHOUT_S = 5.0


def trial_warnings(trial: RunTrial) -> tuple[str, ...]:
    """Return sentences, the most serious first."""
    found = []
    losing: dict[str, list[str]] = {}
    for one in trial.channels:
        if one.loses:
            losing.setdefault(one.quantity.replace("_", " "), []).append(one.channel)
    if losing:
        names = [f"{quantity} ({', '.join(own)})" for quantity, own in losing.items()]
        found.append(
            f"Over {trial.horizon_s:g} s the model predicts {', '.join(names)} "
            "worse than keeping the last reading does: its thrust, damping or axes are wrong "
            "there, or the channel is mapped with a wrong sign or unit."
        )
    if trial.windows_left_out:
        found.append(
            f"{trial.windows_left_out} of {trial.windows + trial.windows_left_out} windows were "
            "not predicted: readings are missing there, or the simulation ran away."
        )
    if trial.without_commands_s > LONG_WITHOUT_S:
        found.append(
            f"For {trial.without_commands_s:.0f} s of the run there are no commands: nothing is "
            "predicted there."
        )
    found += [
        f"Thruster {name} is at the end of its range for {share:.0%} of the time."
        for name, share in trial.commands_at_limit.items()
        if share > LONG_AT_LIMIT
    ]
    return tuple(found)
