"""The plan of a campaign: which case stands under which number.

Strata and their shares follow from the number alone, so any case can be made again by itself, and a
campaign that is stopped goes on where it was.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.blind.generate import CaseSpec
from pipeline.blind.outside import TROUBLES
from pipeline.blind.subject import BlindSubject, possible_effects

#: Case numbers are added to this; a campaign's seed times `SEED_STRIDE` comes on top.
FIRST_SEED = 1_000_000
SEED_STRIDE = 10_000_000
#: Length of each run of a case. [s]
RUN_S = 60.0
#: Gap ratios that are aimed at.
SEVERITIES = (2.0, 6.0, 20.0)
#: Kinds of case and their parts of a campaign.
SHARES = {"none": 300, "single": 300, "outside": 100, "pair": 100, "leave_one_out": 48}
_KIND_ORDER = tuple(SHARES)
_SETS = ("trial", "work", "bench", "trial", "unseen", "transit")
#: What may be missing: mostly nothing.
_MISSING: tuple[tuple[str, ...], ...] = (
    (),
    (),
    (),
    (),
    ("dvl",),
    ("position",),
    ("shaft_speed", "voltage"),
)
#: Pairs that are the same answer twice, or of which one hides the other.
_NOT_TOGETHER = frozenset(
    {
        frozenset({"coriolis_omitted", "advance_speed_loss"}),
        frozenset({"residual_buoyancy", "payload"}),
        frozenset({"cg_shift", "payload"}),
    }
)


@dataclass(frozen=True)
class Numbered:
    """A case of a campaign: its number, the vehicle and the specification."""

    number: int
    vehicle: str
    spec: CaseSpec

    @property
    def name(self) -> str:
        """Name of its folder; it says nothing of what the case is."""
        return f"case_{self.number:05d}"


def case_of(
    number: int,
    subjects: dict[str, BlindSubject],
    seed: int,
    *,
    run_s: float = RUN_S,
) -> Numbered:
    """Return the case with a number, of a campaign's seed; vehicles, by name, take turns.

    `run_s` is the length of each of its runs [s].
    """
    own = FIRST_SEED + number + SEED_STRIDE * seed
    rng = np.random.default_rng([own, 17])
    kind, rank = _kind_of(number)
    names = tuple(subjects)
    vehicle = names[rank % len(names)]
    effects = possible_effects(subjects[vehicle])
    healthy = 3 if rng.random() < 0.5 else 0
    manoeuvres = str(rng.choice(_SETS if kind != "none" else (*_SETS, "unseen", "unseen")))
    missing = _MISSING[int(rng.integers(len(_MISSING)))]
    severity = SEVERITIES[int(rng.integers(len(SEVERITIES)))]
    what: tuple[str, ...] = ()
    if kind in ("single", "leave_one_out"):
        # every effect as often as every other one, in an order that is not the alphabet's: a
        # campaign that is stopped early has met some of all kinds
        order = np.random.default_rng([seed, len(effects)]).permutation(len(effects))
        what = (effects[int(order[(rank // len(names)) % len(effects)])],)
    elif kind == "outside":
        what = (TROUBLES[(rank // len(names)) % len(TROUBLES)],)
    elif kind == "pair":
        what = _pair(effects, rng)
    if any(one.startswith("dvl_") for one in what):
        missing = tuple(one for one in missing if one != "dvl")
    return Numbered(
        number,
        vehicle,
        CaseSpec(kind, what, severity, manoeuvres, healthy, missing, duration_s=run_s, seed=own),
    )


def _kind_of(number: int) -> tuple[str, int]:
    """Kind of a case and its rank within the kind; the kinds are spread evenly over the numbers."""
    total = sum(SHARES.values())
    cycle, place = divmod(number, total)
    # each kind at even distances: the place of its k-th case is (k + 1/2) total / share
    slots = sorted(
        ((k + 0.5) / share, _KIND_ORDER.index(kind), kind, k)
        for kind, share in SHARES.items()
        for k in range(share)
    )
    _, _, kind, k = slots[place]
    return kind, cycle * SHARES[kind] + k


def _pair(effects: tuple[str, ...], rng: np.random.Generator) -> tuple[str, str]:
    while True:
        one, other = (str(name) for name in rng.choice(effects, size=2, replace=False))
        if frozenset({one, other}) not in _NOT_TOGETHER:
            return min(one, other), max(one, other)
