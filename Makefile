# Two commands do everything:   make demo   (the main job on samples/)   and   make test
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO_OUT := demo-out

.PHONY: demo test bench slow lint clean

demo: $(VENV)/installed
	@sh scripts/system-packages.sh
	@echo "1. Measuring the sample recordings"
	@$(BIN)/benchtwin measure samples/drawn-bench samples/soybean-paper --out $(DEMO_OUT)/bench --overwrite
	@echo "2. The same rigs simulated, filmed and measured (some minutes, most of it the pile)"
	@$(BIN)/benchtwin simulate drop --out $(DEMO_OUT)/twin-drop
	@$(BIN)/benchtwin simulate slide --from samples/twin/slide.toml --out $(DEMO_OUT)/twin-slide
	@$(BIN)/benchtwin simulate roll --out $(DEMO_OUT)/twin-roll
	@$(BIN)/benchtwin simulate pile --from samples/twin/slab.toml --out $(DEMO_OUT)/twin-pile
	@echo "3. A soybean calibration, from its published readings and simulations"
	@$(BIN)/benchtwin calibrate samples/soybean-paper --tables --out $(DEMO_OUT)/calibrated --overwrite
	@echo "4. Drops and rolls with something concealed: what is missing, and the twin again with it (a minute or two)"
	@$(BIN)/benchtwin diagnose samples/concealed-drop --out $(DEMO_OUT)/diagnosed-drop --overwrite
	@$(BIN)/benchtwin diagnose samples/concealed-roll --out $(DEMO_OUT)/diagnosed-roll --quick --overwrite

test: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/pytest -n auto

slow: $(VENV)/installed            # statistical studies: minutes
	$(BIN)/pytest -n auto -m slow

bench: $(VENV)/installed           # tables of accuracy and speed, side by side with peers
	$(BIN)/pip install -qq --disable-pip-version-check -e '.[bench]'
	for study in benchmarks/[a-z]*.py; do echo "== $$study"; $(BIN)/python $$study || exit 1; done

lint: $(VENV)/installed
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) $(DEMO_OUT) .pytest_cache .ruff_cache

$(VENV)/installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("benchtwin needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Name another:  make PYTHON=python3.12 ...") if sys.version_info < (3, 11) else 0'
	@$(PYTHON) -m venv $(VENV) || { echo "Python cannot make a virtual environment here. On Debian or Ubuntu:  sudo apt-get install python3-venv"; exit 1; }
	@echo "Installing benchtwin and what it needs into $(VENV) (once; about a minute) ..."
	@$(BIN)/python -m pip install -qq --disable-pip-version-check -e '.[dev]'
	@touch $@
