# Two commands do everything:   make demo   (the main job on a sample bench)   and   make test
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO_OUT := demo-out

.PHONY: demo examples test page bench slow lint types docs clean

demo: $(VENV)/installed
	@sh scripts/system-packages.sh
	@echo "1. What is on each recording of a bench of soybeans, and how well is it known?"
	@$(BIN)/benchtwin measure samples/soybean-bench --out $(DEMO_OUT)/measured --overwrite
	@printf "\n2. Which contact parameters make a simulation do the same? (5 to 7 minutes; stopped, make demo goes on)\n"
	@$(BIN)/benchtwin calibrate samples/soybean-bench --out $(DEMO_OUT)/calibrated --quick --overwrite
	@printf "\n3. Is anything in the recordings that no parameter explains?\n"
	@$(BIN)/benchtwin diagnose samples/soybean-bench --out $(DEMO_OUT)/diagnosed --quick --overwrite
	@printf "\nWhat the bench was made with: "; $(BIN)/python samples/concealed.py reveal samples/soybean-bench
	@echo "Open in a browser:  $(DEMO_OUT)/calibrated/report.html   $(DEMO_OUT)/diagnosed/report.html   $(DEMO_OUT)/measured/overlays/index.html"

examples: $(VENV)/installed        # every other kind of recording, and what else may be missing: some minutes
	@sh scripts/system-packages.sh
	@echo "1. Photos, films, tracks, sounds, readings, a paper's means, gates, other tools' files; the shapes of a lot"
	@$(BIN)/benchtwin measure samples/drawn-bench samples/board-heap samples/soybean-paper samples/heard-drop samples/gates-roll samples/imported-drop --out $(DEMO_OUT)/examples --overwrite
	@$(BIN)/benchtwin shape samples/seed-lot/spread.jpg --scanner --out $(DEMO_OUT)/lot --overwrite
	@echo "2. A drop simulated, filmed and measured"
	@$(BIN)/benchtwin simulate drop --out $(DEMO_OUT)/twin-drop
	@echo "3. A published calibration, recomputed from its printed simulations"
	@$(BIN)/benchtwin calibrate samples/soybean-paper --tables --out $(DEMO_OUT)/paper --overwrite
	@echo "4. Drops with something concealed: what is missing, and the twin again with it"
	@$(BIN)/benchtwin diagnose samples/concealed-drop --out $(DEMO_OUT)/diagnosed-drop --overwrite
	@echo "5. Damp seeds on a plate: what does friction follow?"
	@$(BIN)/benchtwin diagnose samples/damp-slides --out $(DEMO_OUT)/diagnosed-slides --quick --overwrite
	@echo "6. Heaps of damp beads beside dry ones, and the twin again with liquid between them (some minutes)"
	@$(BIN)/benchtwin diagnose samples/damp-heaps --out $(DEMO_OUT)/diagnosed-heaps --quick --overwrite

test: $(VENV)/installed            # style, types of the Python interface, documentation, tests: what CI runs
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pytest -n auto --dist worksteal

PAGE := $(DEMO_OUT)/page-benches
page: $(VENV)/installed            # sample benches in the browser, copied so that they can be changed
	@mkdir -p $(PAGE)
	@for bench in soybean-bench drawn-bench heard-drop; do test -d $(PAGE)/$$bench || cp -r samples/$$bench $(PAGE)/; done
	@$(BIN)/benchtwin page $(PAGE)

slow: $(VENV)/installed            # statistical studies and further cases: many minutes
	$(BIN)/pytest -n auto -m slow

bench: $(VENV)/installed           # tables of accuracy and speed, side by side with peers
	$(BIN)/pip install -qq --disable-pip-version-check -e '.[bench]'
	for study in benchmarks/[a-z]*.py; do echo "== $$study"; $(BIN)/python $$study || exit 1; done

lint: $(VENV)/installed
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(MAKE) types

types: $(VENV)/installed
	$(BIN)/mypy

docs: $(VENV)/installed            # the documentation as a site: build/site/index.html
	$(BIN)/python scripts/keys_reference.py
	$(BIN)/python scripts/seeds_reference.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "Open in a browser:  build/site/index.html"

clean:
	rm -rf $(VENV) $(DEMO_OUT) build .pytest_cache .ruff_cache

$(VENV)/installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("benchtwin needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Name another:  make PYTHON=python3.12 ...") if sys.version_info < (3, 11) else 0'
	@$(PYTHON) -m venv $(VENV) || { echo "Python cannot make a virtual environment here. On Debian or Ubuntu:  sudo apt-get install python3-venv"; exit 1; }
	@echo "Installing benchtwin and what it needs into $(VENV) (once; about a minute) ..."
	@$(BIN)/python -m pip install -qq --disable-pip-version-check -e '.[dev,docs]'
	@touch $@
