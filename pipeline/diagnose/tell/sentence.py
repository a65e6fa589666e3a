"""The verdict in one sentence."""

from collections.abc import Sequence

from pipeline.effects.library import effects
from pipeline.records.diagnosis import Leftover, RankedEffect

#: An answer of less probability is not worth a word.
_UNLIKELY = 0.05


def sentence(
    names: Sequence[str],
    probability: float,
    ambiguous: Sequence[str],
    ranking: Sequence[RankedEffect],
    left: Leftover,
) -> str:
    """Say the verdict, its probability, and what it may be as well."""
    first = ranking[0] if ranking else None
    sure = f"(probability {probability:.2f})"
    if tuple(names) == ("none",) and "unknown" in ambiguous:
        # the gap may be one that few healthy vehicles have
        said = (
            "No effect: what the vehicle file states as uncertain suffices to explain these runs "
            f"{sure}"
        )
    elif tuple(names) == ("none",):
        said = (
            f"No effect: the vehicle file predicts these runs as well as a healthy vehicle {sure}"
        )
    elif tuple(names) == ("unknown",):
        said = (
            f"Unknown: there is a gap that no effect of the library explains {sure}; "
            f"{_left_to_say(left)}"
        )
    else:
        places = {} if first is None else first.thrusters
        titles = " and ".join(
            f"{name} ({effects()[name].title})" + (f" at {places[name]}" if name in places else "")
            for name in names
            if name in effects()
        )
        values = ""
        if first is not None and first.parameters:
            values = ": " + ", ".join(
                f"{key} = {one.value:.3g}{'' if one.unit == '1' else ' ' + one.unit}"
                f" [{one.ci95[0]:.3g}, {one.ci95[1]:.3g}]"
                for key, one in first.parameters.items()
            )
            values += " (95 % intervals)"
        said = f"{titles} {sure}{values}"
        if "unknown" in names:
            said += (
                "; besides, there is a gap that no effect of the library explains: "
                f"{_left_to_say(left)}"
            )
        said += _alone_instead(ranking)
    if ambiguous:
        said += f". These runs cannot tell it from {', '.join(ambiguous)}"
    return said + "."


def _alone_instead(ranking: Sequence[RankedEffect]) -> str:
    """Say which effect of a pair may do without the other, where that is not out of question."""
    pair = set(ranking[0].effect.split("+")) if ranking else set()
    alone = [one for one in ranking if set(one.effect.split("+")) < pair]
    best = max(alone, key=lambda one: one.probability, default=None)
    if best is None or best.probability < _UNLIKELY:
        return ""
    return f"; {best.effect} alone has probability {best.probability:.2f}"


def _left_to_say(left: Leftover) -> str:
    return f"the force that is left lies mostly in {left.worst_axis}, {left.time_course}"
