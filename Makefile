# What a developer types. Only relative paths, so that the checkout may lie in a folder with spaces in its name.
PYTHON ?= python3
SEED ?=
JOBS ?= 2
ARGS ?=

VENV := .venv
RUN := $(VENV)/bin/python
PIP := $(RUN) -m pip --disable-pip-version-check -qq install -c constraints.txt
STAMP := $(VENV)/.installed
BENCH := $(VENV)/.installed-bench
# They ask for an older numpy than the others, and work with this one.
LOOSE := mealpy==3.0.3 opfunu==1.0.4 pyFUME==0.3.4 simpful==2.12.0 fst-pso==1.9.0 miniful==0.0.6

.DEFAULT_GOAL := help
.PHONY: help install demo test check bench bench-hidden

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-12s %s\n", $$1, $$2}' Makefile
	@echo "afterwards: $(VENV)/bin/fogzoo --help"

install: $(STAMP) ## .venv with pinned versions; nothing when it is there and current (PYTHON=python3.12)

demo: install ## a simulated gyro with a hidden effect: simulated, diagnosed, refined, revealed (SEED=7)
	@$(RUN) scripts/demo.py $(if $(SEED),seed=$(SEED))

# One thread a process: two tests side by side are faster than two threads in one, and do not fight for the cores.
test: install ## all tests (ARGS='tests/effects -k mohr', JOBS=4)
	@OMP_NUM_THREADS=1 $(RUN) -m pytest -n $(JOBS) --dist worksteal $(ARGS)

check: install ## ruff and mypy
	@$(RUN) -m ruff check .
	@$(RUN) -m mypy

bench: $(BENCH) ## the scripts in benchmarks/, one after another; installs what they compare with
	@for script in $(filter-out benchmarks/hidden.py,$(wildcard benchmarks/*.py)); do echo; echo "== $$script"; $(RUN) "$$script" || exit 1; done

bench-hidden: $(BENCH) ## 400 gyros with hidden effects, diagnosed; an hour or more (ARGS='--cases 20 --peers', JOBS=4)
	@OMP_NUM_THREADS=1 $(RUN) benchmarks/hidden.py --jobs $(JOBS) $(ARGS)

# Some systems ship Python without ensurepip: there the environment is made bare, and the system's pip puts a pip into it.
$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed, this is " + sys.version.split()[0] + "; name another one: make install PYTHON=python3.12")'
	@test -x $(RUN) || $(PYTHON) -m venv $(VENV) >/dev/null 2>&1 || $(PYTHON) -m venv --clear --without-pip $(VENV)
	@$(RUN) -m pip --version >/dev/null 2>&1 || $(PYTHON) -m pip --python $(RUN) install -q pip
	@echo "install: pinned packages into $(VENV), once; a few minutes, most of it the download of torch"
	@$(PIP) hatchling editables setuptools
	@$(PIP) --no-build-isolation --no-compile -e '.[dev]'
	@$(RUN) -m compileall -qq -j 0 -x '/tests/' $(VENV)/lib || true # on all cores; pip does it on one. Some packages bring files that are no Python
	@touch $@
	@echo "install: done"

$(BENCH): $(STAMP)
	@$(PIP) --no-build-isolation -e '.[bench]'
	@$(RUN) -m pip --disable-pip-version-check -qq install --no-deps $(LOOSE) || echo "bench: without $(LOOSE); what compares with them says so"
	@touch $@
