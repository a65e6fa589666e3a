"""The workflow: raw/ -> processed/ -> reports/, by chapter in the files beside this one.

Usually started by `rig2sea run`; `snakemake --cores 2` in a folder that holds raw/ does the same
(the Snakefile of the source tree includes this file).
"""

import os
import shlex
import sys

from pipeline import reader_language
from pipeline.workflow.targets import Targets

# The pages' language, for this process and for the jobs, wherever they are executed.
reader_language.use(config.get("language") or reader_language.wanted(os.environ))
os.environ[reader_language.VARIABLE] = reader_language.current()

PLAN = Targets.from_config(config)
PYTHON = shlex.quote(sys.executable)

# One thread a process: the jobs share the cores, and sums do not depend on how many there are.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


wildcard_constraints:
    vehicle="[A-Za-z][A-Za-z0-9_-]*",


rule all:
    input:
        PLAN.all_files(),


include: "ingest.smk"
include: "identify.smk"
include: "validate.smk"
include: "export.smk"
include: "pool.smk"
include: "report.smk"
