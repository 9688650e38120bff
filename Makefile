# Two commands do everything: `make demo` and `make test`. Both make .venv first; nothing is installed outside this folder.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready

# Tests wait for processes more than they reckon, so there is room for one more at a time than there are cores.
WORKERS := $(shell expr $$(nproc) + 1)

# Caches stay in this folder too.
export PIP_CACHE_DIR := $(CURDIR)/.cache/pip
export MPLCONFIGDIR  := $(CURDIR)/.cache/matplotlib

.PHONY: help demo test format lint types check docs bench wheel clean

help:  ## List the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-8s %s\n", $$1, $$2}'

$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] < (3, 14))' || \
	  { echo "Acromovi needs Python 3.11, 3.12 or 3.13; say which with: make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt 'pip>=25.1'
# The build backend warns of parts of its own, which nobody here could mend; errors are still shown.
	PYTHONWARNINGS=ignore $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt --group dev -e '.[all]'
	@touch $@

demo: $(READY)  ## Emulator, gateway and a drive round the office; ends by itself in about a minute
	@$(BIN)/python -m acromovi demo

test: $(READY)  ## Format check, lint, strict types and all tests
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/pytest -n $(WORKERS) --dist worksteal

format: $(READY)  ## Format the code and mend what lint can mend
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

docs: $(READY)  ## Print PROTOCOL.md anew from the packet tables
	$(BIN)/python -m acromovi.compliance > PROTOCOL.md

bench: $(READY)  ## Measure the figures of the project into bench/ (JSON and a picture)
	$(BIN)/python -m benchmarks

wheel: $(READY)  ## Build the distribution into dist/
	$(BIN)/python -m build --quiet

clean:  ## Remove what make has made
	rm -rf $(VENV) .cache build dist bench demo *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
