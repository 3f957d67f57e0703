# Two commands do everything: `make study` and `make test`. Both make the environment first.
PYTHON ?= python3
ENVIRONMENT := .venv
BIN := $(ENVIRONMENT)/bin
# Without bytecode, of which pip would make 190 MB: Python makes it of what it uses, and keeps it, whatever the shell says,
# or else each command would compile anew what it imports.
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
export PYTHONDONTWRITEBYTECODE :=
STUDIES := thesis_chapter3 thesis_chapter3_steps lugre_reference hunting observers compensation rotary_drive two_inertia_drive
QUICK := --draws 2 --fresh-draws 6
COMPARISONS := comparison friction_model_worth hunting_rotation rotation_on_demand rotary_friction

THESIS := thesis_chapter3 thesis_chapter3_steps thesis_chapter4
TUNINGS := tuning tuning_rotation tuning_comparison tuning_hoses
IDENTIFICATIONS := 0_rpm rotary rotating
MACHINES := thesis_rig thesis_simulation

.PHONY: study study-comparison study-thesis study-closed-loop study-tuning study-decision test tested test-thorough combinations export-proof fmu-proof fuzz kills lint docs docs-answers docs-test benchmark diagnosis design-proof clean

study: $(ENVIRONMENT)/ready
	@set -e; for name in $(STUDIES); do \
		$(BIN)/workbench run studies/$$name.toml --out results/$$name --overwrite; \
	done; \
	$(BIN)/workbench run studies/comparison.toml $(QUICK) --out results/comparison --overwrite

# The main comparison with all its draws, and the studies that answer what it leaves out.
study-comparison: $(ENVIRONMENT)/ready
	@set -e; for name in $(COMPARISONS); do \
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

# Controllers tuned alike: on the believed plant, with the speed of rotation, and on machines that may be met, for each of the
# comparison's machines and speeds of rotation: the gains of studies/tuned/.
study-tuning: $(ENVIRONMENT)/ready
	@set -e; for name in $(TUNINGS); do \
		$(BIN)/workbench tune studies/$$name.toml --out results/$$name --overwrite; \
	done

# Which controller and rpm meet an accuracy at a speed, on draws of either machine.
study-decision: $(ENVIRONMENT)/ready
	@set -e; for machine in $(MACHINES); do \
		$(BIN)/workbench decide studies/decision.toml --machine $$machine --out results/decision_$$machine --overwrite; \
	done

# Types are checked on one processor: the tests begin beside that, and know nothing of it, since some call make themselves.
test: $(ENVIRONMENT)/ready-for-tests
	@$(MAKE) --no-print-directory --jobs=2 lint tested

tested: $(ENVIRONMENT)/ready-for-tests
	env -u MAKEFLAGS -u MFLAGS $(BIN)/python -m pytest -n 2 --dist worksteal  # in the order of tests/conftest.py

# What takes minutes: whole diagnoses of measured records and of further machines, the closed loop from end to end, and
# whether the generators of records are right by which diagnoses are proved.
test-thorough: $(ENVIRONMENT)/ready-for-tests
	$(BIN)/python -m pytest -n 2 --dist worksteal -m thorough

# Every plant with every friction law and every controller, checked, and simulated where that is admitted.
combinations: $(ENVIRONMENT)/ready-for-tests
	PYTHONPATH=tests/helpers $(BIN)/python -m combinations

# The exported C of every controller, of plug-ins too, against the program's own compiled equations: some minutes.
export-proof: $(ENVIRONMENT)/ready-for-tests
	PYTHONPATH=tests/helpers $(BIN)/python -m export_proof

# Mutated studies, experiments, parameters, gains and records: whatever a file holds, a command works or refuses it in at most
# three lines. KIND=check, run or records takes one kind; a finding is printed with the command that repeats it.
KIND ?=
SECONDS ?= 600
SEED ?= 1
fuzz: $(ENVIRONMENT)/ready-for-tests
	PYTHONPATH=tests/helpers $(BIN)/python -m fuzz $(KIND) --seconds $(SECONDS) --seed $(SEED)

# A command (run, tune, decide, diagnose) stopped at random moments and repeated: nothing is lost, the bytes are the same.
COMMAND ?= run
ROUNDS ?= 20
JOBS ?= 2
kills: $(ENVIRONMENT)/ready-for-tests
	PYTHONPATH=tests/helpers $(BIN)/python -m kills --command $(COMMAND) --rounds $(ROUNDS) --jobs $(JOBS) --seed $(SEED)

# Exported plants in an importer that is not ours, FMPy, in closed loop beside the studies that they are from: a table.
fmu-proof: $(ENVIRONMENT)/ready-for-tests
	$(INSTALL) --editable ".[fmi]"
	PYTHONPATH=tests/helpers $(BIN)/python -m fmu_proof

lint: $(ENVIRONMENT)/ready-for-tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# The guide as a site, results/docs/index.html: warnings, dead links among them, are errors. The gallery's studies are run
# first, some two minutes; they are kept, and run again where something has changed.
docs: $(ENVIRONMENT)/ready-for-docs
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --fresh-env --quiet --doctree-dir results/docs_doctrees docs results/docs

# What came out of the studies, as docs/answers.md tells it. DRAWS and FRESH are those of the comparison: fewer take less.
DRAWS ?= 10
FRESH ?= 40
docs-answers: $(ENVIRONMENT)/ready
	PYTHONPATH=docs $(BIN)/python -m builder.answers --draws $(DRAWS) --fresh-draws $(FRESH)

# Every code block of the guide, run as a reader would: minutes. PAGE=tuning runs those of one page.
PAGE ?=
docs-test: $(ENVIRONMENT)/ready-for-tests
	PYTHONPATH=tests/helpers $(BIN)/python -m snippets $(PAGE)

# All that should be seen of the program's speed, written to docs/benchmarks.md: some ten minutes, with FULL=1 hours.
FULL ?=
benchmark: $(ENVIRONMENT)/ready-for-tests
	$(BIN)/python benchmarks/all.py $(if $(FULL),--full)

# How often diagnosis names the right effect, on machines of all kinds and sizes, beside what can be found at all. Takes
# hours; what is done is kept. SET=reported has the seeds of the published figures; FIRST=10 takes ten cases of each kind.
SET ?= tuning
FIRST ?=
diagnosis: $(ENVIRONMENT)/ready-for-tests
	PYTHONPATH=tests/helpers $(BIN)/python -m family.suite --set $(SET) $(if $(FIRST),--first $(FIRST)) --resume \
		--out results/diagnosis_$(SET)

# Whether designed motions decide what a first record left open, and as surely as they say, on the generator's machines. Takes
# an hour or more; what is done is kept.
design-proof: $(ENVIRONMENT)/ready-for-tests
	PYTHONPATH=tests/helpers $(BIN)/python -m design_proof --out results/design_proof

clean:
	rm -rf $(ENVIRONMENT) results

$(ENVIRONMENT)/ready: pyproject.toml
	$(PYTHON) -m venv $(ENVIRONMENT)
	$(INSTALL) --editable .
	@touch $@

$(ENVIRONMENT)/ready-for-tests: $(ENVIRONMENT)/ready
	$(INSTALL) --editable ".[test]"
	@touch $@

$(ENVIRONMENT)/ready-for-docs: $(ENVIRONMENT)/ready
	$(INSTALL) --editable ".[docs]"
	@touch $@
