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
    """Tell of the table that differs most from the others; `name` is what is compared.

    Returns what is wrong, and the numbers of the tables that cannot be fitted together: of two that
    are a factor apart nobody knows which is right.
    """
    shares: dict[int, float] = {}
    for at, own in enumerate(curves):
        for key, curve in own.items():
            every = [one[key] for one in curves if one.get(key)]
            others = [one[key] for other, one in enumerate(curves) if other != at and one.get(key)]
            share = share_of(curve, every if len(every) > 2 else others) if curve else 1.0
            if abs(np.log(share)) > abs(np.log(shares.get(at, 1.0))):
                shares[at] = share
    odd = max(shares, key=lambda at: abs(shares[at] - 1.0), default=None)
    if odd is None or abs(shares[odd] - 1.0) <= ALIKE:
        return [], frozenset()
    apart = frozenset(at for at, one in shares.items() if abs(np.log(one)) > np.log(_APART))
    expected = "tests of one type of machine, in one unit, at one voltage, in one water."
    remedy = (
        "Correct the unit, or take it out of the folder; sheets of a workbook are chosen in "
        f"vehicle.yaml:\n  columns:\n    {tables[odd].kind}: {{sheets: [...]}}"
    )
    place, share = tables[odd].place, shares[odd]
    if apart:
        what = (
            f"this table gives {share:.3g} times the {name} of the others, where all else is "
            "equal; the tables that contradict are kept but not fitted."
        )
        return [place.error(what, expected, remedy)], apart
    what = (
        f"this table gives {share:.2f} times the {name} of the others, where all else is equal; "
        "all of them are fitted together."
    )
    return [place.warning(what, expected, remedy)], apart


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
