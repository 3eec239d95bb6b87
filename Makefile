# Two commands for a fresh clone: `make demo` and `make test`. `make check` is what every commit must pass.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CPP := $(wildcard src/henkei/_kernels/*.[ch]pp)
KERNELS := CMakeLists.txt pyproject.toml $(wildcard src/henkei/_kernels/*)

.PHONY: demo test check format bench clean

demo: $(VENV)/.demo
	$(BIN)/henkei demo -o demo-out

test: $(VENV)/.test $(VENV)/.system
	$(BIN)/python -m pytest -n 2

check: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/clang-format --dry-run --Werror $(CPP)

format: $(VENV)/.dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	$(BIN)/clang-format -i $(CPP)

bench: $(VENV)/.peers
	$(BIN)/python -m bench

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

# What the package is built with is kept in the environment, so that an editable rebuild is quick.
$(VENV)/.build: $(BIN)/python
	$(BIN)/python -m pip install --quiet "scikit-build-core>=0.10" "nanobind>=2.4" cmake ninja
	touch $@

$(VENV)/.demo: $(VENV)/.build $(KERNELS)
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[pictures]"
	touch $@

$(VENV)/.test: $(VENV)/.demo
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[test]"
	touch $@

# VTK draws without a display if a library of the system lets it; without, its tests are skipped.
GL := libegl1 libegl-mesa0 libgl1 libxrender1
VTK_DRAWS := $(BIN)/python -c "from henkei.io.drawing import vtk_window as w; raise SystemExit(w() is None)"

$(VENV)/.system: $(VENV)/.test
	@if $(VTK_DRAWS); then true; \
	elif [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
	    apt-get update -q && apt-get install -y -q --no-install-recommends $(GL); \
	else echo "tests that draw with VTK will be skipped; they need: $(GL)"; fi
	touch $@

$(VENV)/.dev: $(VENV)/.test
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[test,dev]"
	touch $@

$(VENV)/.peers: $(VENV)/.test
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[test,peers]"
	touch $@

clean:
	rm -rf $(VENV) build demo-out
