"""Records -> fits, static and inverse characteristic, and what the allocator makes of them."""

from pipeline.provenance import code_digest


rule propeller:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        open_water="processed/{vehicle}/open_water.json",
    output:
        "processed/{vehicle}/propeller.json",
    log:
        "processed/{vehicle}/logs/propeller.log",
    params:
        code=code_digest("pipeline.stages.propeller"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage propeller --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"


rule drive:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        load_test="processed/{vehicle}/load_test.json",
    output:
        "processed/{vehicle}/drive.json",
    log:
        "processed/{vehicle}/logs/drive.log",
    params:
        code=code_digest("pipeline.stages.drive"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage drive --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"


rule static:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        propeller="processed/{vehicle}/propeller.json",
        drive="processed/{vehicle}/drive.json",
    output:
        "processed/{vehicle}/static.json",
    log:
        "processed/{vehicle}/logs/static.log",
    params:
        code=code_digest("pipeline.stages.static"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage static --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"


rule inverse:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        static="processed/{vehicle}/static.json",
        mooring="processed/{vehicle}/mooring.json",
    output:
        "processed/{vehicle}/inverse.json",
    log:
        "processed/{vehicle}/logs/inverse.log",
    params:
        code=code_digest("pipeline.stages.inverse"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage inverse --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"


rule allocation:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        static="processed/{vehicle}/static.json",
        inverse="processed/{vehicle}/inverse.json",
        types=lambda wildcards: PLAN.results_of_types(
            wildcards.vehicle, "static", "inverse"
        ),
    output:
        "processed/{vehicle}/allocation.json",
    log:
        "processed/{vehicle}/logs/allocation.log",
    params:
        code=code_digest("pipeline.stages.allocation"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage allocation --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output:q} {input:q} >{log:q} 2>&1"
