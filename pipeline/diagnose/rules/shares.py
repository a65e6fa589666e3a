"""Answers with their probabilities, and what the first of them leaves."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Share:
    """An answer and its probability."""

    name: str
    probability: float


@dataclass(frozen=True)
class Left:
    """What the first answer leaves.

    Attributes
    ----------
    force : float
        Outside force over a healthy vehicle's, on the worst axis.
    before, after : float
        Held-out gap over the healthy floor, without and with the answer.
    gap_closed : float or None
        Share of the gap that is gone; None where there is next to none.
    alike : tuple of str
        Effects whose signature lies too close to what the answer explains.
    alone : float
        Held-out gap with the effects of the answer alone, without the ordinary departures that go
        with them, over the one before.
    gap_there : float or None
        Gap over the healthy floor of the worst channel among those in which the effects act; None
        where there are none.
    gap_since : float or None
        The same since the healthy runs, where there are any.
    alone_after : float
        Held-out gap with the effects of the answer alone over the healthy floor.
    held_out : float
        Log evidence of the held-out windows for the answer over the best simpler one.
    was_unknown : bool
        The answer was named because it closes the gap, whatever force it leaves; see `after_all`.
    tested : bool
        The effects act in the held-out windows: else these say nothing of them.
    supply_known : bool
        A logged voltage, or shaft speeds, show the supply.
    """

    force: float
    before: float
    after: float
    gap_closed: float | None
    alike: tuple[str, ...] = ()
    alone: float = 0.0
    gap_there: float | None = None
    alone_after: float = 0.0
    held_out: float = 0.0
    was_unknown: bool = False
    supply_known: bool = True
    gap_since: float | None = None
    tested: bool = True
