# Two commands do all the set-up on a machine that has Python 3.11 or later and make:
#   make demo   environment, install, and the main job on the shipped data; ends with the path of a report
#   make test   environment, install, and the tests: at most ten minutes on two quiet cores
# What is statistical or long is apart: make calibrate (hours), SHARE=0.1 for a tenth of it drawn at random, SEED=7 to draw it again.
# Another Python:  make test PYTHON=python3.12        Another number of test processes:  make test WORKERS=4

PYTHON ?= python3
WORKERS ?= 2
PYTEST_ARGS ?=

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
PINNED := --constraint constraints.txt --build-constraint constraints.txt
INSTALL := $(PIP) install --quiet --quiet $(PINNED)
NEEDS := pyproject.toml constraints.txt
# A test process does its share of the work by itself: waiting threads of the kernels sleep instead of spinning, and a process
# that has nothing left takes the next test, but for those that share a fixture: they go to one process.
CALM := OMP_WAIT_POLICY=passive OPENBLAS_NUM_THREADS=1
PYTEST := $(CALM) $(BIN)/pytest --numprocesses $(WORKERS) --dist loadgroup $(PYTEST_ARGS)

SHARE ?= 1
SEED ?= $(shell $(BIN)/python -c "import random; print(random.randrange(10**6))")
VALIDATION ?= $(if $(filter 1,$(SHARE)),docs/validation/calibration,out/validation)

SUBSET ?= standard
METHODS ?= explain-gap

.PHONY: installed installed-newest installed-oldest demo test fast calibrate lint docs datasets scoreboard bench clean pins
.DELETE_ON_ERROR:

demo: $(VENV)/installed
	@$(BIN)/unspool demo

test: $(VENV)/installed-test
	$(PYTEST) --time-limits

fast: $(VENV)/installed-test
	$(PYTEST) -m "not slow"

# The statistical suites, from a fresh seed. The whole of it writes its tables to docs/validation/calibration, a share of it to out/validation.
calibrate: $(VENV)/installed-test
	$(PYTEST) --calibrate --seed $(SEED) --share $(SHARE) --validation $(VALIDATION)

lint: $(VENV)/installed-lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

docs: $(VENV)/installed-docs
	$(CALM) $(BIN)/sphinx-build -W --keep-going --quiet docs out/docs
	@echo out/docs/index.html

datasets: $(VENV)/installed
	$(BIN)/python datasets/make_datasets.py

# The wheel alone, in an empty folder, along the tutorial: newest Python and versions, then oldest Python and lowest versions.
installed: installed-newest installed-oldest

installed-newest: $(VENV)/installed-test
	$(BIN)/python tests/follow_tutorial.py --python newest

installed-oldest: $(VENV)/installed-test
	$(BIN)/python tests/follow_tutorial.py --python oldest --lowest

# What explain-gap answers to cases whose truth is sealed; an interrupted run goes on.   make scoreboard SUBSET=fast
scoreboard: $(VENV)/installed-test
	$(CALM) $(BIN)/python tests/hidden/scoreboard.py --subset $(SUBSET) $(addprefix --method ,$(METHODS)) --processes $(WORKERS)

# The same under the noise and the errors of a laboratory; an interrupted run goes on.   make bench SEED=7 SHARE=0.25
bench: $(VENV)/installed-test
	$(CALM) $(BIN)/python tests/hidden/bench.py --seed $(SEED) --share $(SHARE) --processes $(WORKERS)

clean:
	rm -rf $(VENV) out dist .pytest_cache .ruff_cache .hypothesis
	find measure simulate identify tests datasets -name __pycache__ -prune -exec rm -rf {} +

# What is installed depends on the two files in NEEDS; while they stand as they are, nothing is installed again.
# pip 25.1 and later know dependency groups; the one that comes with Python may be older, so its version is pinned too.
$(VENV)/installed: $(NEEDS) $(BIN)/python
	@echo "installing the project into $(VENV) (once; a few minutes on a slow line)"
	@$(PIP) --version >/dev/null 2>&1 || $(BIN)/python -m ensurepip >/dev/null
	@$(PIP) install --quiet --quiet --upgrade --constraint constraints.txt pip
	@$(INSTALL) --upgrade --editable .
	@touch $@

$(VENV)/installed-%: $(VENV)/installed
	@echo "installing what the $* target needs"
	@$(INSTALL) --group $*
	@touch $@

$(BIN)/python:
	@command -v $(PYTHON) >/dev/null || { echo "make: there is no $(PYTHON). Install Python 3.11 or later, or name it: make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "make: $$($(PYTHON) --version) is too old; Python 3.11 or later is needed. Name one: make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || \
		{ echo "make: $$($(PYTHON) --version) cannot make environments. Install its venv module (Debian, Ubuntu: python3-venv)." >&2; exit 1; }
	@echo "making the environment $(VENV) with $$($(PYTHON) --version)"
	@$(PYTHON) -m venv --clear $(VENV)

# Newest versions of everything, written down: constraints.txt is made by this and names no index; neither do the hashes of all files.
pins:
	rm -rf out/pins
	$(PYTHON) -m venv out/pins
	out/pins/bin/python -m pip install --quiet --upgrade pip
	out/pins/bin/python -m pip install --quiet hatchling editables --group dev --editable '.[c3d,dask,excel,fmu,hdf5,indices,labview,uff]'
	out/pins/bin/python -m pip freeze --all --exclude unspool --exclude setuptools > constraints.txt
	out/pins/bin/python -m pip install --quiet uv
	out/pins/bin/python supply-chain/make_supply_chain.py
	rm -rf out/pins
