"""What a check says of a pool run, as lines for a person."""

from datetime import UTC, datetime

from pipeline.check.findings import NotesFinding, RunFinding
from pipeline.records.pool_run import ChannelSummary, PoolRunRecord
from pipeline.records.run_notes import RunNotes

_MAX_TOPICS = 40


def run_text(run: RunFinding) -> str:
    """Return the lines of one run: when, channels, rates, gaps, clocks, topics that are left."""
    if run.record is None:
        return f"{run.file}\n  cannot be used, see below"
    record = run.record
    told = "" if run.kind_from == "folder" else " (recognised by its name)"
    lines = [run.file, f"  pool run{told}: {_what_it_is(record)}"]
    if record.notes is not None:
        lines += [f"  notes: {line}" for line in _notes(record.notes)]
    for channel in record.channels:
        lines += _channel(channel)
    left = [topic for topic in record.topics if not topic.used_for]
    if left:
        lines.append(f"  topics that are not used: {len(left)}")
    for topic in left[:_MAX_TOPICS]:
        kind = topic.message_type or "no schema"
        why = f": {topic.why_not}" if topic.why_not else ""
        lines.append(
            f"    {topic.topic} ({kind}, {topic.encoding}, {topic.messages} messages){why}"
        )
    if len(left) > _MAX_TOPICS:
        lines.append(f"    and {len(left) - _MAX_TOPICS} more")
    return "\n".join(lines)


def notes_text(finding: NotesFinding) -> str:
    """Return the lines of notes that were asked for alone."""
    if finding.notes is None:
        return f"{finding.file}\n  cannot be used, see below"
    lines = [finding.file, "  notes of a pool run"]
    return "\n".join(lines + [f"  {line}" for line in _notes(finding.notes)])


def _what_it_is(record: PoolRunRecord) -> str:
    try:
        begin = datetime.fromtimestamp(record.start_time_ns // 1_000_000_000, UTC)
        when = f"{begin:%Y-%m-%d %H:%M:%S} UTC"
    except (OverflowError, ValueError, OSError):
        when = f"begins at {record.start_time_ns} ns"
    parts = [when, f"{record.duration_s:.1f} s"]
    if not record.complete:
        parts.append(f"cut off: {record.read_bytes} of {record.size_bytes} bytes read")
    if record.writer:
        parts.append(f"written by {_plain(record.writer)}")
    return ", ".join(parts)


def _notes(notes: RunNotes) -> list[str]:
    stated = notes.model_dump(mode="json", exclude_defaults=True, exclude={"file", "text"})
    lines = [f"{key}: {_flat(value)}" for key, value in stated.items()]
    return [*lines, *(["(and a text)"] if notes.text.strip() else [])] or ["empty"]


def _flat(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_flat(one)}" for key, one in value.items() if one is not None)
    if isinstance(value, list):
        return "; ".join(_flat(one) for one in value)
    return _plain(str(value))


def _plain(text: str) -> str:
    """Leave nothing in a line that moves the cursor of a terminal."""
    return "".join(c if c.isprintable() else " " for c in text)


def _channel(channel: ChannelSummary) -> list[str]:
    read = channel.read
    fields = ", ".join(read.fields)
    said = "assumed" if read.unit_from == "assumed" else f"from the {read.unit_from}"
    axes = f", axes {read.axes}" if read.axes else ""
    unit = "" if read.unit in ("", "1") else f" in {read.unit} (unit {said})"
    lines = [
        f"  {channel.name} from {_plain(read.topic)} {_plain(fields)}{unit}{axes}; {read.mapped_by}"
    ]
    rate = f"{channel.rate_hz:.4g} Hz" if channel.rate_hz is not None else "no rate"
    steady = "" if channel.is_regular else " on change"
    lines.append(
        f"    {channel.readings} readings, {rate}{steady}, {channel.first_s:.2f} to "
        f"{channel.last_s:.2f} s, longest gap {channel.longest_gap_s:.3g} s"
    )
    lines.append(f"    clock: {_clock(channel)}")
    ranges = [
        f"{name} {low:.4g} to {high:.4g}"
        for name, low, high in zip(channel.columns, channel.lowest, channel.highest, strict=True)
        if low is not None and high is not None
    ]
    lines.append(f"    {', '.join(ranges) or 'no numbers'}")
    marks = [f"{mark.replace('_', ' ')} ({count})" for mark, count in channel.marks.items()]
    if marks:
        lines.append(f"    marked: {', '.join(marks)}")
    lines += [f"    {_plain(note)}" for note in read.notes]
    return lines


def _clock(channel: ChannelSummary) -> str:
    clock = channel.clock
    used = {"header": "stamp in the message", "log": "time of the log", "field": "a field"}
    parts = [f"{used[clock.used]} ({clock.why})"]
    if clock.offset_s:
        parts.append(f"offset {clock.offset_s:+.3f} s, drift {clock.drift_ppm:+.1f} ppm")
    if clock.segments > 1:
        parts.append(f"{clock.segments} parts")
    if clock.jitter_s is not None:
        parts.append(f"jitter {1e3 * clock.jitter_s:.2g} ms")
    if channel.delay_s:
        parts.append(f"delay {channel.delay_s:g} s")
    return ", ".join(parts)
