"""Findings of a check as lines for a person, or as one JSON object for a machine."""

from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

from pipeline.check.findings import (
    FileFinding,
    Findings,
    GainsFinding,
    NotesFinding,
    RunFinding,
    VehicleFinding,
)
from pipeline.check.pool_runs import gains_text, summary
from pipeline.check.proposal import as_lines, lines_of
from pipeline.errors import Problem
from pipeline.provenance import canonical_json
from pipeline.records.measurements import ColumnRead
from pipeline.records.pool_run import ChannelSummary, PoolRunRecord, RunNotes

_MAX_CODES = 40
_MAX_TOPICS = 40


def as_text(findings: Findings) -> str:
    """Return the report for a person: every file, then every problem, then the count."""
    blocks = [_vehicle(vehicle) for vehicle in findings.vehicles]
    blocks += [_file(file) for file in findings.files]
    blocks += [run_text(run) for run in findings.runs]
    blocks += [notes_text(notes) for notes in findings.notes]
    blocks += [_gains(found) for found in findings.gains]
    problems = sorted(
        findings.all_problems, key=lambda p: ("error", "warning", "note").index(p.severity)
    )
    blocks += [f"{problem.severity}: {problem}" for problem in problems]
    blocks.append(_count(findings))
    return "\n\n".join(blocks)


def to_json(findings: Findings) -> str:
    """Return the same as JSON; docs/formats.md describes it."""
    body: dict[str, Any] = {
        "schema": "rig2sea/check/1",
        "ok": not findings.failed,
        "vehicles": [
            {"file": v.file, "name": v.name, "notes": list(v.notes)} for v in findings.vehicles
        ],
        "files": [
            {
                "file": f.file,
                "kind": f.kind,
                "kind_from": f.kind_from,
                "sheets": [sheet.model_dump(mode="json") for sheet in f.sheets],
                "points": f.points,
                "marked": f.marks,
                "codes": f.codes,
                "ranges": {
                    q.name: {"count": q.count, "min": q.least, "max": q.most} for q in f.quantities
                },
            }
            for f in findings.files
        ],
        "runs": [
            {
                "file": run.file,
                "kind_from": run.kind_from,
                "run": run.record and run.record.model_dump(mode="json", exclude={"problems"}),
            }
            for run in findings.runs
        ],
        "notes": [
            {"file": one.file, "notes": one.notes and one.notes.model_dump(mode="json")}
            for one in findings.notes
        ],
        "gains": [summary(one) for one in findings.gains],
        "problems": [_problem(problem) for problem in findings.all_problems],
    }
    return canonical_json(body)


def _gains(found: GainsFinding) -> str:
    if found.gains is None:
        return f"Gains of the thrusters: not computed, {found.why_not}"
    return "\n".join(gains_text(found.gains))


def _problem(problem: Problem) -> dict[str, Any]:
    place = asdict(problem.place)
    rest = {key: value for key, value in asdict(problem).items() if key != "place"}
    return {**place, **rest, "text": str(problem)}


def _vehicle(vehicle: VehicleFinding) -> str:
    if vehicle.problems:
        return f"{vehicle.file}\n  cannot be used, see below"
    lines = [f"{vehicle.file}", f"  vehicle {vehicle.name}"]
    lines += [f"  {note}" for note in vehicle.notes]
    return "\n".join(lines)


def _file(file: FileFinding) -> str:
    kind = file.kind.replace("_", " ")
    told = "" if file.kind_from == "folder" else " (recognised by its content)"
    lines = [file.file, f"  {kind}{told}: {_plural(file.points, 'point')}"]
    for sheet in file.sheets:
        name = f'sheet "{sheet.sheet}"' if sheet.sheet is not None else "table"
        lines.append(f"  {name}, {_plural(sheet.rows, 'row')}: {sheet.summary}")
        lines += [
            f"    column {c.column} {c.header!r}: {c.quantity.replace('_', ' ')} in {_unit(c)}"
            for c in sheet.columns
        ]
        lines += [
            f"    column {c.column} {c.header!r}: not used, {c.reason}" for c in sheet.not_used
        ]
    stated = lines_of([file])
    if stated:
        lines.append("  in vehicle.yaml this would be:")
        lines += [f"    {line}" for line in as_lines(file.kind, stated)]
    if file.codes:
        shown = [f"{code} ({count})" for code, count in file.codes.items()]
        rest = f" and {len(shown) - _MAX_CODES} more" if len(shown) > _MAX_CODES else ""
        lines.append(f"  codes (points): {', '.join(shown[:_MAX_CODES])}{rest}")
    lines += [
        f"  {q.name}: {q.least + 0.0:.6g} to {q.most + 0.0:.6g} in {_plural(q.count, 'point')}"
        for q in file.quantities
    ]
    lines += [
        f"  left out of fits: {mark} ({_plural(count, 'point')})"
        for mark, count in file.marks.items()
    ]
    return "\n".join(lines)


def _unit(column: ColumnRead) -> str:
    if column.unit in ("", "1"):
        return "plain numbers"
    said = "assumed" if column.unit_from == "assumed" else f"from the {column.unit_from}"
    return f"{column.unit} (unit {said})"


def _count(findings: Findings) -> str:
    severities = [problem.severity for problem in findings.all_problems]
    files = len(findings.files) + len(findings.vehicles)
    files += len(findings.runs) + len(findings.notes)
    counts = [_plural(severities.count(name), name) for name in ("error", "warning", "note")]
    return f"{_plural(files, 'file')}: {', '.join(counts)}."


def _plural(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


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
