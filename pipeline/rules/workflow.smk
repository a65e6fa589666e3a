"""The workflow: raw/ -> processed/ -> reports/, as jobs of one process each.

Usually started by `rig2sea run`, which says what is due and which job waits for which
(`workflow/engine_jobs.py`); `snakemake --cores 2` in a folder that holds raw/ does the same (the
Snakefile of the source tree includes this file).
"""

import os
import shlex
import sys

from pipeline import reader_language
from pipeline.workflow.engine import FOLDER

# The pages' language, for this process and for the jobs, wherever they are executed.
reader_language.use(config.get("language") or reader_language.wanted(os.environ))
os.environ[reader_language.VARIABLE] = reader_language.current()

if "jobs" in config:
    JOBS = config["jobs"]
else:
    # what `rig2sea run` has done already, and half a second of imports
    from pipeline.workflow.run import jobs_here

    JOBS = jobs_here(workflow.is_main_process)
PYTHON = shlex.quote(sys.executable)

# One thread a process: the jobs share the cores, and sums do not depend on how many there are.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")


rule all:
    input:
        [f"{FOLDER}/{name}.done" for name in JOBS],


# The results are no outputs here: the engine removes the outputs of a job that fails, and one
# stage's fault is not to take the others' results with it.
rule stages:
    input:
        lambda wildcards: [f"{FOLDER}/{name}.done" for name in JOBS[wildcards.job]],
    output:
        FOLDER + "/{job}.done",
    log:
        FOLDER + "/{job}.log",
    params:
        work=lambda wildcards: f"{FOLDER}/{wildcards.job}.json",
    shell:
        "{PYTHON} -m pipeline stages {params.work:q} --done {output:q} >{log:q} 2>&1"
