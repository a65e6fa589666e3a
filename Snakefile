"""The workflow: raw/ -> processed/ -> reports/, by chapter in pipeline/rules/.

Usually started by `rig2sea run`; `snakemake --cores 2` in a folder that holds raw/ does the same.
"""

import os
import sys

import pipeline
from pipeline.workflow.targets import Targets

PLAN = Targets.from_config(config)
PYTHON = sys.executable
RULES = os.path.join(os.path.dirname(pipeline.__file__), "rules")

# One thread a process: the jobs share the cores, and sums do not depend on how many there are.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


wildcard_constraints:
    vehicle="[A-Za-z][A-Za-z0-9_-]*",


rule all:
    input:
        PLAN.all_files(),


include: f"{RULES}/ingest.smk"
include: f"{RULES}/identify.smk"
include: f"{RULES}/export.smk"
include: f"{RULES}/report.smk"
