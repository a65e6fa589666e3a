"""Pool runs: several runs a job, one job a day and stage; only for what has something to do."""

from pipeline.provenance import code_digest


# The results of the runs are no outputs here: the engine removes the outputs of a job that fails,
# and one run's fault is not to take the others' results with it.
rule pool_batch:
    input:
        lambda wildcards: PLAN.batch_waits_for(wildcards.vehicle, wildcards.batch),
    output:
        "processed/.rig2sea/batches/{vehicle}/{batch}.done",
    log:
        "processed/{vehicle}/logs/pool_batch/{batch}.log",
    wildcard_constraints:
        batch=PLAN.batch_pattern(),
    params:
        work=lambda wildcards: PLAN.batch_work(wildcards.vehicle, wildcards.batch),
        content=lambda wildcards: PLAN.batch_content(wildcards.vehicle, wildcards.batch),
    shell:
        "{PYTHON} -m pipeline stages --vehicle {wildcards.vehicle} --done {output:q} "
        "{params.work:q} >{log:q} 2>&1"


rule trial_day:
    input:
        lambda wildcards: PLAN.day_waits_for(
            "trial_day", wildcards.vehicle, wildcards.item
        ),
    output:
        "processed/{vehicle}/trial_days/{item}.json",
    log:
        "processed/{vehicle}/logs/trial_day/{item}.log",
    wildcard_constraints:
        item=PLAN.day_pattern("trial_day"),
    params:
        code=code_digest("pipeline.stages.trial_day"),
        files=lambda wildcards: PLAN.day_inputs(
            "trial_day", wildcards.vehicle, wildcards.item
        ),
    shell:
        "{PYTHON} -m pipeline stage trial_day --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {params.files:q} >{log:q} 2>&1"


rule day_diagnosis:
    input:
        lambda wildcards: PLAN.day_waits_for(
            "day_diagnosis", wildcards.vehicle, wildcards.item
        ),
    output:
        "processed/{vehicle}/day_diagnoses/{item}.json",
    log:
        "processed/{vehicle}/logs/day_diagnosis/{item}.log",
    wildcard_constraints:
        item=PLAN.day_pattern("day_diagnosis"),
    params:
        code=code_digest("pipeline.stages.day_diagnosis"),
        files=lambda wildcards: PLAN.day_inputs(
            "day_diagnosis", wildcards.vehicle, wildcards.item
        ),
    shell:
        "{PYTHON} -m pipeline stage day_diagnosis --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {params.files:q} >{log:q} 2>&1"


# The tables of a past day are history: nothing makes them again.
rule day_tables:
    input:
        lambda wildcards: PLAN.day_waits_for(
            "day_tables", wildcards.vehicle, wildcards.item
        ),
    output:
        "processed/{vehicle}/day_tables/{item}.json",
    log:
        "processed/{vehicle}/logs/day_tables/{item}.log",
    wildcard_constraints:
        item=PLAN.day_pattern("day_tables"),
    params:
        code=code_digest("pipeline.stages.day_tables"),
        files=lambda wildcards: PLAN.day_inputs(
            "day_tables", wildcards.vehicle, wildcards.item
        ),
    shell:
        "{PYTHON} -m pipeline stage day_tables --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {params.files:q} >{log:q} 2>&1"


rule trial_page:
    input:
        lambda wildcards: PLAN.day_waits_for(
            "trial_page", wildcards.vehicle, wildcards.item
        ),
    output:
        receipt="processed/{vehicle}/trial_pages/{item}.json",
        page="reports/{vehicle}/trials/{item}.html",
    log:
        "processed/{vehicle}/logs/trial_page/{item}.log",
    wildcard_constraints:
        item=PLAN.day_pattern("trial_page"),
    params:
        code=code_digest("pipeline.stages.trial_page"),
        files=lambda wildcards: PLAN.day_inputs(
            "trial_page", wildcards.vehicle, wildcards.item
        ),
    shell:
        "{PYTHON} -m pipeline stage trial_page --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output.receipt:q} --to {output.page:q} {params.files:q} >{log:q} 2>&1"
