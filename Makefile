PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin

.PHONY: setup check docs engine playground dist test bench report report-rows mutation

setup:                          ## a working copy to develop in
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install -q -e ".[dev]"

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

PYODIDE := 314.0.7
ENGINE := build/engine

engine: $(BIN)/lint-imports    ## Pyodide, pydantic-core and axistwin for the playground, in build/engine
	npm install --silent --prefix build/npm pyodide@$(PYODIDE)
	mkdir -p $(ENGINE)
	cd build/npm/node_modules/pyodide && cp pyodide.mjs pyodide.asm.mjs pyodide.asm.wasm python_stdlib.zip pyodide-lock.json README.md ../../../engine
	$(BIN)/pip download -q --no-deps --only-binary=:all: --platform pyemscripten_2026_0_wasm32 --python-version 314 -d $(ENGINE) \
		pydantic_core==$$($(BIN)/python -c "from importlib.metadata import version; print(version('pydantic_core'))")
	$(BIN)/python -m build -q -w -o $(ENGINE)
	$(BIN)/python -m axistwin.ui.playground.building $(ENGINE)

playground: engine               ## the playground for any web server, in build/axistwin-playground.zip
	rm -rf build/playground && $(BIN)/axistwin docs --playground --engine $(ENGINE) --out build/playground
	cd build && ../$(BIN)/python -m zipfile -c axistwin-playground.zip playground

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
	PYTHONPATH=src $(BIN)/pytest -m slow

bench: $(BIN)/lint-imports      ## ratios measured in one run
	@for file in benchmarks/*.py; do PYTHONPATH=src $(BIN)/python $$file || exit 1; done
