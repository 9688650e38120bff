# Two commands do everything: `make demo` and `make test`. Both make .venv first; nothing is installed outside this folder.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
DEMO   := $(VENV)/.demo
READY  := $(VENV)/.ready
SEEN   := $(VENV)/.collected

# Tests wait for processes more than they reckon, so there is room for more at a time than there are cores.
WORKERS := $(shell expr $$(nproc) + 4)
PYTEST  := $(BIN)/pytest -n $(WORKERS) --dist loadscope
FEW     := [ $$(grep -c '::' .pytest_cache/v/cache/lastfailed) -le 10 ]

# Caches stay in this folder too. Bytecode is one of them: hundreds of processes begin in the tests, and each of them would
# compile the code again.
export MPLCONFIGDIR := $(CURDIR)/.cache/matplotlib
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help demo install test tests test-quick format lint types bytecode docs site pictures bench wheel clean

help:  ## List the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-10s %s\n", $$1, $$2}'

# What the demo needs, and all that the other targets need besides.
$(DEMO): pyproject.toml constraints.txt
	@VENV=$(VENV) $(PYTHON) tools/make_venv.py demo

$(READY): pyproject.toml constraints.txt
	@VENV=$(VENV) $(PYTHON) tools/make_venv.py all

install: $(READY)  ## Install everything: all extras and the development tools, about 1050 MB

demo: $(DEMO)  ## Emulator, gateway and a drive round the office; ends by itself in about a minute
	@$(BIN)/python -m acromovi demo

# The type check of a fresh clone takes a minute of one core, so the tests begin meanwhile.
test: $(READY)  ## Format check, lint, strict types and all tests
	@$(MAKE) --no-print-directory -j2 lint types tests

# What fails beside so many others, and is not much, is run again alone: a machine with too much to do lets processes miss
# their time. It is listed twice then, and its cause is to be found.
tests: lint bytecode
	$(PYTEST) || { [ $$? = 1 ] && $(FEW) && $(BIN)/pytest -n 0 --last-failed --last-failed-no-failures none; }

test-quick: $(READY)  ## Format check, lint and the tests that start no team, in two to three minutes; no types
	@$(MAKE) --no-print-directory -j2 lint bytecode
	$(PYTEST) --quick

lint: $(READY)  ## Format check and lint
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

types: $(READY)  ## Strict types
	nice $(BIN)/mypy

# The workers begin at the same time, and each would compile all tests for itself. Nothing is to be done if no file has
# changed since.
bytecode: $(READY)
	@if ! [ $(SEEN) -nt $(READY) ] || [ -n "$$(find . -path './.*' -prune -o -name '*.py' -newer $(SEEN) -print -quit)" ]; \
	then $(BIN)/pytest -n 0 --collect-only -qq > $(SEEN) || (cat $(SEEN); rm $(SEEN); false); fi

format: $(READY)  ## Format the code and mend what lint can mend
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

docs: $(READY)  ## Write PROTOCOL.md from the packet tables, and docs/api.md and docs/api/ from the docstrings
	$(BIN)/python -m acromovi.compliance > PROTOCOL.md
	$(BIN)/python -m tools.api_pages

site: $(READY)  ## Build the documentation site into build/site; warnings are errors
	$(BIN)/python -m tools.site

pictures: $(READY)  ## Make the pictures in docs/pictures anew
	$(BIN)/python tools/make_pictures.py

bench: $(READY)  ## Measure the figures of the project into bench/; PEER=HOST:PORT compares with a simulator there
	$(BIN)/python -m benchmarks $(if $(PEER),--peer $(PEER))

wheel: $(READY)  ## Build the distribution into dist/
	$(BIN)/python -m build --quiet

clean:  ## Remove what make has made
	rm -rf $(VENV) .cache build dist bench demo *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
