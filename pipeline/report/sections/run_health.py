"""A pool run's page: warnings, what the run was, how sound its data are, what was flown."""

from datetime import UTC, datetime
from pathlib import PurePath

from pipeline.language import as_it_is
from pipeline.records.pool_run import ChannelSummary
from pipeline.records.run_arrays import MARKS
from pipeline.records.run_notes import RunNotes
from pipeline.report.blocks import Block, Bullets, Details, Links, Paragraph, Section, Table
from pipeline.report.numbers import fixed, general, percent, plural
from pipeline.report.plain_words import manoeuvre_words
from pipeline.report.run_results import RunResults
from pipeline.report.sections.warnings import note_blocks, problem_blocks
from pipeline.vehicle.run_notes import run_of

CLOCK_WORDS = {"header": "header stamp", "log": "log time", "field": "field of the message"}


def run_warnings_section(results: RunResults) -> Section:
    """Begin with what must be known before anything else is read."""
    blocks: list[Block] = []
    if results.stored is None:
        reason = results.why_not_read or "the log could not be read."
        blocks.append(Paragraph(f"Nothing could be read: {reason}", tone="error"))
    trial = results.trial
    if trial is not None:
        blocks += [Paragraph(text, tone="warning") for text in trial.warnings]
        if trial.why_not:
            blocks.append(Paragraph(f"Nothing was simulated: {trial.why_not}", tone="warning"))
    serious = [problem for problem in results.all_problems if problem.severity != "note"]
    notes = [problem for problem in results.all_problems if problem.severity == "note"]
    if serious and results.stored is not None:
        blocks += problem_blocks("Problems in the log", serious)
    elif results.stored is not None:
        blocks.append(Paragraph("No errors or warnings in the log."))
    blocks += note_blocks(notes)
    return Section("warnings", "Warnings", tuple(blocks))


def run_facts_section(results: RunResults) -> Section:
    """Say what the run was: log, time, length, notes of those who were there."""
    stored = results.stored
    rows = [("Log", results.shown_path)]
    if stored is not None:
        start = datetime.fromtimestamp(stored.start_time_ns / 1e9, UTC)
        rows += [
            ("Start", f"{start:%Y-%m-%d %H:%M:%S} UTC"),
            ("Length", f"{fixed(stored.duration_s, 1)} s"),
            ("Size", f"{general(stored.size_bytes / 1e6, 3)} MB"),
            ("Recorder", stored.writer or "not stated"),
            ("Closed by the recorder", "yes" if stored.complete else "no: read as far as it goes"),
        ]
        if stored.notes is not None:
            rows += _notes(stored.notes)
        rows += [
            (f"Log says: {name}", ", ".join(f"{k} {v}" for k, v in entries.items() if v)[:400])
            for name, entries in stored.metadata.items()
            if any(entries.values())
        ]
    blocks: list[Block] = [Table("The run", ("What", "Value"), tuple(rows))]
    if stored is not None and stored.notes is None:
        blocks.append(
            Paragraph(
                f"No notes: write {run_of(PurePath(results.shown_path))}.yaml beside the log "
                "(ballast, water, tether, who, what) and they stand here.",
                tone="note",
            )
        )
    if results.files:
        blocks.append(Links(results.files))
    return Section("run", "What the run was", tuple(blocks))


def _notes(notes: RunNotes) -> list[tuple[str, str]]:
    """Turn the notes into rows, as they were written; what was left open is left out."""
    found: list[tuple[str, str]] = []
    for name, value in notes.model_dump(mode="json", exclude={"file"}).items():
        text = _plain(value)
        if text:
            own = text if isinstance(value, bool) else as_it_is(text)
            found.append((f"Notes: {name.replace('_', ' ')}", own))
    return found


def _plain(value: object) -> str:
    if value is None or value in ("", [], {}):
        return ""
    if isinstance(value, dict):
        return ", ".join(f"{k} {_plain(v)}" for k, v in value.items() if _plain(v))
    if isinstance(value, list):
        return "; ".join(_plain(one) for one in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)


