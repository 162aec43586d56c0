PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin

.PHONY: setup check docs dist test bench report report-rows mutation

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
	$(BIN)/python tools/report.py --check
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml

docs: $(BIN)/lint-imports      ## the documentation site, in build/docs; a warning is an error
	PYTHONPATH=src $(BIN)/python -m sphinx -W --keep-going -q -b html docs build/docs

dist: $(BIN)/lint-imports      ## wheel and source distribution, in dist
	$(BIN)/python -m build -q

report: $(BIN)/lint-imports     ## the fidelity report: build/report/fidelity.html and fidelity.json
	$(BIN)/python tools/report.py

report-rows: $(BIN)/lint-imports ## keep the names of new rows of the report
	$(BIN)/python tools/report.py --accept

mutation: $(BIN)/lint-imports   ## the mutation score of all families, into benchmarks/robustness/mutation.json
	$(BIN)/python benchmarks/robustness/mutation.py

test: $(BIN)/lint-imports
	PYTHONPATH=src $(BIN)/pytest

bench: $(BIN)/lint-imports      ## ratios measured in one run
	@for file in benchmarks/*.py; do PYTHONPATH=src $(BIN)/python $$file || exit 1; done
