"""All verdicts of a campaign: rates by severity band, never one pooled figure."""

from collections.abc import Callable, Sequence

import numpy as np

from pipeline.blind.goals import FALSE_ALARMS, SMALL_GAP, Miss, against_goals, missed
from pipeline.blind.rates import QuantileFigure, Rate, at_least, at_most, between, figure, rate
from pipeline.blind.verdict_score import HARDLY_A_GAP, CaseScore, asked
from pipeline.records.base import Record

#: Names and limits of the severity bands, in gap over healthy floor.
BANDS = (("1-3", 1.0, 3.0), ("3-10", 3.0, 10.0), (">10", 10.0, np.inf))
#: Likewise of pairs, by what the effect that shows less adds to the other one.
PAIR_BANDS = (
    (f"below {HARDLY_A_GAP:g}", 1.0, HARDLY_A_GAP),
    (f"{HARDLY_A_GAP:g}-3", HARDLY_A_GAP, 3.0),
    (">3", 3.0, np.inf),
)


class Confusion(Record):
    """How often each truth (row) got each answer (column), single effects and none and unknown."""

    truths: tuple[str, ...]
    answers: tuple[str, ...]
    counts: tuple[tuple[int, ...], ...]


class Score(Record):
    """The result of a campaign: `goals` has a row for each goal, `rates` are strata and bands."""

    cases: int
    refused: int
    goals: tuple[Rate, ...]
    rates: tuple[Rate, ...]
    figures: tuple[QuantileFigure, ...] = ()
    confusion: Confusion


class CampaignScore(Score):
    """The result of a blind check on generated cases; `missed` are those that count against it."""

    missed: tuple[Miss, ...]


def score_campaign(scores: Sequence[CaseScore]) -> CampaignScore:
    """Put the scored cases of a campaign together."""
    rates: list[Rate] = []
    single = [one for one in scores if one.kind == "single"]
    for name, low, high in BANDS:
        inside = [one for one in single if low <= one.gap_ratio < high]
        rates += _of_band(name, inside, strict=low >= 3.0)
    shown = [one for one in single if HARDLY_A_GAP <= one.gap_ratio < BANDS[0][2]]
    where = f"gap {HARDLY_A_GAP:g}-3"
    rates += asked(shown, where, ("truth in the answer set", "in_set"))
    for name, low, high in PAIR_BANDS:
        rates += _of_pairs(name, [_ for _ in scores if low <= (_.smaller_gap or 0.0) < high])
    for told, word in ((True, "with healthy runs"), (False, "without healthy runs")):
        rates += _of_healthy([one for one in scores if one.healthy == told], word)
    for missing in sorted({",".join(one.missing) for one in single if one.missing}):
        part = [one for one in single if ",".join(one.missing) == missing and one.gap_ratio >= 3]
        rates += asked(part, f"gap >= 3, no {missing}", ("right effect first", "first_right"))
    for vehicle in sorted({one.vehicle for one in scores}):
        part = [one for one in single if one.vehicle == vehicle and one.gap_ratio >= 3]
        rates += asked(part, f"gap >= 3, {vehicle}", ("right effect first", "first_right"))
    widths = [
        width.half_width_share for one in scores for width in one.intervals if one.gap_ratio >= 3
    ]
    covered = [width.inside for one in scores for width in one.intervals]
    rates.append(rate("95 % intervals cover the truth", "all", covered, between(0.93, 0.97)))
    figures = (
        figure(
            "half-width of an interval over the truth",
            "gap >= 3",
            widths,
            "median <= 10 %",
            lambda median, _p90, _mean: median <= 0.10,
        ),
        figure(
            "held-out gap after over the healthy floor",
            "right answers",
            (one.after_over_floor for one in scores),
            "median <= 1.10, p90 <= 1.25",
            lambda median, p90, _mean: median <= 1.10 and p90 <= 1.25,
        ),
        figure(
            "explainable gap closed on held-out runs",
            "right answers, gap >= 3",
            (one.gap_closed for one in scores if one.gap_ratio >= 3),
            "median >= 90 %",
            lambda median, _p90, _mean: median >= 0.9,
        ),
        figure(
            "answers in the set",
            "single effects that can be told apart",
            (float(one.set_size) for one in single if one.separable),
            "mean <= 1.3",
            lambda _median, _p90, mean: mean <= 1.3,
        ),
        figure(
            "seconds of a diagnosis",
            "as the campaign ran, one thread each",
            (one.elapsed_s for one in scores),
            "<= 30 s",
            lambda _median, p90, _mean: p90 <= 30.0,
        ),
    )
    return CampaignScore(
        cases=len(scores),
        refused=sum(bool(one.refused) for one in scores),
        goals=against_goals(scores),
        rates=tuple(rates),
        figures=figures,
        confusion=confusion(scores, lambda one: one_word(one.verdict)),
        missed=missed(scores),
    )


