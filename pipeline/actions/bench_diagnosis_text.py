"""The diagnosis of a mooring table as text for a terminal."""

from pipeline.language import as_it_is
from pipeline.records.bench_diagnosis import BenchDiagnosisRecord
from pipeline.report.diagnosis_words import closed_text, identifiers, verdict_sentence


def bench_text(record: BenchDiagnosisRecord) -> str:
    """Verdict, where the gap is, ranking, how far it shrinks, what to measure next."""
    lines = [verdict_sentence(record.verdict), ""]
    lines.append("gap (over what a healthy thruster may leave):")
    lines += [
        f"  {name}: {one.rmse:.3g} {one.unit} ({one.ratio:.2f})"
        for name, one in record.gap.channels.items()
    ]
    lines += [
        f"  {row.share:.0%} of it at codes {row.range[0]:.0f} to {row.range[1]:.0f}"
        for row in record.gap.where.regimes[:2]
    ]
    lines.append("")
    for answer in record.ranking[:5]:
        values = ", ".join(
            f"{name} {one.value:.4g} [{one.ci95[0]:.4g}, {one.ci95[1]:.4g}] {one.unit}"
            for name, one in answer.parameters.items()
        )
        effect = as_it_is(answer.effect)
        lines.append(f"  {answer.probability:6.1%}  {effect}  {values}".rstrip())
    shrink = record.shrink
    share = shrink.gap_closed
    closed = "" if share is None else f", {closed_text(share)} of the gap closed"
    lines += ["", f"held out ({shrink.held_out}):"]
    lines.append(
        f"  {shrink.before:.3g} N before, {shrink.after:.3g} N after, where a healthy thruster may "
        f"leave {shrink.noise_floor:.3g} N{closed}"
    )
    if record.next_run is not None:
        one = record.next_run
        lines.append(
            f"measure next: {one.manoeuvre}; separates {identifiers(one.separates)} by "
            f"{one.expected_separation_sigma:.1f} sigma"
        )
    lines += [f"note: {note}" for note in record.notes]
    return "\n".join(lines)
