# Two commands do everything: `make study` and `make test`. Both make the environment first.
PYTHON ?= python3
ENVIRONMENT := .venv
BIN := $(ENVIRONMENT)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check
STUDIES := thesis_chapter3 thesis_chapter3_steps lugre_reference hunting observers compensation comparison

THESIS := thesis_chapter3 thesis_chapter3_steps thesis_chapter4
TUNINGS := tuning tuning_robust tuning_rotation
IDENTIFICATIONS := 0_rpm rotary rotating

.PHONY: study study-thesis study-closed-loop study-tuning study-decision test lint benchmark diagnosis clean

study: $(ENVIRONMENT)/ready
	@set -e; for name in $(STUDIES); do \
		$(BIN)/workbench run studies/$$name.toml --out results/$$name --overwrite; \
	done

# The thesis, chapter by chapter; chapter 5 comes last, after what chapter 4 measures.
study-thesis: $(ENVIRONMENT)/ready
	@set -e; for name in $(THESIS); do \
		$(BIN)/workbench run studies/$$name.toml --out results/$$name --overwrite; \
	done; for name in $(IDENTIFICATIONS); do \
		$(BIN)/workbench identify studies/identification/owen2001_$$name.toml \
			--out results/identify_$$name --overwrite; \
	done; \
	$(BIN)/workbench run studies/thesis_chapter5.toml --out results/thesis_chapter5 --overwrite

# A rig whose model lacks something, what a diagnosis of its records says, and which controllers are best then.
study-closed-loop: $(ENVIRONMENT)/ready
	$(BIN)/workbench run studies/closed_loop/rig.toml --out results/closed_loop_rig --overwrite
	$(BIN)/workbench diagnose studies/closed_loop/experiment.toml --out results/closed_loop_diagnosis --overwrite
	$(BIN)/workbench run studies/closed_loop.toml --out results/closed_loop --overwrite

# Controllers tuned alike: on the believed plant, on machines that may be met, and with the speed of rotation; then the
# comparison with tuned gains.
study-tuning: $(ENVIRONMENT)/ready
	@set -e; for name in $(TUNINGS); do \
		$(BIN)/workbench tune studies/$$name.toml --out results/$$name --overwrite; \
	done; \
	$(BIN)/workbench run studies/comparison_tuned.toml --out results/comparison_tuned --overwrite

# Which controller and rpm meet an accuracy at a speed, on machines that are drawn.
study-decision: $(ENVIRONMENT)/ready
	$(BIN)/workbench decide studies/decision.toml --out results/decision --overwrite

test: lint
	$(BIN)/python -m pytest -n 2

lint: $(ENVIRONMENT)/ready-for-tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

benchmark: $(ENVIRONMENT)/ready-for-tests
	$(BIN)/python benchmarks/closed_loop.py

# How often diagnosis names the right effect. SET=reported has the seeds of the published figures.
SET ?= tuning
diagnosis: $(ENVIRONMENT)/ready-for-tests
	$(BIN)/python -m tests.diagnosis.suite --set $(SET) --out results/diagnosis_$(SET)

clean:
	rm -rf $(ENVIRONMENT) results

$(ENVIRONMENT)/ready: pyproject.toml
	$(PYTHON) -m venv $(ENVIRONMENT)
	$(INSTALL) --editable .
	@touch $@

$(ENVIRONMENT)/ready-for-tests: $(ENVIRONMENT)/ready
	$(INSTALL) --editable ".[test]"
	@touch $@
