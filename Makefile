# `make all-videos` and `make test` install what they need. The other targets are for those who develop emovid.
# Videos of edited scenes are replaced by: make all-videos FLAGS=--force
PYTHON ?= python3
JOBS ?= $(shell getconf _NPROCESSORS_ONLN 2>/dev/null || echo 1)
BIN := .venv/bin

.PHONY: all-videos robotarium-videos claims-table robotarium-table figures gallery golden kit study test chaos coverage lint format bench bench-survey rehearsal readme docs sensitivity validate-statistics setup clean

all-videos: .venv/installed
	$(BIN)/emovid render --all --jobs $(JOBS) -o videos $(FLAGS)

robotarium-videos: .venv/installed
	$(BIN)/emovid render --all --platform robotarium --view overhead --jobs $(JOBS) -o videos/robotarium/overhead $(FLAGS)
	$(BIN)/emovid render --all --platform robotarium --view perspective --jobs $(JOBS) -o videos/robotarium/perspective $(FLAGS)

figures: .venv/installed
	$(BIN)/emovid figures all gallery -o figures --force

gallery: .venv/installed
	$(BIN)/emovid figures gallery -o figures --force

test: .venv/dev-installed
	$(BIN)/python -m pytest -n $(JOBS) --dist loadfile

chaos: .venv/dev-installed
	$(BIN)/python -m tests.chaos --table docs/chaos.md
	EMOVID_EXAMPLES=2000 $(BIN)/python -m pytest -q tests/chaos/test_fuzz.py

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
	$(BIN)/python benchmarks $(ONLY)

rehearsal: .venv/dev-installed
	EMOVID_REHEARSAL="6 6" $(BIN)/python -m pytest -q tests/survey/test_browser_study.py tests/survey/test_browser_access.py

bench-survey: .venv/dev-installed
	$(BIN)/python benchmarks survey

readme: .venv/dev-installed
	$(BIN)/python docs/make_architecture.py docs/pictures/architecture.svg
	$(BIN)/python docs/make_picture.py docs/six-emotions.webp
	$(BIN)/emovid figures anger-frames confusion-matrix --format png -o docs/pictures --force
	$(BIN)/python docs/make_survey_picture.py docs/pictures/survey.png

docs: .venv/dev-installed gallery
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

golden: .venv/dev-installed
	$(BIN)/python -m tests.helpers.golden

claims-table: .venv/installed
	$(BIN)/python docs/make_claims.py docs

robotarium-table: .venv/installed
	$(BIN)/python docs/make_robotarium.py docs

sensitivity: .venv/installed
	$(BIN)/python docs/make_sensitivity.py docs

validate-statistics: .venv/installed
	OPENBLAS_NUM_THREADS=1 $(BIN)/python docs/make_validation.py docs

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
