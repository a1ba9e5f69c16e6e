# Everything is set up by the first command: a virtual environment in $(VENV) with the packages of constraints.txt.
DATASET ?= synthetic
PRESET ?= quick
CORES ?= 2
PYTHON ?= python3
VENV ?= .venv
BIN = $(VENV)/bin

# Threads beyond the cores make every step slower, and waiting threads must not spin.
export OMP_NUM_THREADS ?= 1
export OMP_WAIT_POLICY ?= PASSIVE
export STYLEPHASE_CACHE ?= build/cache
ifneq ($(wildcard ../shared/mirror),)
export STYLEPHASE_MIRROR ?= ../shared/mirror
endif

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help reproduce figures test lint probe setup clean

help: ## list the commands
	@sed -n 's/^\([a-z]*\):.*## /make \1\t/p' $(MAKEFILE_LIST) | expand -t 18
	@echo "variables: DATASET=$(DATASET) PRESET=$(PRESET) CORES=$(CORES) PYTHON=$(PYTHON) VENV=$(VENV)"

# flock lets a second run wait, and ends with its process; Snakemake's own lock would outlive a kill. With its limit of
# jobs a second it looks at all files again every second, which takes a fifth of a processor; every five are enough.
reproduce: probe ## run all notebooks on DATASET with PRESET, redoing only what changed
	@mkdir -p build
	@PATH=$(abspath $(BIN)):$$PATH flock build/lock snakemake --cores $(CORES) --nolock --rerun-incomplete \
		--max-jobs-per-timespan 1000/5s --config 'dataset=$(DATASET)' preset=$(PRESET) 2> build/pipeline.log || \
		{ echo "stylephase: the pipeline stopped; build/pipeline.log tells where" >&2; exit 2; }

figures: probe ## make the committed notebooks and figures again that are older than their code or data
	@$(BIN)/python -m stylephase.report.fresh make

# Worksteal: each process begins with half of the modules, so few of their fixtures are made twice. The browser's tests
# measure delays of a hundredth of a second, so nothing else may run beside them.
test: probe lint ## run all checks
	$(BIN)/python -m pytest tests/browser
	$(BIN)/python -m pytest -n $(CORES) --dist worksteal --ignore tests/browser

lint: $(VENV)/set-up ## check style and types
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/basedpyright --pythonpath $(BIN)/python

setup: $(VENV)/set-up ## only set up the virtual environment

probe: $(VENV)/set-up
	@$(BIN)/python -m stylephase.report.probe

clean: ## remove what the pipeline made; the virtual environment and fetched data stay
	rm -rf .snakemake $(filter-out build/cache,$(wildcard build/*))

$(VENV)/set-up: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "stylephase: $(PYTHON) is older than Python 3.11; name another with PYTHON=" >&2; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' || \
		{ echo "stylephase: $(PYTHON) cannot make virtual environments; on Debian: apt-get install python3-venv" >&2; exit 2; }
	@echo "setting up $(VENV): a minute or two, 2.4 GB"
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install -qq --upgrade pip --constraint constraints.txt
	@$(BIN)/python -m pip install -qq --no-compile --editable '.[dev]' --constraint constraints.txt
	@touch $@
