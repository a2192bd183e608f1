# SPDX-License-Identifier: LGPL-3.0-or-later
# Every target prepares what it needs; `make` alone lists them.

# Another venv, and what goes into it: make test VENV=.venv-wheel WITH=wheel
VENV ?= .venv
export VENV WITH
PYTHON := $(VENV)/bin/python
# Of the same MPI as mpi4py, with its flags; setup leaves it there.
MPIRUN := $(VENV)/bin/mpirun
# One thread a rank: BLAS threads only get in each other's way here.
export OMP_NUM_THREADS := 1

# Tests need most forms once: half the time to compile them without optimisation.
test test-slice test-thorough: export SHELLFORM_FORM_CFLAGS := -O0 -g0

# mpirun gives its ranks a terminal even where there is none.
PYTEST := $(PYTHON) -m pytest -q --color=$(if $(MAKE_TERMOUT),yes,no)

# On 1 rank: roll-up, drape, a short walk; starting ranks; weak forms, dolfinx itself. On 2: those
# again, director, statics, Newmark's steps.
SLICE := tests/demos/test_demos.py tests/simulation/test_run.py tests/test_parallel.py \
  tests/test_launcher.py tests/fem/test_dolfinx_compat.py tests/fem/test_shell.py

ON_RANKS := tests/demos/test_demos.py tests/simulation/test_run.py tests/fem/test_director.py \
  tests/statics/test_load_stepping.py tests/dynamics/test_explicit.py tests/dynamics/test_implicit.py

.DEFAULT_GOAL := help
.PHONY: help setup roll-up drape walk docs test test-slice test-thorough test-plain lint clean

help: ## this list
	@sed -n 's/^\([a-z-]*\):[^#]*## /make \1\t/p' $(MAKEFILE_LIST) | expand -t 16

setup: ## make .venv with the dolfinx that is here; WITH=active, apt or wheel picks one
	@.ci/setup

roll-up: setup ## roll a strip up into a circle by an end moment; result in out/roll_up
	$(PYTHON) demos/roll_up.py --out out/roll_up

drape: setup ## drape a square of cloth, held at a corner, over a sphere; result in out/drape
	$(PYTHON) demos/drape.py --out out/drape

walk: setup ## trousers on a walker, torque about the joints; result in out/walk
	$(MPIRUN) -n 2 $(PYTHON) demos/walk.py --out out/walk

# numpy is named so that pip can only keep Debian's.
docs: setup ## pages of docs/ with the gallery, links checked; result in docs/_build/html
	@$(PYTHON) -c "import furo, latex2mathml, myst_parser, sphinx_gallery" 2>/dev/null || \
	$(PYTHON) -m pip install -q --disable-pip-version-check --no-build-isolation -e '.[docs]' \
	  "numpy==$$($(PYTHON) -c 'import numpy; print(numpy.__version__)')"
	$(PYTHON) -m sphinx -b html -E -W --keep-going -n -q docs docs/_build/html
	@echo "wrote docs/_build/html/index.html"

ifeq ($(PLATFORM),)
test: setup ## tests on 1 rank, then on 2; PLATFORM=wheel or debian13 for those of another one
	@status=0; \
	$(PYTEST) -n 2 --dist loadfile -m "not thorough" || status=1; \
	$(MPIRUN) -n 2 $(PYTEST) -p no:cacheprovider -m "not serial and not slow and not thorough" || status=1; \
	exit $$status

test-slice: setup ## tests that meet dolfinx, MPI and numpy most; PLATFORM as for test
	@status=0; \
	$(PYTEST) -n 2 --dist loadfile -m "not thorough" -k "not test_ranks_agree and not mirrored" $(SLICE) \
	  || status=1; \
	$(MPIRUN) -n 2 $(PYTEST) -p no:cacheprovider -m "not serial and not slow and not thorough" $(ON_RANKS) \
	  || status=1; \
	exit $$status
else ifeq ($(PLATFORM),wheel)
test test-slice:
	@$(MAKE) --no-print-directory $@ PLATFORM= VENV=.venv-wheel WITH=wheel
else ifeq ($(PLATFORM),debian13)
test test-slice:
	@.ci/debian13 $@
else
test test-slice:
	@echo "PLATFORM=$(PLATFORM) is unknown: wheel or debian13" >&2; exit 2
endif

test-thorough: setup ## the tests that `make test` leaves out for their time, on 1 rank
	$(PYTEST) -n 2 --dist loadfile -m thorough

# Test results may not hang on the processor: nothing of this one but what all of 2009 have.
test-plain: export SHELLFORM_CFLAGS := -march=x86-64-v2
test-plain: export NUMBA_CPU_NAME := nehalem
test-plain: export NUMBA_CPU_FEATURES :=
test-plain: setup ## all tests on 1 rank, compiled for any x86-64 processor of version 2
	$(PYTEST) -n 2 --dist loadfile

lint: setup ## ruff: rules and layout; import-linter: which room may import which
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .
	$(VENV)/bin/lint-imports --no-logo
	$(PYTHON) -m mypy

clean: ## remove results and caches of the tools; .venv stays
	rm -rf out build dist docs/_build docs/gallery_pages docs/api/rooms .pytest_cache .ruff_cache
	find . -name __pycache__ -not -path './.venv*' -type d -exec rm -rf {} +
