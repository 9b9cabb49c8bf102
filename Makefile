# `make run` and `make test` need Python 3.11+ and make, nothing else.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: run test slow thorough blind blind-wheels kernels lint types clean

$(BIN)/snakebot: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("snakebot needs Python 3.11 or newer, found " + sys.version.split()[0]) if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(PIP) install --editable .
	touch $@

# Each installation writes the program anew, so that it stands before, and its time tells nothing.
$(VENV)/.tested: pyproject.toml | $(BIN)/snakebot
	$(PIP) install --editable '.[test]'
	touch $@

$(VENV)/.linted: pyproject.toml | $(BIN)/snakebot
	$(PIP) install --editable '.[lint]'
	touch $@

# Each of the processes that run tests would compile the same for half a minute, all at the same time.
KERNELS := $(shell grep --recursive --files-with-matches --include='*.py' njit firmware_protocol snakebot tools) $(wildcard snakebot/physics/*.py)
$(VENV)/.compiled: $(KERNELS) $(VENV)/.tested
	$(BIN)/python tools/compile_kernels.py
	touch $@

kernels: $(VENV)/.compiled  ## what is compiled to machine code, on disk before the tests

run: $(BIN)/snakebot  ## the main job, on the simulated board
	$(BIN)/snakebot run --alpha 66 --beta 80 --omega 2 --cycles 4

# Half of what a test does is waiting for a clock: four at once keep two cores busy.
test: $(VENV)/.compiled  ## the default suite
	$(BIN)/python -m pytest -n 4 --dist worksteal

# What holds programs to a real clock has the computer to itself, without what computes beside it. The conformance suite
# waits nine tenths of its time, and asks again where this computer was late: six at once. Of the others, some take
# minutes, and whoever is asked again alone waits for them: two at once.
slow: $(VENV)/.compiled  ## what the default suite leaves out
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "slow and not real_time" --timeout 600
	$(BIN)/python -m pytest -n 6 --dist worksteal -m real_time --timeout 600 tests/conformance
	$(BIN)/python -m pytest -n 2 --dist worksteal -m real_time --timeout 600 --ignore tests/conformance

thorough:  ## the same with its searches at full length: an hour on two cores
	SNAKEBOT_TESTS=thorough $(MAKE) slow

SEED ?= 34
CASES ?= 400
TRAIN ?= 64
BLIND := build/blind-$(SEED)-$(CASES)
LEARN := build/blind-tune-$(SEED)-$(TRAIN) build/blind-calibrate-$(SEED)-$(TRAIN)
blind: $(VENV)/.tested  ## the diagnosis on sealed cases of another robot; goes on where it was stopped
	mkdir -p build
	$(BIN)/python tools/blind/make --seed $(SEED) --cases $(CASES) $(BLIND)
	$(BIN)/python tools/blind/answer $(BLIND) $(BLIND).answers
	$(BIN)/python tools/blind/experiment $(BLIND) $(BLIND).answers
	$(BIN)/python tools/blind/make --seed $(SEED) --cases $(TRAIN) --set tune $(word 1,$(LEARN))
	$(BIN)/python tools/blind/make --seed $(SEED) --cases $(TRAIN) --set calibrate $(word 2,$(LEARN))
	$(BIN)/python tools/blind/baseline $(LEARN) --answer $(BLIND) $(BLIND).answers
	$(BIN)/python tools/blind/fit_all $(BLIND) $(BLIND).answers
	$(BIN)/python tools/blind/score $(BLIND).answers $(BLIND)/labels.sealed --oracle $(BLIND)

ON_WHEELS := $(if $(filter file,$(origin CASES)),200,$(CASES))
WHEELS := build/wheels-$(SEED)-$(ON_WHEELS)
blind-wheels: $(VENV)/.tested  ## the same on a robot built otherwise: wheels, windings, integer loops; CASES=28 is two rounds
	mkdir -p build
	$(BIN)/python tools/blind_wheels/make_wheels --seed $(SEED) --cases $(ON_WHEELS) $(WHEELS)
	$(BIN)/python tools/blind/answer $(WHEELS) $(WHEELS).answers
	$(BIN)/python tools/blind_wheels/score_wheels --traces 3 $(WHEELS).answers $(WHEELS)/labels.sealed

lint: $(VENV)/.linted
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.linted $(VENV)/.tested
	$(BIN)/mypy

clean:
	rm -rf $(VENV) build dist
