# `make paper-figures` and `make test` each work as the first command ever run: the virtual
# environment is made on the way. It needs Python >= 3.11 (with venv) and the package index only.

VENV := .venv
BIN := $(VENV)/bin
# Any Python >= 3.11 on the path; set PYTHON to choose one.
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11 python3.14 python; do \
	"$$p" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && echo "$$p" && break; done)

EXPERIMENT ?= experiments/paper.yaml

# Bytecode is kept, whatever the environment says: else every program that a test starts compiles all modules anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help install paper-figures lint test test-all docs bench clean
.DEFAULT_GOAL := help

help:
	@echo "make paper-figures  set up, simulate, run the paper's grid; report, figures and tables in results/paper"
	@echo "make test           lint, types and tests (under 5 minutes on 2 cores)"
	@echo "make docs           build the documentation: docs/build/index.html"
	@echo "make test-all       the same, then the slow tests (under an hour in all)"
	@echo "make bench          measure speed as ratios, also to placo, C++ and pomdp-py (set up in the user's cache)"
	@echo "make install        set up only; then: $(BIN)/fatplan --help"
	@echo "make clean          remove the virtual environment"

$(VENV)/.runtime: pyproject.toml constraints.txt
	@test -n "$(PYTHON)" || { echo "No Python >= 3.11 found. Install one, or call make PYTHON=/path/to/python3." >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable .
	@touch $@

$(VENV)/.development: $(VENV)/.runtime
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $@

install: $(VENV)/.runtime

paper-figures: $(VENV)/.runtime
	$(BIN)/fatplan simulate $(EXPERIMENT)
	$(BIN)/fatplan benchmark $(EXPERIMENT) --regret --bound
	$(BIN)/fatplan report $(EXPERIMENT)

lint: $(VENV)/.development
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

test: lint
	$(BIN)/pytest

test-all: test
	$(BIN)/python tests/run_slow_tests.py

# Offline once it is set up; every warning (a dead link, a missing name) is an error.
docs: $(VENV)/.development
	$(BIN)/sphinx-build --fail-on-warning --keep-going --fresh-env --quiet docs docs/build
	@echo "docs/build/index.html"

bench: $(VENV)/.development
	$(BIN)/python perf/speed.py
	$(BIN)/python perf/placo/compare.py
	$(BIN)/python perf/convergence.py
	$(BIN)/python perf/gains.py
	$(BIN)/python perf/natural.py
	$(BIN)/python perf/search_convergence.py
	$(BIN)/python perf/search/decisions.py
	$(BIN)/python perf/search/lookaheads.py
	$(BIN)/python perf/effort.py
	$(BIN)/python perf/search/compare.py --figure docs/images/search_cost.png

clean:
	rm -rf $(VENV)
