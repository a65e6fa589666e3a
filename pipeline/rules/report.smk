"""Everything -> the pages that people read."""

from pipeline.provenance import code_digest


rule vehicle_page:
    input:
        vehicle=lambda wildcards: PLAN.vehicle_file(wildcards.vehicle),
        load_test="processed/{vehicle}/load_test.json",
        mooring="processed/{vehicle}/mooring.json",
        open_water="processed/{vehicle}/open_water.json",
        propeller="processed/{vehicle}/propeller.json",
        drive="processed/{vehicle}/drive.json",
        static="processed/{vehicle}/static.json",
        inverse="processed/{vehicle}/inverse.json",
        allocation="processed/{vehicle}/allocation.json",
        validation="processed/{vehicle}/validation.json",
        tables="processed/{vehicle}/tables.json",
        firmware="processed/{vehicle}/firmware.json",
        trials=lambda wildcards: PLAN.trial_receipts(wildcards.vehicle),
    output:
        receipt="processed/{vehicle}/vehicle_page.json",
        page="reports/{vehicle}/index.html",
    log:
        "processed/{vehicle}/logs/vehicle_page.log",
    params:
        code=code_digest("pipeline.stages.vehicle_page"),
        content=lambda wildcards: PLAN.content(wildcards.vehicle),
    shell:
        "{PYTHON} -m pipeline stage vehicle_page --vehicle {wildcards.vehicle} --code {params.code} "
        "--to {output.receipt:q} --to {output.page:q} {input:q} >{log:q} 2>&1"


rule index_page:
    input:
        PLAN.receipts(),
    output:
        "reports/index.html",
    log:
        "processed/logs/index_page.log",
    params:
        code=code_digest("pipeline.stages.index_page"),
        # not inputs: nothing in this run knows how to make them, and they are to stay as they are
        others=PLAN.other_receipts(),
        others_content=PLAN.others_content(),
    shell:
        "{PYTHON} -m pipeline stage index_page --code {params.code} "
        "--to {output:q} {input:q} {params.others:q} >{log:q} 2>&1"
