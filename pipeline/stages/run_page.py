"""Everything known of one pool run -> its page, and a receipt with its line for other pages."""

from pathlib import Path

from pipeline.ingest.log_files import is_log_name
from pipeline.plan import report_file
from pipeline.provenance import Envelope, file_digest
from pipeline.records.run_table import RunTable
from pipeline.records.trial import LARGEST_OVERLAY_BYTES, PageReceipt, RunTrial, StoredRun
from pipeline.report.glance import Flown, run_glance
from pipeline.report.html import address_from, crumbs, placed, write_page
from pipeline.report.results import RunResults
from pipeline.report.run_page import run_line, run_page
from pipeline.stages.job import Job, leaves_record
from pipeline.stages.page_provenance import page_provenance
from pipeline.stages.run_table_file import read_tables


@leaves_record
def run(job: Job) -> tuple[PageReceipt, str]:
    """Write the page; of a log that cannot be read it says why."""
    page = job.more_outputs[0]
    kept = job.output.with_suffix(".html")
    kept.unlink(missing_ok=True)
    ((name, stored),) = job.all_of("pool_run", StoredRun)
    ((_, trial),) = job.all_of("run_trial", RunTrial)
    results = _results(job, page, name, stored, trial)
    day = stored.record.day if stored.record is not None else ""
    flown = tuple(dict.fromkeys(one.name for one in results.manoeuvres))
    glance = run_glance(
        job.vehicle_name,
        name,
        None,
        Flown({name: flown}),
        None if results.trial is None else results.trial.gains,
        unreadable=results.why_not_read,
    )
    trail = [(job.vehicle_name, report_file(job.vehicle_name))]
    if day:
        trail.append((f"Trial day {day}", f"reports/{job.vehicle_name}/trials/{day}.html"))
    assets = placed(page.parents[2] / "assets", page)
    write_page(run_page(results, crumbs(page, *trail), assets, glance), page)
    write_page(page.read_text(encoding="utf-8"), kept)
    receipt = PageReceipt(
        kind="run",
        name=name,
        files={kept.as_posix(): file_digest(kept)},
        page=page.as_posix(),
        glance=glance,
        manoeuvres=flown,
        title=name,
        errors=results.errors,
        warnings=results.warnings,
        line=run_line(results),
    )
    return receipt, glance.short


def _results(
    job: Job, page: Path, name: str, stored: Envelope[StoredRun], trial: Envelope[RunTrial]
) -> RunResults:
    own = {} if stored.record is None else stored.record.files
    made = {} if trial.record is None else trial.record.files
    tables: dict[str, RunTable] = {}
    for file in (*own, *made):
        tables |= read_tables(Path(file)) if file.endswith(".npz") else {}
    log = next((file for file in stored.inputs if is_log_name(file)), name)
    return RunResults(
        vehicle=job.vehicle(),
        vehicle_name=job.vehicle_name,
        run=name,
        shown_path=log,
        stored=stored.record,
        why_not_read=stored.why_not or "",
        problems=stored.problems,
        trial=trial.record,
        measured=tables.get("measured"),
        windows=tables.get("windows"),
        files=tuple(
            (label, address_from(page, file))
            for ending, label in (
                (".mcap", overlay_label(stored.record)),
                ("/pool/{}.npz", "Measured channels on one time base (NumPy arrays)"),
                ("/run_trials/{}.npz", "Simulated channels on the same (NumPy arrays)"),
            )
            for file in sorted({**made, **own})
            if file.endswith(ending.format(name))
        ),
        provenance=page_provenance((stored, trial)),
    )


def overlay_label(stored: StoredRun | None) -> str:
    """Say what the log beside the page holds: of a large one measured channels are not copied."""
    if stored is not None and stored.size_bytes > LARGEST_OVERLAY_BYTES:
        return "Log with simulated channels alone, to be opened with the run's own (MCAP)"
    return "Log with measured and simulated channels, for a log viewer (MCAP)"
