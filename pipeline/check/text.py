"""Findings of a check as lines for a person, or as one JSON object for a machine."""

from dataclasses import asdict
from typing import Any

from pipeline.actions.identification_text import gains_text
from pipeline.check.findings import FileFinding, Findings, GainsFinding, VehicleFinding
from pipeline.check.proposal import as_lines, lines_of
from pipeline.check.run_text import notes_text, run_text
from pipeline.check.thruster_gains import summary
from pipeline.errors import Problem
from pipeline.provenance import canonical_json
from pipeline.records.measurements import ColumnRead

_MAX_CODES = 40


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
