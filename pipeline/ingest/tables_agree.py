"""Whether the tables of a folder agree: another unit, voltage, water or machine shows there."""

from collections.abc import Hashable, Mapping, Sequence

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Table

#: What of a table is compared: of what must be equal, a reading by what it depends on.
Curves = Mapping[Hashable, Mapping[float, float]]
#: Specimens of one type differ by a few per cent; their larger readings tell it.
ALIKE, _LARGER = 0.1, 0.2
#: No specimen differs by so much: one of them is in another unit, or of another machine.
_APART = 2.0
CONTRADICTS = "contradicts other tables"


def disagreement(
    tables: Sequence[Table], curves: Sequence[Curves], name: str
) -> tuple[list[Problem], frozenset[int]]:
    """Tell of the tables that differ from the others; `name` is what is compared.

    Returns what is wrong, and the numbers of the tables that cannot be fitted together: of two that
    are a factor apart nobody knows which is right; one of several thrusters is another than they.
    """
    shares: dict[int, float] = {}
    partners: dict[int, int] = {}
    for at, own in enumerate(curves):
        for key, curve in own.items():
            holders = [other for other, one in enumerate(curves) if one.get(key)]
            others = [other for other in holders if other != at or len(holders) > 2]
            share = share_of(curve, [curves[other][key] for other in others]) if curve else 1.0
            if abs(np.log(share)) > abs(np.log(shares.get(at, 1.0))):
                shares[at] = share
                partners[at] = others[0] if len(holders) == 2 else at
    odd = {at: one for at, one in shares.items() if abs(one - 1.0) > ALIKE}
    apart = frozenset(
        at
        for at, one in odd.items()
        if abs(np.log(one)) > np.log(_APART) or tables[at].block.thruster is not None
    )
    problems = []
    for at, share in odd.items():
        thruster, is_apart = tables[at].block.thruster, at in apart
        if at >= partners[at] or partners[at] not in odd:  # of two one message is enough
            who = "this table" if thruster is None else f'thruster "{thruster}"'
            place = tables[at].place
            say = place.error if is_apart and thruster is None else place.warning
            how = "what contradicts is kept but not" if is_apart else "all of it is"
            problems.append(
                say(
                    f"{who} gives {share:.2f} times the {name} of the others, where all else is "
                    f"equal; {how} fitted.",
                    "tests of one type of machine, in one unit, at one voltage, in one water.",
                    "Correct the unit, or take it out of the folder; sheets and columns are chosen "
                    f"in vehicle.yaml:\n  columns:\n    {tables[at].kind}: {{sheets: [...]}}",
                )
            )
    return problems, apart


def share_of(curve: Mapping[float, float], others: Sequence[Mapping[float, float]]) -> float:
    """Return the reading of one table over the middle one of others, where they overlap."""
    at = np.array(sorted(curve))
    every = [
        np.interp(at, sorted(one), [one[x] for x in sorted(one)], np.nan, np.nan)
        for one in others
        if one
    ]
    there = np.isfinite(every).any(axis=0) if every else np.zeros(at.size, np.bool_)
    if not there.any():
        return 1.0
    own = np.array([curve[x] for x in at[there].tolist()])
    middle = np.nanmedian(np.array(every)[:, there], axis=0)
    large = np.abs(middle) > _LARGER * np.abs(middle).max()
    share = float(np.median(own[large] / middle[large])) if large.any() else 1.0
    return share if share > 0.0 else 1.0