def _of_band(name: str, inside: Sequence[CaseScore], *, strict: bool) -> list[Rate]:
    """Single effects of one severity band."""
    where = f"gap {name}"
    apart = [one for one in inside if one.separable]
    alike = [one for one in inside if one.separable is False]
    goal = at_least(0.95) if strict else SMALL_GAP
    return [
        *asked(
            apart,
            f"{where}, separable",
            ("right effect first", "first_right", goal),
            ("right, or abstains", "right_or_abstains"),
        ),
        *asked(alike, f"{where}, not separable", ("right group", "group_right", at_least(0.95))),
        *asked(inside, f"{where}, all", ("right effect first", "first_right")),
        *asked(
            inside,
            where,
            ("truth in the answer set", "in_set", at_least(0.99)),
            ("confidently wrong", "confidently_wrong"),
            ("right thruster or axis", "detail_right"),
            ("right channel", "channel_right", at_least(0.98)),
            ("right regime", "regime_right", at_least(0.9)),
        ),
    ]


def _of_pairs(name: str, inside: Sequence[CaseScore]) -> list[Rate]:
    """Pairs of which the effect that shows less has a gap of one band."""
    return asked(
        inside,
        f"gap of the smaller one {name}",
        ("exact pair", "pair_exact"),
        ("truth in the answer set", "in_set"),
        ("at least one of the pair", "pair_any"),
        ("confidently wrong", "confidently_wrong"),
    )


def _of_healthy(part: Sequence[CaseScore], word: str) -> list[Rate]:
    """Strata that are scored with and without healthy runs apart."""
    kinds = {kind: [one for one in part if one.kind == kind] for kind in _KINDS}
    clear = [one for one in kinds["single"] if one.gap_ratio >= 3]
    unknown = ("unknown caught", "unknown_right")
    return [
        *asked(part, word, ("false alarm on none", "false_alarm", FALSE_ALARMS[word])),
        *asked(clear, f"gap >= 3, {word}", ("right effect first", "first_right")),
        *asked(
            kinds["pair"],
            word,
            ("exact pair", "pair_exact", at_least(0.80)),
            ("at least one of the pair", "pair_any", at_least(0.97)),
        ),
        *asked(kinds["outside"], f"outside the library, {word}", (*unknown, at_least(0.90))),
        *asked(
            (*kinds["single"], *kinds["pair"]),
            word,
            ("known cases called unknown", "called_unknown", at_most(0.03)),
        ),
        *asked(
            kinds["leave_one_out"],
            f"effect left out, {word}",
            unknown,
            ("confidently wrong", "confidently_wrong"),
        ),
    ]


_KINDS = ("single", "pair", "outside", "leave_one_out")


def one_word(effects: tuple[str, ...]) -> str:
    """Return the effect, or ``pair`` where there are several."""
    return effects[0] if len(effects) == 1 else "pair"


def confusion(scores: Sequence[CaseScore], answer: Callable[[CaseScore], str]) -> Confusion:
    """Count answers by truth; single effects with a gap, none, and what lies outside."""
    rows: dict[str, dict[str, int]] = {}
    for one in scores:
        if one.kind not in ("single", "none", "outside"):
            continue
        told = rows.setdefault(one_word(one.truth), {})
        told[answer(one)] = told.get(answer(one), 0) + 1
    last = ("none", "unknown", "pair", "refused")
    names = {name for row in rows.values() for name in row} | set(rows)
    order = [*sorted(names - set(last)), *(name for name in last if name in names)]
    truths = tuple(name for name in order if name in rows)
    return Confusion(
        truths=truths,
        answers=tuple(order),
        counts=tuple(tuple(rows[t].get(a, 0) for a in order) for t in truths),
    )
