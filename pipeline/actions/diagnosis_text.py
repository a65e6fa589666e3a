"""The diagnosis of pool runs, or of a mooring table, as text for a terminal."""

from pipeline.language import as_it_is
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report.diagnosis_words import closed_text, identifiers, of_bench, verdict_sentence


def diagnosis_text(record: DiagnosisRecord) -> str:
    """Verdict, where the gap is, ranking, how far it shrinks, what to do next, notes."""
    lines = [verdict_sentence(record.verdict), ""]
    readings = "the codes" if of_bench(record) else "the time"
    gaps = sorted(record.gap.channels.items(), key=lambda item: -item[1].ratio)
    ratios = ", ".join(f"{name} {one.ratio:.2f}" for name, one in gaps)
    lines.append(f"gap over the healthy floor: {ratios}")
    lines.extend(
        f"  {row.share:.0%} of it where {row.regressor} is {row.range[0]:.3g} to "
        f"{_with_unit(f'{row.range[1]:.3g}', row.unit)} ({row.share_of_time:.0%} of {readings})"
        for row in record.gap.where.regimes[:3]
    )
    lines.append("")
    for answer in record.ranking[:5]:
        values = ", ".join(
            _with_unit(f"{name} {one.value:.4g} [{one.ci95[0]:.4g}, {one.ci95[1]:.4g}]", one.unit)
            for name, one in answer.parameters.items()
        )
        at = dict.fromkeys(answer.thrusters.values())
        where = f" at {' and '.join(at)}" if at else ""
        effect = as_it_is(answer.effect)
        lines.append(f"  {answer.probability:6.1%}  {effect}{where}  {values}".rstrip())
    shrink = record.shrink
    share = shrink.gap_closed
    closed = "" if share is None else f", {closed_text(share)} of the gap closed"
    floor = max(shrink.noise_floor, 1e-12) if of_bench(record) else 1.0
    before, after = shrink.before / floor, shrink.after / floor
    held = f"held out ({shrink.held_out}): {before:.2f} before, {after:.2f} after"
    lines += ["", f"{held}, in units of the healthy floor{closed}"]
    if record.next_run is not None:
        one = record.next_run
        separates = (
            f"{one.manoeuvre}, which separates {identifiers(one.separates)} by "
            f"{one.expected_separation_sigma:.1f} sigma"
        )
        bench = of_bench(record)
        lines.append(f"measure next: {separates}" if bench else f"fly next: {separates}")
    lines += [f"note: {note}" for note in record.notes]
    return "\n".join(lines)


def _with_unit(text: str, unit: str) -> str:
    """Write a unit behind a number; nothing where there is none."""
    return text if unit == "1" else f"{text} {unit}"