def run_health_section(results: RunResults) -> Section:
    """Show every channel with its rate, clock, gaps and marked readings, and every topic."""
    stored = results.stored
    if stored is None:
        return Section(
            "health", "Data health", (Paragraph("The log could not be read.", tone="error"),), False
        )
    table = Table(
        "Channels",
        (
            "Channel",
            "Topic",
            "Readings",
            "Rate [Hz]",
            "Longest gap [s]",
            "From [s]",
            "To [s]",
            "Clock",
            "Latency [ms]",
            "Marked",
        ),
        tuple(_channel_row(channel) for channel in stored.channels),
        row_classes=tuple(
            "warning" if _marked(channel) > 0.01 * channel.readings else ""
            for channel in stored.channels
        ),
        note="Marked readings stay in the log as they are; those that cannot be trusted are not "
        "used in what follows, and nothing is filled in for them.",
    )
    blocks: list[Block] = [table]
    seen = sorted({mark for channel in stored.channels for mark in channel.marks})
    if seen:
        blocks.append(
            Bullets(tuple(f"{mark.replace('_', ' ')}: {MARKS.get(mark, mark)}" for mark in seen))
        )
    if stored.notes_of_table:
        blocks.append(Bullets(stored.notes_of_table))
    blocks.append(
        Details(
            f"{plural(len(stored.topics), 'topic')} in the log",
            (
                Table(
                    "Topics",
                    ("Topic", "Message", "Encoding", "Messages", "Used for"),
                    tuple(
                        (
                            topic.topic,
                            topic.message_type,
                            topic.encoding,
                            str(topic.messages),
                            ", ".join(name.replace("_", " ") for name in topic.used_for)
                            or topic.why_not
                            or "not used",
                        )
                        for topic in stored.topics
                    ),
                ),
            ),
        )
    )
    return Section("health", "Data health", tuple(blocks))


def _channel_row(channel: ChannelSummary) -> tuple[str, ...]:
    latency = channel.clock.latency_s
    marks = ", ".join(
        f"{name.replace('_', ' ')} {count}" for name, count in sorted(channel.marks.items())
    )
    return (
        channel.name.replace("_", " "),
        channel.read.topic,
        str(channel.readings),
        "–" if channel.rate_hz is None else general(channel.rate_hz, 3),
        general(channel.longest_gap_s, 3),
        fixed(channel.first_s, 1),
        fixed(channel.last_s, 1),
        CLOCK_WORDS[channel.clock.used],
        "–" if latency is None else fixed(1e3 * latency, 1),
        marks or "none",
    )


def _marked(channel: ChannelSummary) -> int:
    return max(channel.marks.values(), default=0)


def manoeuvres_section(results: RunResults) -> Section:
    """List the manoeuvres found, and how long each thruster was at its limit."""
    trial = results.trial
    blocks: list[Block] = []
    found = trial.manoeuvres if trial is not None else ()
    if found:
        blocks.append(
            Table(
                "Manoeuvres",
                ("Manoeuvre", "From [s]", "To [s]", "Confidence", "What was seen"),
                tuple(
                    (
                        manoeuvre_words(stretch.name),
                        fixed(stretch.from_s, 1),
                        fixed(stretch.to_s, 1),
                        percent(stretch.confidence),
                        stretch.sentence,
                    )
                    for stretch in found
                ),
            )
        )
    else:
        blocks.append(Paragraph("No manoeuvre was recognised."))
    if trial is not None and trial.commands_at_limit:
        limits = ", ".join(
            f"{name} {percent(share)}" for name, share in trial.commands_at_limit.items()
        )
        blocks.append(Paragraph(f"Share of the time at the end of the range of codes: {limits}."))
    return Section("manoeuvres", "Commands and manoeuvres", tuple(blocks))
