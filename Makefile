PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin

.PHONY: setup check test bench

setup:                          ## a working copy to develop in
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install -q -e ".[all,dev]"

$(BIN)/lint-imports:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install -q ".[dev]"

check: $(BIN)/lint-imports      ## format, lint, strict types, import contracts
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	PYTHONPATH=src $(BIN)/lint-imports

test: $(BIN)/lint-imports
	PYTHONPATH=src $(BIN)/pytest

bench: $(BIN)/lint-imports      ## ratios measured in one run
	@for file in benchmarks/*.py; do PYTHONPATH=src $(BIN)/python $$file || exit 1; done
