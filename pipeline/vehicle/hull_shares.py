"""What thrusters were found to have left behind a hull, as keys of the vehicle file."""

from collections.abc import Sequence

from pipeline.vehicle.frames import Change
from pipeline.vehicle.model_schema import HullShare, WakeFraction

#: Shares nearer to each other than this are one value for all thrusters.
_ALIKE = 1e-9
#: No share of a file is beyond this, either way.
_LARGEST = 0.999


def share_changes(
    section: HullShare, names: Sequence[str], left: Sequence[float], std: float | None = None
) -> dict[str, Change]:
    """Say what to write so that the file gives each thruster what it was found to have left.

    Parameters
    ----------
    section : HullShare
        Wake fraction or thrust deduction, as the file states it.
    names : sequence of str
        All thrusters of the vehicle.
    left : sequence of float
        Of each what is left: 1 - w of the inflow or 1 - t of the thrust. [1]
    std : float, optional
        Standard uncertainty common to all, where it is to be written too. [1]

    Examples
    --------
    >>> share_changes(WakeFraction(), ("port", "stbd"), (0.75, 0.75))
    {'model.wake_fraction.value': 0.25}
    """
    key = "wake_fraction" if isinstance(section, WakeFraction) else "thrust_deduction"
    taken = [min(max(1.0 - one, -_LARGEST), _LARGEST) for one in left]
    changes: dict[str, Change] = {}
    if max(taken) - min(taken) <= _ALIKE and not section.thrusters:
        changes[f"model.{key}.value"] = taken[0]
    else:
        for name, one in zip(names, taken, strict=True):
            changes[f"model.{key}.thrusters.{name}"] = one
    if std is not None:
        changes[f"model.{key}.sigma"] = std
    return changes
