# Everything starts here: `make demo` from a fresh clone sets up what it needs, then makes the demo.

PYTHON ?= python3.11
RECIPE ?= recipes/demo.toml
PEERS ?= ../shared/peers
RUNS ?= 3

BIN := .venv/bin
STAGES := body outfit simulate register encode train report
RUN := $(BIN)/python -m pipeline run "$(RECIPE)" $(if $(MOTION),--motion "$(MOTION)") $(if $(FRAMES),--frames $(FRAMES)) $(if $(JOBS),--jobs $(JOBS))

.DEFAULT_GOAL := help
.PHONY: help env demo test status peers curve extremes fabrics plan sequences outfits quality collisions motions $(STAGES)

help:
	@echo "make demo                   set up, then make the demo: people, clothes, motion, models, report"
	@echo "make demo MOTION=walk.bvh   the same on your own motion capture; FRAMES=120 for longer sequences"
	@echo "make test                   set up, then lint, types and tests"
	@echo "make STAGE RECIPE=FILE      run a recipe up to a stage: $(STAGES)"
	@echo "make status RECIPE=FILE     show what is done"
	@echo "make extremes               the solver at the extremes: docs/solver/extremes.md"
	@echo "make fabrics                drape, bending and stretch beside published figures: docs/solver/fabrics.md"
	@echo "make plan                   what leaving out gains, scene by scene: docs/solver/plan.md; ARGS=--quick"
	@echo "make curve PEERS=FOLDER     its error against time, Blender's beside it: docs/solver/curve.md; ARGS=--quick"
	@echo "make peers PEERS=FOLDER     it and Blender in turn on common scenes: docs/solver/peers.md; RUNS=3, ARGS='--scenes A'"
	@echo "make sequences MOTION=DIR   20 people in the folder's clips, made and judged: docs/solver/sequences.md; ARGS='--count 2'"
	@echo "make outfits                every garment drawn, one parameter at a time, and 100 outfits: docs/outfit; ARGS='--only top'"
	@echo "make quality                500 outfits at the extremes of shape, made and measured: docs/outfit/quality.md; ARGS='--count 48'"
	@echo "make motions MOTION=DIR     every motion of a folder on a body, measured and drawn: docs/body/motion.md"
	@echo "make collisions MOTION=DIR  how bodies that run into themselves are freed: docs/body/collisions.md; ARGS='--count 4'"
	@echo "make env                    set up only; PYTHON=/path/to/python3.11 if it isn't on the path, JOBS=N tasks at a time"

env: .venv/.installed

# The stamp comes last: an installation that was interrupted is taken up again.
.venv/.installed: requirements.lock pyproject.toml
	@command -v "$(PYTHON)" > /dev/null || { echo "$(PYTHON) not found: install Python 3.11, or name it: make PYTHON=/path/to/python3.11" >&2; exit 1; }
	@echo "Setting up .venv from requirements.lock; the first time takes some minutes"
	@test -x $(BIN)/python || "$(PYTHON)" -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

demo: env
	@$(RUN)

$(STAGES): env
	@$(RUN) --until $@

status: env
	@$(BIN)/python -m pipeline status "$(RECIPE)" $(if $(MOTION),--motion "$(MOTION)") $(if $(FRAMES),--frames $(FRAMES)) --why

test: env
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest

# What measures the solver. Blender lives in an environment of its own, as its packages are pinned to its Python.
extremes: env
	@$(BIN)/python -m tools.solver.extremes $(ARGS)

fabrics: env
	@$(BIN)/python -m tools.solver.fabrics $(ARGS)

sequences: env
	@test -n "$(MOTION)" || { echo "name a folder of BVH files: make sequences MOTION=FOLDER" >&2; exit 1; }
	@$(BIN)/python -m tools.solver.sequences --motion "$(MOTION)" $(ARGS)

outfits: env
	@$(BIN)/python -m tools.outfit.looks $(ARGS)

quality: env
	@$(BIN)/python -m tools.outfit.quality $(ARGS)

motions: env
	@test -n "$(MOTION)" || { echo "name a folder of motion files: make motions MOTION=FOLDER" >&2; exit 1; }
	@$(BIN)/python -m tools.body.motions "$(MOTION)" $(ARGS)

collisions: env
	@test -n "$(MOTION)" || { echo "name a folder of motion files: make collisions MOTION=FOLDER" >&2; exit 1; }
	@$(BIN)/python -m tools.body.collisions --motion "$(MOTION)" $(ARGS)

curve: env
	@$(BIN)/python -m tools.solver.curve --peers "$(PEERS)" $(ARGS)

plan: env
	@$(BIN)/python -m tools.solver.plan --peers "$(PEERS)" $(ARGS)

peers: env .peers/.installed
	@$(BIN)/python -m tools.solver.peers --peers "$(PEERS)" --runs $(RUNS) $(ARGS)

.peers/.installed:
	@test -f "$(PEERS)/run_blender.py" || { echo "$(PEERS): no run_blender.py there; name the peers' folder: make peers PEERS=/path/to/peers" >&2; exit 1; }
	@echo "Setting up .peers with Blender as a Python module"
	@test -x .peers/bin/python || "$(PYTHON)" -m venv .peers
	@.peers/bin/python -m pip install --quiet --disable-pip-version-check bpy==4.5.15
	@touch $@
