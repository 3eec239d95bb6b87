# Three commands for a fresh clone: `make demo`, `make studio` and `make test`.
# `make check` is what every commit must pass.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CPP := $(wildcard src/henkei/_kernels/*.[ch]pp)
KERNELS := CMakeLists.txt pyproject.toml $(wildcard src/henkei/_kernels/*)
WEB := $(shell find web -name node_modules -prune -o -type f -print)
PAGE := src/henkei/page/studio.js
MODULES := web/node_modules/.package-lock.json
NPM := npm --prefix web

.PHONY: demo studio test check check-web format bench clean

demo: $(VENV)/.demo
	$(BIN)/henkei demo -o demo-out

studio: $(VENV)/.studio $(PAGE)
	$(BIN)/henkei studio

test: $(VENV)/.test $(VENV)/.system $(PAGE)
	$(BIN)/python -m pytest -n 2

check: $(VENV)/.dev check-web
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/clang-format --dry-run --Werror $(CPP)

check-web: $(MODULES)
	@if $(HAS_NODE); then $(NPM) run --silent check && $(NPM) run --silent format:check; \
	else echo "web/ is not checked: $(NEEDS_NODE)"; test -z "$$CI"; fi

format: $(VENV)/.dev $(MODULES)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	$(BIN)/clang-format -i $(CPP)
	@if $(HAS_NODE); then $(NPM) run --silent format; fi

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

$(VENV)/.studio: $(VENV)/.demo
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[pictures,studio]"
	touch $@

$(VENV)/.test: $(VENV)/.demo
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[test]"
	touch $@

# Packages of the system, as far as they are missing and one may install them.
APT := [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && \
    apt-get update -q && apt-get install -y -q --no-install-recommends

# The studio's page is bundled by Node.js; without, it is left out and its tests are skipped.
NEEDS_NODE := it needs Node.js 18 or later, with npm
HAS_NODE := { node --eval 'process.exit(+(parseInt(process.versions.node) < 18))' && \
    command -v npm; } >/dev/null 2>&1

$(VENV)/.node: | $(BIN)/python
	@if $(HAS_NODE); then true; else $(APT) nodejs npm || true; fi
	touch $@

$(MODULES): web/package.json web/package-lock.json | $(VENV)/.node
	@if $(HAS_NODE); then $(NPM) ci --loglevel=error; fi

$(PAGE): $(WEB) $(MODULES)
	@if $(HAS_NODE); then $(NPM) run --silent build; \
	else echo "the studio's page is not built: $(NEEDS_NODE)"; fi

# VTK draws without a display if a library of the system lets it, and a browser shows the studio;
# tests that lack either are skipped.
GL := libegl1 libegl-mesa0 libgl1 libxrender1
VTK_DRAWS := $(BIN)/python -c "from henkei.io.drawing import vtk_window as w; raise SystemExit(w() is None)"

$(VENV)/.system: $(VENV)/.test | $(VENV)/.node
	@missing=; \
	$(VTK_DRAWS) || missing="$(GL)"; \
	command -v chromium >/dev/null || missing="$$missing chromium"; \
	[ -z "$$missing" ] || { $(APT) $$missing; } || \
	    echo "tests that draw will be skipped if they need one of these: $$missing"
	touch $@

$(VENV)/.dev: $(VENV)/.test
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[test,dev]"
	touch $@

$(VENV)/.peers: $(VENV)/.test
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable ".[test,peers]"
	touch $@

clean:
	rm -rf $(VENV) build demo-out web/node_modules src/henkei/page
