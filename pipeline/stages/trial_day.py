"""The runs of one day -> what they together say of the vehicle's parameters."""

from pathlib import Path

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.ingest.same_run import repeated_runs
from pipeline.inputs.no_solution import with_reason
from pipeline.records.trial import StoredRun, TrialDay
from pipeline.simulate.context import model_of
from pipeline.stages.job import Job, leaves_record
from pipeline.stages.run_table_file import stored_table
from pipeline.vehicle.sensor_schema import Sensors

#: Seconds of run that one day's fit takes. A longer one is `rig2sea identify`.
BUDGET_S = 120.0
#: Steps of the fit; a day whose model is right takes 9 to 16. A fit that needs more is stopped
#: where it stands and the page says so. Steps and not seconds: the same logs give the same page,
#: whatever else the machine has to do.
MOST_STEPS = 20


@leaves_record
def run(job: Job) -> TrialDay:
    """Identify from the day's most exciting runs; a fit that fails leaves why."""
    envelopes = job.all_of("pool_run", StoredRun)
    stored = [one.record for _, one in envelopes if one.record is not None]
    day = TrialDay(
        vehicle=job.vehicle_name,
        day=job.output.stem,
        runs=tuple(name for name, _ in envelopes),
        broken=tuple(name for name, one in envelopes if one.record is None),
    )
    try:
        return _identified(job, stored, day)
    except CannotComputeError as error:
        return day.model_copy(update={"why_not": str(error), "why_no_gains": str(error)})


def _identified(job: Job, stored: list[StoredRun], day: TrialDay) -> TrialDay:
    model = model_of(job.vehicle())
    # the compiled kernel takes two seconds to load: only for vehicles that are flown
    from pipeline.identify.day_choice import choose_stretches
    from pipeline.identify.whole_vehicle import identify_vehicle
    from pipeline.inputs.gains import gains_of_runs
    from pipeline.inputs.simulated_vehicle import load_simulated, with_known

    one = load_simulated(str(job.vehicle_file.parent), job.raw_root, Path())
    copies = repeated_runs({run.run: run for run in stored})
    tables = [
        with_known(stored_table(run), run.notes, one) for run in stored if run.run not in copies
    ]
    if not tables:
        raise CannotComputeError("No log of this day could be read.")
    healthy = {one.run for one in stored if one.notes is not None and one.notes.healthy is True}
    sound = [table for table in tables if table.name in healthy]
    day = day.model_copy(
        update={
            "gains": gains_of_runs(one, tables, sound),
            "sound_gains": gains_of_runs(one, sound).pooled if sound else (),
        }
    )
    code_max = np.abs(one.packed.code_limits).max(axis=1)
    chosen, used, passed = choose_stretches(tables, code_max, BUDGET_S)
    said = tuple(
        f"{copy}: the run of {first} again, which counts" for copy, first in copies.items()
    )
    day = day.model_copy(update={"used": used, "passed_over": (*passed, *said)})
    if not chosen:
        return day.model_copy(
            update={"why_not": "No run of this day can be taken; what each lacks is listed below."}
        )
    try:
        with with_reason("the whole-vehicle fit"):
            found = identify_vehicle(
                one.packed,
                one.vehicle.sensors or Sensors(),
                chosen,
                uncertainty=model.uncertainty,
                suggest=False,
                most_steps=MOST_STEPS,
                correct=False,
            )
    except CannotComputeError as error:
        return day.model_copy(update={"why_not": f"The fit failed: {error}"})
    notes = [*one.notes, *(note for t in chosen if t.known is not None for note in t.known.notes)]
    return day.model_copy(update={"identification": found, "notes": tuple(notes)})
