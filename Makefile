# `make demo` and `make test` need Python 3.11 or later and make the rest themselves, in .venv.
PYTHON ?= python3
WORKERS ?= 2
NEWTONJAX_SHARED ?= ../shared
export NEWTONJAX_SHARED := $(abspath $(NEWTONJAX_SHARED))
# Compiled code that tests and claims leave for the next run; `make test CACHE=` compiles everything anew.
CACHE ?= $(CURDIR)/.venv/compiled

BIN := .venv/bin
READY := .venv/ready

.PHONY: demo test lint claims experiments docs dist browser lock clean

demo: $(READY)
	$(BIN)/newtonjax demo --output-dir newtonjax-demo --force

test: lint
	JAX_COMPILATION_CACHE_DIR=$(CACHE) $(BIN)/python -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder

# The quick form of every experiment, in one process.
claims: $(READY)
	JAX_COMPILATION_CACHE_DIR=$(CACHE) $(BIN)/python -m experiments.claims

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/basedpyright --pythonpath $(BIN)/python

# Every table and figure of experiments/results again; the paper's table last, from what the others left.
EXPERIMENTS := truth.answer_table truth.trial_table accuracy.accuracy truth.scatter accuracy.benches truth.likelihood speed.benchmark paper.wavelets paper.figure4 paper.figure6 paper.figure7 paper.figure10 paper.textbook speed.methods accuracy.planner speed.derivatives speed.white_light speed.parts speed.shapes speed.pareto speed.scaling accuracy.extremes truth.intervals truth.refusals truth.few_fringes truth.forms truth.plates truth.rivals truth.round_trip truth.posterior truth.design truth.noise_weights truth.stopping truth.batch paper.paper paper.pictures

experiments: $(READY)
	set -e; for claim in $(EXPERIMENTS); do echo "== $$claim"; $(BIN)/python -m experiments.$$claim; done

# The manual in site/, with what the extra `docs` names in an environment of its own: it reads the source, and runs none. The
# notebooks are run before it, by the environment of the tests.
# Any warning fails it, and so does an address outside of the manual. Without the variable the theme prints an advertisement.
docs: .venv-docs/ready $(READY)
	JAX_COMPILATION_CACHE_DIR=$(CACHE) $(BIN)/python docs/notebook_pages.py
	PATH="$(CURDIR)/.venv-docs/bin:$$PATH" NO_MKDOCS_2_WARNING=1 .venv-docs/bin/mkdocs build --strict --quiet
	@! grep -rnoE '(href|src|url)[=(]"?(https?:)?//[^" >]*' site --include='*.html' --include='*.css'
	@echo "the manual is in site/index.html"

# Wheel and sdist in dist/, and what their readers ask of them: checks of both, of their metadata, the citation and the Dockerfile.
dist: .venv-dist/ready
	rm -rf dist
	.venv-dist/bin/python -m hatchling build
	.venv-dist/bin/twine check --strict dist/*
	.venv-dist/bin/check-wheel-contents dist/*.whl
	.venv-dist/bin/validate-pyproject pyproject.toml
	.venv-dist/bin/cffconvert --validate
	.venv-dist/bin/hadolint Dockerfile

# What the tests of the page need: a browser, by the system's own package manager, and two extras. Without it they skip.
BROWSER ?= chromium
browser: $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
		$$($(PYTHON) -c 'import tomllib; extras = tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]; print(*extras["app"], *extras["browser"])')
	@command -v $(BROWSER) >/dev/null && exit 0; \
	test "$$(id -u)" = 0 || { echo "no $(BROWSER); sudo apt-get install chromium, or make browser BROWSER=google-chrome" >&2; exit 1; }; \
	command -v apt-get >/dev/null || { echo "no apt-get here; install Chromium by hand" >&2; exit 1; }; \
	export DEBIAN_FRONTEND=noninteractive; install="apt-get install -qq -y --no-install-recommends chromium fonts-dejavu-core"; \
	$$install >/dev/null 2>&1 || { apt-get update -qq && $$install; }

.venv-docs/ready .venv-dist/ready: .venv-%/ready: pyproject.toml
	$(PYTHON) -m venv --clear .venv-$*
	.venv-$*/bin/python -m pip install --quiet --disable-pip-version-check \
		$$($(PYTHON) -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["$*"])')
	@touch $@

$(READY): requirements.lock pyproject.toml
	@echo "setting up .venv, with what requirements.lock names: a minute or two"
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 11) or sys.exit("newtonjax needs Python 3.11 or later, and $(PYTHON) is " + sys.version.split()[0] + "; name another one: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv --clear .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $(READY)

# The resolver is fetched into an environment of its own; the lock holds hashes and markers but no addresses.
lock:
	$(PYTHON) -m venv .venv-lock
	.venv-lock/bin/python -m pip install --quiet --disable-pip-version-check 'uv>=0.9'
	.venv-lock/bin/uv pip compile --quiet --universal --python-version 3.11 --extra test --generate-hashes \
		--no-emit-index-url --no-emit-find-links --no-annotate --no-header $(UPGRADE) --output-file requirements.lock pyproject.toml
	rm -rf .venv-lock

clean:
	rm -rf .venv .venv-lock .venv-docs .venv-dist dist site newtonjax-demo
