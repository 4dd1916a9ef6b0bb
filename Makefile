# Two commands do all the set-up: `make all-videos` and `make test`. The rest is for those who work on emovid.
PYTHON ?= python3
JOBS ?= $(shell getconf _NPROCESSORS_ONLN 2>/dev/null || echo 1)
BIN := .venv/bin

.PHONY: all-videos figures kit study test coverage lint format bench readme docs sensitivity setup clean

all-videos: .venv/installed
	$(BIN)/emovid render --all --jobs $(JOBS) -o videos

figures: .venv/installed
	$(BIN)/emovid figures all -o figures --format pdf --format png

test: .venv/dev-installed
	$(BIN)/python -m pytest -n $(JOBS) --dist loadfile

coverage: .venv/dev-installed
	$(BIN)/python -m pytest -n $(JOBS) --dist loadfile --cov --cov-report=term --cov-report=html:coverage

lint: .venv/dev-installed
	$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy && $(BIN)/lint-imports

format: .venv/dev-installed
	$(BIN)/ruff check --fix . ; $(BIN)/ruff format .

study: .venv/installed
	$(BIN)/emovid study analyze studies/santos-egerstedt/responses.csv -o results

kit: .venv/installed
	$(BIN)/emovid study build studies/example -o kit
	$(BIN)/emovid study audit kit

bench: .venv/dev-installed
	$(BIN)/python benchmarks/startup.py
	$(BIN)/python benchmarks/gate.py
	$(BIN)/python benchmarks/coverage_scale.py
	$(BIN)/python benchmarks/render_cost.py
	$(BIN)/python benchmarks/peers.py

readme: .venv/installed
	$(BIN)/python docs/make_picture.py docs/six-emotions.webp

docs: .venv/dev-installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

sensitivity: .venv/installed
	$(BIN)/python docs/make_sensitivity.py docs

setup: .venv/dev-installed

clean:
	rm -rf .venv site videos previews figures coverage .coverage* dist build .*_cache

.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "emovid needs Python 3.11 or newer: make PYTHON=python3.11 $(MAKECMDGOALS)")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable .
	touch $@

.venv/dev-installed: .venv/installed
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $@
