"""The answer of runs with an event: what was found once the event is known, and the event."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.events.event import ForceEvent
from pipeline.effects.effect import AXES
from pipeline.records.diagnosis import (
    NONE,
    UNKNOWN,
    VELOCITIES,
    Detail,
    DiagnosisRecord,
    FoundEvent,
    ParameterEstimate,
    RankedEffect,
    Verdict,
)

#: A step along other axes than heave of so many standard deviations is no weight alone.
_CLEAR = 5.0


def with_events(record: DiagnosisRecord, events: Sequence[ForceEvent]) -> DiagnosisRecord:
    """Tell the events that the runs of an answer know of.

    Where nothing else is the matter the first event is the answer, with the probability that there
    is nothing beside it; else events are told beside what was found.
    """
    seen = tuple(_record(one) for one in events)
    told = " ".join(f"{one.what}." for one in seen)
    if record.verdict.effects != (NONE,):
        text = f"{record.verdict.text or record.verdict.sentence} Besides: {told}"
        update = {"sentence": text, "text": text, "events": seen}
        verdict = record.verdict.model_copy(update=update)
        return record.model_copy(update={"verdict": verdict})
    first = events[0]
    effect = _effect_of(first)
    text = (
        f"{told} Apart from that the vehicle moves as it should "
        f"(probability {record.verdict.probability:.2f})."
    )
    verdict = Verdict(
        effects=(effect,),
        probability=record.verdict.probability,
        ambiguous_with=record.verdict.ambiguous_with,
        detail=Detail(axes=_axes(first)),
        sentence=text,
        since=record.verdict.since,
        runs=tuple(dict.fromkeys(one.run for one in events)),
        from_s=first.step.at_s,
        events=seen,
        text=text,
    )
    nothing = next(row for row in record.ranking if row.effect == NONE)
    ranked = nothing.model_copy(
        update={"effect": effect, "parameters": _sizes(first), "axes": _axes(first)}
    )
    others = [row for row in record.ranking if row.effect not in {NONE, effect}]
    without = RankedEffect(
        effect=NONE, probability=0.0, parameters={}, gap_closed=None, log_evidence=-first.step.nats
    )
    posterior = dict(record.evidence.posterior)
    if NONE in posterior:
        posterior = {f"{effect}@{first.step.at_s:g} s": posterior.pop(NONE), **posterior}
    return record.model_copy(
        update={
            "verdict": verdict,
            "ranking": (ranked, *others, without),
            "evidence": record.evidence.model_copy(update={"posterior": posterior}),
        }
    )


def _record(one: ForceEvent) -> FoundEvent:
    (low, high), at_s, worst = one.step.between_s, one.step.at_s, _worst(one)
    when = f"{at_s:.1f} s into {one.run} (between {low:.1f} and {high:.1f} s)"
    unit, note = "N" if worst < 3 else "N m", ""
    if one.body is not None:
        name = one.body.name
        what = f"{name} was let go {when}" if one.released else f"{name} was taken up {when}"
        done = "release" if one.released else "attach"
        note = f"events: [{{at_s: {at_s:.1f}, {done}: {name}}}]"
    else:
        size = f"{one.step.force[worst]:.3g} {unit} along {AXES[worst]}"
        what = f"A force that was not there before sets in {when}: {size}"
    force = one.seen.force[:, one.seen.axes.index(worst)]
    after = one.seen.begin_s >= at_s
    return FoundEvent(
        run=one.run,
        at_s=at_s,
        between_s=(low, high),
        what=what,
        axis=AXES[worst],
        unit=unit,
        time_s=tuple(one.seen.begin_s.tolist()),
        force=tuple(force.tolist()),
        step=(float(force[~after].mean()), float(force[after].mean())),
        note=note,
    )


def _effect_of(one: ForceEvent) -> str:
    if one.body is not None:
        return "payload"
    others = np.abs(one.step.force[[0, 1, 5]]) / np.maximum(one.step.std[[0, 1, 5]], 1e-9)
    upright = _worst(one) == 2 and others.max() < _CLEAR
    return "residual_buoyancy" if upright else UNKNOWN


def _worst(one: ForceEvent) -> int:
    return int(np.argmax(np.abs(one.step.force) / np.maximum(one.step.std, 1e-9)))


def _axes(one: ForceEvent) -> tuple[str, ...]:
    clear = np.abs(one.step.force) > _CLEAR * np.maximum(one.step.std, 1e-9)
    return tuple(VELOCITIES[axis] for axis, own in zip(AXES, clear, strict=True) if own)


def _sizes(one: ForceEvent) -> dict[str, ParameterEstimate]:
    """Return what changed, as the effect has it; of a module what its file says."""
    force, std = one.step.force[2], one.step.std[2]
    if _effect_of(one) == UNKNOWN:
        return {}
    if one.body is None:
        return {"force_n": _estimate(-force, 1.96 * std, "N")}
    share = 1.96 * std / max(abs(force), 1e-9) + one.left
    return {
        "mass_kg": _estimate(one.body.mass_kg, share * abs(one.body.mass_kg), "kg"),
        "volume_m3": _estimate(one.body.volume_m3, share * abs(one.body.volume_m3), "m^3"),
    }


def _estimate(value: float, half: float, unit: str) -> ParameterEstimate:
    return ParameterEstimate(
        value=float(value), unit=unit, ci95=(float(value - half), float(value + half))
    )
