# Every target sets up the private environment .venv by itself. Another interpreter: make test PYTHON=python3.12

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo test test-slow test-all promise bench bench-before docs dist lint clean

demo: $(READY)
	$(BIN)/mpirun -n 2 $(BIN)/mesofriction compare rough-gw-paper rough-gw-amontons rough-gw-strength \
	  rough-persson-paper rough-persson-amontons --out demo-output

# tests as pytest compiles them are kept: else each worker compiles all again, in 3 s of CPU time
test test-slow: export PYTHONDONTWRITEBYTECODE :=

test: $(READY)
	$(BIN)/python -m pytest -n auto --dist worksteal

# those marked slow
test-slow: $(READY)
	$(BIN)/python -m pytest -n auto --dist worksteal -m slow

test-all: test test-slow

# what force_error promises, on 1,000 scenes of every kind, and in 250 far corners
promise: $(READY)
	FORCE_ERROR_CASES=1000 $(BIN)/python -m pytest tests/test_force_error.py -s -m ""

# CPU times beside what a user would pick instead; Mesa, voles and FLAKE are left out where they cannot be installed
bench: $(READY)
	-@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[bench]'
	$(BIN)/python tests/bench/ratios.py
	$(BIN)/python tests/bench/speed.py

# run times of master beside an older version, by kind of call
bench-before: $(READY)
	$(BIN)/python tests/bench/bench_before.py

# the site in build/site: pages, API, and a gallery of the shipped scenes, which are run for it once
docs: $(READY)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	$(BIN)/python docs/gallery.py build/gallery
	$(BIN)/python -m mkdocs build --strict --quiet

# sdist, and the wheel made from it, in dist/
dist: $(READY)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check build
	rm -rf dist
	$(BIN)/python -m build --outdir dist

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check --quiet .
	$(BIN)/python tests/shape.py
	$(BIN)/mypy

clean:
	rm -rf $(VENV) demo-output bench-output build dist

$(READY): pyproject.toml
	@command -v $(PYTHON) > /dev/null || \
	  { echo "mesofriction: $(PYTHON) is not there; say which Python, as in: make test PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "mesofriction: $(PYTHON) is older than 3.11; say which newer one, as in: make test PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null || \
	  { echo "mesofriction: $(PYTHON) lacks venv; install it, as in: apt install python3-venv" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	@# modules are compiled as they are first imported: all of them would take as long again as the installation
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check --editable '.[mpi,topography,test,lint]'
	@touch $@
