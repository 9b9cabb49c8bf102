# `make run` and `make test` need Python 3.11+ and make, nothing else.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: run test slow blind lint types clean

$(BIN)/snakebot: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("snakebot needs Python 3.11 or newer, found " + sys.version.split()[0]) if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(PIP) install --editable .
	touch $@

$(VENV)/.tested: pyproject.toml $(BIN)/snakebot
	$(PIP) install --editable '.[test]'
	touch $@

$(VENV)/.linted: pyproject.toml $(BIN)/snakebot
	$(PIP) install --editable '.[lint]'
	touch $@

run: $(BIN)/snakebot  ## the main job, on the simulated board
	$(BIN)/snakebot run --alpha 66 --beta 80 --omega 2 --cycles 4

test: $(VENV)/.tested  ## the default suite
	$(BIN)/python -m pytest -n 2

slow: $(VENV)/.tested  ## what the default suite leaves out
	$(BIN)/python -m pytest -n 2 -m slow

SEED ?= 2
CASES ?= 300
blind: $(VENV)/.tested  ## the diagnosis on sealed cases of another robot; goes on where it was stopped
	$(BIN)/python tools/blind/make --seed $(SEED) --cases $(CASES) build/blind-$(SEED)-$(CASES)
	$(BIN)/python tools/blind/answer build/blind-$(SEED)-$(CASES) build/blind-$(SEED)-$(CASES).answers
	$(BIN)/python tools/blind/score build/blind-$(SEED)-$(CASES).answers build/blind-$(SEED)-$(CASES)/labels.sealed

lint: $(VENV)/.linted
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.linted $(VENV)/.tested
	$(BIN)/mypy

clean:
	rm -rf $(VENV) build dist
