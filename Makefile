# make        set up, then raw/ -> processed/ and reports/; ends by naming the report
# make setup  what `make` and the tests need into .venv
# make test   set up, then all tests but the slow ones (under 8 minutes on two cores)
# make test-all  the same with the slow ones
# make quick  set up, then the tests that need no simulation and no diagnosis (a minute or so)
# make coverage  the same, and fails where the tests run less than 85 % of the lines
# make check  linters, types, import rules
# make lock   write requirements.lock and requirements-dev.lock anew from pyproject.toml
# make cross  install the cross-compiler and the emulator of the firmware tests (Debian, Ubuntu)
# make reference  write the generated pages (keys, columns, topics, commands, rooms) into docs/reference/
# make drawing  draw the import contract of pyproject.toml into docs/architecture.md
# make cluster  run the workflow on a Slurm of its own on this machine (root; minutes)
# make wheel-test  build the wheel and use it in an empty environment (minutes)
# make fuzz   search for files that a reader cannot stand (10 minutes, or MINUTES=60 make fuzz)
# make faults kill runs at every point, fill the disk and so on (minutes; as root it tries more)
# make bundled  write the raw files of the bundled vehicle anew
# make benchmark  measure the simulation and renew docs/benchmarks.md; the reader of logs (minutes)

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
# every process of a run would compile the package anew
unexport PYTHONDONTWRITEBYTECODE
.DEFAULT_GOAL := run

VENV ?= .venv
BIN := $(VENV)/bin
RUN_STAMP := $(VENV)/.set-up
STAMP := $(VENV)/.set-up-to-develop
FIND_PYTHON := for p in python3.11 python3 python3.12 python3.13 python; do \
	"$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 \
	&& { echo "$$p"; break; }; done || true
PYTHON ?= $(shell $(FIND_PYTHON))
INSTALL := $(BIN)/python .ci/install_packages.py --no-deps
# What is compiled at set-up is what a run imports; the rest is compiled where it is first imported.
NO_RUN_IMPORTS := /(tests?|testsuite|testing)/|/site-packages/(pip|setuptools|pkg_resources|pymavlink|plotly|fontTools|docutils|hatchling|openpyxl|git|nbformat|lxml|google|apsw|pygments|pydantic/v1|numba/cuda|numpy/(distutils|f2py)|sqlalchemy/(dialects|ext)|statsmodels/(tsa|genmod|discrete|sandbox|graphics|multivariate|nonparametric|imputation|datasets|miscmodels|duration|gam|treatment|stats)|scipy/(io|datasets|_external))/
TESTS ?=
MINUTES ?= 10

.PHONY: run setup test test-all quick coverage check lock cross reference drawing cluster wheel-test fuzz faults bundled benchmark clean

run: $(RUN_STAMP)
	@$(BIN)/rig2sea run

setup: $(STAMP)

$(STAMP): $(RUN_STAMP) requirements-dev.lock
	@echo "Installing the packages of requirements-dev.lock ..."
	@$(INSTALL) --require-hashes --requirement requirements-dev.lock
	@touch $@

$(RUN_STAMP): requirements.lock pyproject.toml .ci/install_packages.py
	@if [ -z "$(PYTHON)" ]; then \
	  echo "rig2sea needs Python 3.11 or newer; none was found ($$(python3 --version 2>&1 || true))." >&2; \
	  echo "Install it (Debian, Ubuntu: apt install python3.11 python3.11-venv), or name one: make PYTHON=/path/to/python3.11" >&2; \
	  exit 1; fi
	@if ! $(BIN)/python -c '' >/dev/null 2>&1; then \
	  echo "Making $(VENV) with $(PYTHON) ..."; \
	  $(PYTHON) -m venv --clear $(VENV) || { \
	    echo "The environment could not be made. On Debian and Ubuntu the venv module is a package of its own: apt install python3-venv" >&2; \
	    exit 1; }; fi
	@echo "Installing the packages of requirements.lock ..."
	@$(INSTALL) --require-hashes --requirement requirements.lock
	@$(INSTALL) --no-build-isolation --editable .
	@$(BIN)/python -m evaluation.compile_kernels >/dev/null 2>&1 </dev/null &
	@$(BIN)/python -m compileall -qq -j 0 -x '$(NO_RUN_IMPORTS)' $(VENV)/lib || true
	@touch $@

test: setup
	@$(BIN)/python -m pytest -n 2 --dist worksteal -q $(TESTS)

test-all: setup
	@$(BIN)/python -m pytest -n 2 --dist worksteal -q -m '' $(TESTS)

quick: setup
	@$(BIN)/python -m pytest -n 2 --dist worksteal -q -m quick $(if $(TESTS),$(TESTS),tests)

# Counting the lines takes a sixth of the time of the tests, so it is a command of its own.
coverage: setup
	@$(BIN)/python -m pytest -n 2 --dist worksteal -q --cov --cov-report= --cov-fail-under=85 $(TESTS)

check: setup
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/snakefmt --check Snakefile pipeline/rules

# One resolution of everything; then what a run needs in one file, what is left in the other.
COMPILE := $(BIN)/uv pip compile --quiet --python-version 3.11 --generate-hashes \
	--no-emit-index-url --no-emit-find-links --no-header --no-annotate pyproject.toml
lock: setup
	$(COMPILE) --upgrade --extra setup --extra cluster --extra dev -o $(VENV)/all.lock
	$(COMPILE) --upgrade --constraint $(VENV)/all.lock --extra setup --extra cluster -o requirements.lock
	$(COMPILE) --upgrade --constraint $(VENV)/all.lock --extra dev \
	  $$(sed -nE 's/^([A-Za-z0-9._-]+)==.*/--no-emit-package \1/p' requirements.lock) -o requirements-dev.lock
	@if grep -nE '://|^[[:space:]]*--(index|extra-index|find-links|trusted)' requirements.lock requirements-dev.lock; then \
	  echo "A lock file names a registry; it must hold names, versions and hashes alone." >&2; \
	  exit 1; fi

cross:
	sh .ci/install_cross_tools.sh

reference: setup
	$(BIN)/python -m evaluation.reference --to docs/reference
	$(BIN)/python -m evaluation.reference effects > docs/effects.md

drawing: setup
	$(BIN)/python .ci/draw_contract.py

cluster: setup
	RIG2SEA_CLUSTER=1 $(BIN)/python -m pytest -q -s tests/integration/test_cluster.py

wheel-test: setup
	PYTHON=$(abspath $(BIN))/python .ci/wheel_in_empty_environment.sh

fuzz: setup
	$(BIN)/python -m tests.fuzz --minutes $(MINUTES)

faults: setup
	$(BIN)/python tests/faults/run_faults.py

bundled: setup
	$(BIN)/python -m evaluation.bundled.mmt300_files --to raw/mmt300
	$(BIN)/python -m evaluation.bundled.run_logs --to raw/mmt300

benchmark: setup
	$(BIN)/python benchmarks/kernel.py --write
	$(BIN)/python -m benchmarks.ingest_mcap
	$(BIN)/python -m benchmarks.ingest_memory

clean:
	rm -rf processed/* processed/.rig2sea reports/* .snakemake .mypy_cache .ruff_cache \
	  .pytest_cache .hypothesis .import_linter_cache .coverage
