# On a bare machine with python3 and make: "make selftest" is the main job, "make test" all tests,
# "make check" what CI runs. Each installs what it needs.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
WORKERS ?= 2

.PHONY: selftest test socketcan check clean

selftest: $(VENV)/installed
	$(BIN)/pytest --self-test

test: $(VENV)/installed-for-tests
	$(BIN)/pytest -n $(WORKERS) --dist worksteal tests
	PATH="$(abspath $(BIN)):$$PATH" tests/socketcan/run

check: test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

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
	$(BIN)/python -m pip install --quiet --editable '.[test,check]'
	touch $@ $(VENV)/installed

clean:
	rm -rf $(VENV) .mypy_cache .pytest_cache .ruff_cache .hypothesis build dist
