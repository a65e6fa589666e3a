"""The stages of the workflow: what each is called, is made for, and reads.

One table: the plan, the titles in messages and the jobs of the engine follow from it. Light on
purpose, as `pipeline.plan`, which most of the program takes it from.
"""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Stage:
    """What ``run(job)`` of a module of `pipeline.stages` makes.

    `title` is what its result is called in messages. `of` says what it is made for: a vehicle, each
    run, each day, or all vehicles together. `needs` are the stages of the vehicle whose results it
    reads; what a stage of a run or a day reads beside these is in `workflow.pool_plan`. `of_types`
    are those of further types of thruster that it reads, too. `room` is the folder of its results,
    of stages that have one a run or a day; `page` that of its pages among the reports, and `beside`
    are the endings of what lies with its results. One that is `history` stays as it was once its
    day is past. `leaves` is what its result holds: a record, a receipt for other files, or, of
    ``tables.json``, a form of its own. `module` is the file of `pipeline.stages` that makes it, of
    its own name where none is stated.
    """

    title: str
    of: Literal["vehicle", "run", "day", "all"]
    needs: tuple[str, ...] = ()
    room: str = ""
    page: str = ""
    beside: tuple[str, ...] = ()
    history: bool = False
    of_types: tuple[str, ...] = ()
    leaves: Literal["record", "receipt", "tables"] = "record"
    module: str = ""


#: What the bench gave of the thrusters.
BENCH = ("static", "propeller", "drive")

#: In the order in which data flow.
STAGES: dict[str, Stage] = {
    "load_test": Stage("load test", "vehicle", module="bench_records"),
    "mooring": Stage("mooring test", "vehicle", module="bench_records"),
    "open_water": Stage("open-water test", "vehicle", module="bench_records"),
    "propeller": Stage(
        "propeller characteristic (Table 1)", "vehicle", ("open_water",), module="bench_fits"
    ),
    "drive": Stage("drive characteristic", "vehicle", ("load_test",), module="bench_fits"),
    "static": Stage(
        "static characteristic (Table 2)", "vehicle", ("propeller", "drive"), module="bench_fits"
    ),
    "inverse": Stage(
        "inverse characteristic (Tables 3 and 4)",
        "vehicle",
        ("static", "mooring"),
        module="bench_fits",
    ),
    "allocation": Stage(
        "allocator error map",
        "vehicle",
        ("static", "inverse"),
        of_types=("static", "inverse"),
        module="bench_fits",
    ),
    "validation": Stage(
        "allocator flown in simulation",
        "vehicle",
        ("load_test", "propeller", "drive", "static", "inverse"),
        of_types=("load_test", "propeller", "drive", "static", "inverse"),
    ),
    "tables": Stage(
        "tables.json",
        "vehicle",
        ("propeller", "static", "inverse"),
        leaves="tables",
        module="bench_fits",
    ),
    "firmware": Stage(
        "firmware tables",
        "vehicle",
        ("inverse", "tables"),
        of_types=("inverse", "tables"),
        leaves="receipt",
    ),
    "pool_run": Stage("pool run", "run", room="pool", beside=(".npz",)),
    "run_trial": Stage(
        "pool run against simulation", "run", BENCH, "run_trials", beside=(".npz", ".mcap")
    ),
    "run_page": Stage("page of the run", "run", room="run_pages", page="runs", beside=(".html",)),
    "run_diagnosis": Stage(
        "diagnosis of the run", "run", BENCH, "run_diagnoses", module="diagnosis"
    ),
    "trial_day": Stage("identification of the day", "day", BENCH, "trial_days"),
    "day_diagnosis": Stage(
        "diagnosis of the day", "day", BENCH, "day_diagnoses", module="diagnosis"
    ),
    "day_tables": Stage("tables of the day", "day", ("inverse",), "day_tables", history=True),
    "trial_page": Stage("page of the trial day", "day", room="trial_pages", page="trials"),
    "vehicle_page": Stage(
        "report",
        "vehicle",
        (
            *("load_test", "mooring", "open_water", "propeller", "drive", "static", "inverse"),
            *("allocation", "validation", "tables", "firmware"),
        ),
        leaves="receipt",
    ),
    "index_page": Stage("index of reports", "all"),
}


def stages_of(what: Literal["vehicle", "run", "day", "all"]) -> tuple[str, ...]:
    """Return the stages that are made for a vehicle, a run, a day or all, in order.

    >>> stages_of("run")
    ('pool_run', 'run_trial', 'run_page', 'run_diagnosis')
    """
    return tuple(name for name, stage in STAGES.items() if stage.of == what)


def module_of(name: str) -> str:
    """Return the module that a stage is run from, whose code its result depends on.

    >>> module_of("drive"), module_of("firmware")
    ('pipeline.stages.bench_fits', 'pipeline.stages.firmware')
    """
    stated = STAGES[name].module if name in STAGES else ""
    return f"pipeline.stages.{stated or name}"


def needed_for(wanted: tuple[str, ...]) -> frozenset[str]:
    """Return stages of a vehicle and all that they are made from.

    >>> sorted(needed_for(("drive",)))
    ['drive', 'load_test']
    """
    found = set(wanted)
    for name in reversed(STAGES):
        if name in found:
            found.update(STAGES[name].needs)
    return frozenset(found)
