"""Fits -> the vehicle flown in simulation with its own tables."""

from pipeline.provenance import code_digest


rule validation:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        load_test="processed/{vehicle}/load_test.json",
        propeller="processed/{vehicle}/propeller.json",
        drive="processed/{vehicle}/drive.json",
        static="processed/{vehicle}/static.json",
        inverse="processed/{vehicle}/inverse.json",
        types=lambda wildcards: PLAN.results_of_types(
            wildcards.vehicle, "load_test", "propeller", "drive", "static", "inverse"
        ),
    output:
        "processed/{vehicle}/validation.json",
    log:
        "processed/{vehicle}/logs/validation.log",
    params:
        code=code_digest("pipeline.stages.validation"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage validation --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"
