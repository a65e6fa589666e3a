"""Which effects these runs cannot tell apart, before any answer: angles between signatures."""

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.diagnose.asking.hypotheses import Finding, Group
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.elimination import Marginal
from pipeline.types import FloatArray

#: Two effects whose signatures lie this close are one answer. [deg]
ONE_ANSWER_DEG = 10.0
#: A departure that the runs see with less than this many standard deviations has no signature.
_SEEN = 1.0


def _directions(ground: Marginal, members: Sequence[int]) -> FloatArray:
    """Basis (g, k) of an effect's departures, orthonormal in the information, if it is seen."""
    index = np.array(members, int)
    values, vectors = np.linalg.eigh(ground.information[np.ix_(index, index)])
    kept = values > _SEEN**2
    basis = np.zeros((ground.score.size, int(kept.sum())))
    basis[index] = vectors[:, kept] / np.sqrt(values[kept])
    return basis


def cosine(ground: Marginal, first: FloatArray, second: FloatArray) -> float:
    """Largest cosine between two sets of directions (g, k), each orthonormal."""
    if not first.shape[1] or not second.shape[1]:
        return 0.0
    return float(np.linalg.norm(first.T @ ground.information @ second, 2))


def confusable(
    ground: Marginal, groups: Mapping[Group, tuple[int, ...]], least: float = 0.9
) -> list[tuple[str, str, float]]:
    """List pairs of effects with the cosine of their angle, the closest first.

    The angle is the smallest between the signature of one parameter of one effect and all
    signatures of the other.
    """
    found: dict[tuple[str, str], float] = {}
    bases = {group: _directions(ground, members) for group, members in groups.items()}
    for first, members in groups.items():
        for second, basis in bases.items():
            if first[0] == second[0]:
                continue
            pair = (min(first[0], second[0]), max(first[0], second[0]))
            for one in members:
                value = cosine(ground, _directions(ground, [one]), basis)
                found[pair] = max(found.get(pair, 0.0), min(value, 1.0))
    return sorted(
        ((a, b, c) for (a, b), c in found.items() if c >= least), key=lambda row: (-row[2], row)
    )


def angle_to(ground: Marginal, departures: FloatArray, members: Sequence[int]) -> float:
    """Angle between what departures (g,) explain and an effect's signatures. [deg]."""
    direction = departures[:, None]
    size = float(np.sqrt((direction.T @ ground.information @ direction)[0, 0]))
    if size <= 0.0:
        return 90.0
    value = cosine(ground, direction / size, _directions(ground, members))
    return float(np.degrees(np.arccos(min(value, 1.0))))


def alike(
    ground: Marginal,
    finding: Finding,
    every: Sequence[Coordinate],
    groups: Mapping[Group, tuple[int, ...]],
) -> tuple[str, ...]:
    """Effects too close to what a finding explains; of two effects, to what either explains.

    Parameters
    ----------
    ground : Marginal
        Information about the departures.
    finding : Finding
        An effect or two.
    every : sequence of Coordinate
        The departures.
    groups : mapping
        Departures of each effect at each target.
    """
    departures = np.zeros(len(every))
    departures[list(finding.which)] = finding.mean
    close: list[str] = []
    for effect in finding.effects:
        own = np.array([one.effect.id == effect for one in every])
        explained = np.where(own, departures, 0.0)
        close.extend(
            other
            for (other, _), members in groups.items()
            if other not in finding.effects
            and angle_to(ground, explained, members) <= ONE_ANSWER_DEG
        )
    return tuple(dict.fromkeys(close))
