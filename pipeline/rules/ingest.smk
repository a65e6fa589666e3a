"""Raw files -> one checked record a kind."""

from pipeline.provenance import code_digest


rule load_test:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        files=lambda wildcards: PLAN.raw_files(wildcards.vehicle, "load_test"),
    output:
        "processed/{vehicle}/load_test.json",
    log:
        "processed/{vehicle}/logs/load_test.log",
    params:
        code=code_digest("pipeline.stages.load_test"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle, "load_test"),
    shell:
        "{PYTHON} -m pipeline stage load_test --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"


rule mooring:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        files=lambda wildcards: PLAN.raw_files(wildcards.vehicle, "mooring"),
    output:
        "processed/{vehicle}/mooring.json",
    log:
        "processed/{vehicle}/logs/mooring.log",
    params:
        code=code_digest("pipeline.stages.mooring"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle, "mooring"),
    shell:
        "{PYTHON} -m pipeline stage mooring --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"


rule open_water:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        files=lambda wildcards: PLAN.raw_files(wildcards.vehicle, "open_water"),
    output:
        "processed/{vehicle}/open_water.json",
    log:
        "processed/{vehicle}/logs/open_water.log",
    params:
        code=code_digest("pipeline.stages.open_water"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle, "open_water"),
    shell:
        "{PYTHON} -m pipeline stage open_water --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"
