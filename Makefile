# On a bare machine with python3 and make: "make selftest" is the main job, "make test" all tests,
# "make check" what CI runs. Each installs what it needs.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
WORKERS ?= 2
# One more where tests wait by the clock.
WAITING = $(shell expr $(WORKERS) + 1)

.PHONY: selftest test tests-on-virtual-buses socketcan check lint installed dist docs options \
    detection mutants fleet bench clean

selftest: $(VENV)/installed
	$(BIN)/pytest --self-test

# What runs with SocketCAN takes one processor at most, so it runs beside the other tests.
test: $(VENV)/installed-for-tests
	$(MAKE) --no-print-directory --jobs=2 --output-sync=line tests-on-virtual-buses socketcan

tests-on-virtual-buses: $(VENV)/installed-for-tests
	$(BIN)/pytest -n $(WAITING) --dist worksteal tests
	$(BIN)/python tests/faults/detection.py --quick --workers $(WORKERS)
	$(BIN)/python tests/faults/pairs.py --quick --workers $(WORKERS)
	$(BIN)/python tests/faults/unusual_pairs.py --quick --workers $(WORKERS)

socketcan: $(VENV)/installed-for-tests
	PATH="$(abspath $(BIN)):$$PATH" tests/socketcan/run

# Every case against every faulty and every unusual server, as a table; an hour on two cores. Then
# servers with two faults, one of which hides others, half an hour more; and servers that are unusual
# in two ways.
detection: $(VENV)/installed-for-tests
	$(BIN)/python tests/faults/detection.py --workers $(WORKERS)
	$(BIN)/python tests/faults/pairs.py --workers $(WORKERS)
	$(BIN)/python tests/faults/unusual_pairs.py --workers $(WORKERS)

# Faults that nobody chose: those of the catalogue under conditions, mutants of the reference server,
# its transitions to wrong states. Each SHARE-th; SHARE=1 takes some hours of a processor.
SHARE ?= 5
mutants: $(VENV)/installed-for-tests
	$(BIN)/python tests/mutants/measure.py --workers $(WORKERS) --share $(SHARE)

# The suite against servers that others wrote. Those that need cargo or npm are left out without it;
# FLEET="node -- -k upload" names servers and options of pytest.
fleet: $(VENV)/installed-for-tests
	$(BIN)/python tests/fleet/fleet.py $(FLEET)

# How fast transfers and runs go, beside canopen's client and python-can alone, and how slow each may
# be, in ten minutes. BENCH="transfers --transfer=block" measures a part.
bench: $(VENV)/installed-for-tests
	$(BIN)/python tests/bench/bench.py $(BENCH)

# What is installed from the sdist, from an empty folder: with each Python that is found, with the
# lower ends of the dependencies, and beside other plugins of pytest. TOX="-e newest" names others.
installed: $(VENV)/installed-for-tests
	$(BIN)/tox run $(TOX)

# The files for a package index.
dist: $(VENV)/installed-for-tests
	$(BIN)/python -m build --outdir dist
	$(BIN)/twine check --strict dist/*

# What takes one processor runs beside what else there is.
check: $(VENV)/installed-for-tests
	$(MAKE) --no-print-directory --jobs=2 --output-sync=line \
	    tests-on-virtual-buses socketcan installed docs lint

# Warnings are errors: a link that leads nowhere is one.
docs: $(VENV)/installed-for-tests
	$(BIN)/python docs/pages.py build/pages
	$(BIN)/sphinx-build -q -W --keep-going -b html -c docs build/pages build/site

# The tables of options in docs, from the one in conformance/device/options.py.
options: $(VENV)/installed
	$(BIN)/python docs/option_tables.py

lint: $(VENV)/installed-for-tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy --platform win32 conformance cases examples
	$(BIN)/mypy --platform darwin conformance cases examples

$(VENV)/bin/python:
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
	    echo "installing python3-venv, which a bare Debian lacks"; \
	    apt-get update -qq && apt-get install -y -qq --no-install-recommends python3-venv; \
	} || { echo "install python3-venv first: this takes root"; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

$(VENV)/installed-for-tests: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --editable '.[test,check,docs]'
	touch $@ $(VENV)/installed

clean:
	rm -rf $(VENV) .tox .fleet .mypy_cache .pytest_cache .ruff_cache .hypothesis build dist
