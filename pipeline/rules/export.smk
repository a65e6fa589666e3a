"""Fits -> what others read: tables.json and the firmware sources."""

from pipeline.provenance import code_digest


rule tables:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        propeller="processed/{vehicle}/propeller.json",
        static="processed/{vehicle}/static.json",
        inverse="processed/{vehicle}/inverse.json",
    output:
        "processed/{vehicle}/tables.json",
    log:
        "processed/{vehicle}/logs/tables.log",
    params:
        code=code_digest("pipeline.stages.tables"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage tables --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"


rule firmware:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        inverse="processed/{vehicle}/inverse.json",
        tables="processed/{vehicle}/tables.json",
        types=lambda wildcards: PLAN.results_of_types(
            wildcards.vehicle, "inverse", "tables"
        ),
    output:
        "processed/{vehicle}/firmware.json",
    log:
        "processed/{vehicle}/logs/firmware.log",
    params:
        code=code_digest("pipeline.stages.firmware"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage firmware --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"
