# Two commands do everything on a fresh machine: `make thesis` and `make test`.
PYTHON ?= python3
CORES ?= 2
VENV := .venv
# Every package with the hashes of its files: of the core, of everything, and of torch.
CORE_LOCK := envs/core.lock
LOCK := envs/requirements.lock
TORCH_LOCK := envs/torch.lock
BIN := $(VENV)/bin
# Relative and in quotes, since the path of this folder may have spaces.
RUN = PATH="$(CURDIR)/$(BIN):$$PATH"
# Has torch for Linux without gigabytes for graphics cards; that for macOS is on the usual index.
TORCH_INDEX ?= https://download.pytorch.org/whl/cpu
# LAMMPS has an environment of its own: it is only used for comparison.
BENCH_VENV := .venv-bench
BENCH_LOCK := envs/bench.lock
SNAKEMAKE = $(RUN) $(BIN)/snakemake --cores $(CORES)
# Files, not folders: snakefmt silently skips every file whose path contains a folder named build.
SNAKEFILES := workflow/Snakefile $(wildcard workflow/rules/*.smk)
# The smoke run writes to results/, or to results/smoke/ if results/ holds the thesis.
SMOKE_RESULTS ?= $(if $(shell grep -ls '^name: thesis' results/report/run.yaml),results/smoke,results)
SMOKE = --configfile config/smoke.yaml --config results=$(SMOKE_RESULTS)
# Snakemake's own report of all results, made at the end of a run.
REPORT = --report $(1)/report/report.html --report-after-run --report-stylesheet workflow/report/report.css
# Snakemake leaves a folder alone that is locked, by another run or since a run was killed: what to type then.
HINT = || { ls .snakemake/locks/* >/dev/null 2>&1 && echo "If no other run works in this folder: make unlock $@" >&2; exit 1; }

# The parts of `make test`, the longest first, so that they end together. What needs the smoke run has one run of it.
SMOKED := $(addprefix tests/workflow/test_,$(addsuffix .py,cards crate mills report reruns smoke))
KILLED := $(addprefix tests/workflow/test_,$(addsuffix .py,kills server wheel))
PAGED := $(addprefix tests/workflow/test_,$(addsuffix .py,docs first_hour notebooks readme))
PARTS := test-smoke test-physics test-slow test-workflow test-pages test-kills test-fast

.PHONY: help plan install thesis smoke validation unlock verify crate docs test check types kernels $(PARTS) fuzz surfaces kills slurm lint format bench ablations reference lock mutants clean texts

# What any mill needs; `make thesis` and `make test` install the rest.
install: $(VENV)/installed  ## install what any mill needs into .venv
	@echo "done; now type: source .venv/bin/activate && millprint fingerprint planetary"

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*  ## /  make \1\t/p' $(firstword $(MAKEFILE_LIST)) | expand -t 20

thesis: $(VENV)/complete  ## compute the whole thesis, and its report
	$(SNAKEMAKE) $(call REPORT,results) $(HINT)

smoke: $(VENV)/complete  ## the same rules at small size
	$(SNAKEMAKE) $(SMOKE) $(call REPORT,$(SMOKE_RESULTS)) $(HINT)

# Which jobs a run would have, and their time, memory and disk, before anything runs: `make plan TARGETS="chapter2 chapter3"`;
# ARGS are arguments of Snakemake.
plan: $(VENV)/installed  ## say what a run would do: TARGETS, ARGS, CORES
	@$(RUN) $(BIN)/python -m millprint.cli plan --cores $(CORES) $(ARGS) -- $(TARGETS)

# What others measured, and a report of it alone.
validation: $(VENV)/complete  ## predict what others measured, and report it
	$(SNAKEMAKE) validation --report results/validation/report.html --report-after-run --report-stylesheet workflow/report/report.css $(HINT)

ablations: $(VENV)/complete  ## appendix A of the thesis
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

# Three at a time, since tests of the workflow wait for processes that start; while the linters work the kernels are
# compiled, so that no two tests do it.
test: $(VENV)/complete  ## linters and every test
	$(MAKE) --jobs=3 kernels lint $(PARTS)

# While you work: the linters, the types, and the tests that take little time.
FAST := -m "not slow and not browser and not cluster"
check: kernels  ## linters, types and the fast tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(MAKE) --jobs=2 types $(addprefix fast-,unit physics)

types: $(VENV)/complete
	$(BIN)/mypy

fast-%: $(VENV)/complete
	$(RUN) $(BIN)/pytest $(FAST) tests/$*

kernels: $(VENV)/complete
	$(BIN)/python -c "from millprint.dem.compilation import compile_kernels; compile_kernels(2)"

$(PARTS): $(VENV)/complete | kernels

test-smoke:
	$(RUN) $(BIN)/pytest $(SMOKED)

test-pages:
	$(RUN) $(BIN)/pytest $(PAGED)

test-workflow:
	$(RUN) $(BIN)/pytest tests/workflow $(addprefix --ignore=,$(SMOKED) $(KILLED) $(PAGED))

test-kills:
	$(RUN) $(BIN)/pytest $(KILLED)

test-physics:
	$(RUN) $(BIN)/pytest tests/physics

test-slow:
	$(RUN) $(BIN)/pytest -m slow tests/unit

test-fast:
	$(RUN) $(BIN)/pytest -m "not slow" tests/unit

# COUNT damaged files, and KILLS kills; `make test` has 50 damaged files and 2 kills.
fuzz: $(VENV)/complete
	$(BIN)/python -m tests.fuzz --count $(or $(COUNT),5000) --seed $(or $(SEED),0)

# COUNT random surfaces against closed forms; `make test` has 1,000 small ones.
surfaces: $(VENV)/complete
	$(BIN)/python -m tests.surfaces --count $(or $(COUNT),20000) --seed $(or $(SEED),0)

kills: $(VENV)/complete
	$(RUN) MILLPRINT_KILLS=$(or $(KILLS),50) MILLPRINT_KILL_SEED=$(or $(SEED),1) $(BIN)/pytest tests/workflow/test_kills.py

# Changes of the code in one place, and those that no test notices: `make mutants PARTS_OF="estimate dose" COUNT=50`.
mutants: $(VENV)/complete
	$(BIN)/python tools/mutants.py --count $(or $(COUNT),20) --seed $(or $(SEED),0) \
	  $(or $(PARTS_OF),estimate uncertainty observables claims dose yields doe counting kernel walls)

# Needs a running SLURM; .ci/slurm starts one on this machine.
slurm: $(VENV)/complete
	$(RUN) MILLPRINT_SLURM=1 $(BIN)/pytest -rs tests/workflow/test_slurm.py

# Timings: run it on an idle machine. `make bench QUICK=1` takes three minutes instead of ten; `make bench DRUMS=1`
# compares the power of drums with lifters instead.
bench: $(VENV)/complete $(BENCH_VENV)/installed  ## timings; QUICK=1 or DRUMS=1
	$(RUN) $(BIN)/python -m benchmarks --lammps $(BENCH_VENV) $(if $(QUICK),--quick) $(if $(DRUMS),--drums)

# The pages of docs/, to read without a network. A warning, such as a dead link, is an error.
docs: $(VENV)/complete  ## build the pages of docs/
	$(BIN)/sphinx-build -W --keep-going -n -q -b html docs docs/_build
	@echo "docs/_build/index.html"

lint: $(VENV)/complete  ## linters and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check $(SNAKEFILES)
	$(RUN) $(BIN)/snakemake --lint
	$(BIN)/codespell
	$(BIN)/python tools/check_words.py

format: $(VENV)/complete  ## format the code
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/snakefmt $(SNAKEFILES)

reference: $(VENV)/complete  ## write the pages and schemas that are made from the code
	$(BIN)/python tools/write_reference.py

texts: $(VENV)/complete  ## write the numbers of README, paper and pages from the stored tables of runs
	$(BIN)/python tools/store_verdicts.py --texts

# The environment is installed again whenever the lock file changes. Python compiles what it imports, and not the rest.
PIP_INSTALL = $(BIN)/pip install --quiet --no-compile
$(VENV)/installed: $(CORE_LOCK)
	$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14) and "millprint runs with Python 3.11 to 3.14: make PYTHON=python3.13")'
	$(PYTHON) -m venv --clear $(VENV)
	$(PIP_INSTALL) --require-hashes --requirement $(CORE_LOCK)
	$(PIP_INSTALL) --no-deps --editable .
	@touch $@

# The rest of the lock file: for the thesis, its surrogate, SLURM, the docs and the tests.
$(VENV)/complete: $(VENV)/installed $(LOCK) $(TORCH_LOCK)
	$(PIP_INSTALL) --require-hashes --requirement $(LOCK)
	$(PIP_INSTALL) --no-deps --require-hashes --retries 0 --extra-index-url $(TORCH_INDEX) --requirement $(TORCH_LOCK)
	@touch $@

$(BENCH_VENV)/installed: $(BENCH_LOCK)
	$(PYTHON) -m venv --clear $(BENCH_VENV)
	@$(BENCH_VENV)/bin/pip install --quiet --require-hashes --requirement $(BENCH_LOCK) > $(BENCH_VENV)/install.log 2>&1 || \
	  { echo "error: make bench: cannot install LAMMPS from $(BENCH_LOCK); see $(BENCH_VENV)/install.log" >&2; exit 1; }
	@touch $@

lock: $(VENV)/installed  ## resolve the packages again
	$(BIN)/pip install --quiet uv
	UV_CUSTOM_COMPILE_COMMAND="make lock" $(BIN)/python tools/write_locks.py

clean:  ## remove the environment
	rm -rf $(VENV) $(BENCH_VENV) .snakemake
