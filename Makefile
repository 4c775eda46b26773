# SPDX-License-Identifier: GPL-3.0-or-later
# Every target sets up what it needs; tools/setup.sh tells which Python and Blender it takes and how to choose others.
LAMINA_BPY ?=
VENV ?= .venv$(addprefix -,$(LAMINA_BPY))
export LAMINA_BPY

READY := $(VENV)/ready
RUN := $(VENV)/bin/python
# What looks at style and types has an environment of its own.
CHECK := .venv-check
# What builds the manual, too.
DOCS := .venv-docs
SOURCES := $(shell find addon demo_blend osl reference_py -type f \( -name '*.py' -o -name '*.osl' -o -name '*.h' -o -name '*.json' \))

# The tests that run beside all others.
FIRST_HALF := $(shell cat tests/first_half.txt)
QUICK := -q -m "not blender and not slow"
# Of the reference's, those that `make check` runs beside the others.
BESIDE := $(wildcard tests/reference_py/test_weidlich_wilkie*.py)

.PHONY: gpu fit help demo style check thorough slow-tests test bench operations zip validate blends scenes thumbnails preset-sheet assets charts pareto viewport fit-table tilted-lobes scale killed-batch farm-tasks farm-race production field bakes bake-errors start felt branches budget surroundings house numbers fuzz faults calibration mitsuba-slabs docs sliders manual-pictures release matrix licences clean

help:
	@echo "make demo      render every demo scene into build/demo"
	@echo "make style     look at style and types alone"
	@echo "make check     look at style and types, and run what is quick without Blender (a minute)"
	@echo "make slow-tests  measure which tests without Blender are slow (tests/slow.txt, ten minutes)"
	@echo "make test      run all tests, then build and validate the extension"
	@echo "make thorough  run the cases that make test leaves out, as they take long (tests/thorough.txt, ten minutes)"
	@echo "make operations  do 1,000 random things with layers and check after each that all agree"
	@echo "make bench     print how fast the reference models are"
	@echo "make zip       build the extension into dist/"
	@echo "make validate  build it and check it with Blender's own tool"
	@echo "make release   build and validate it, and put its notes and the listing for Blender's extensions platform into dist/listing"
	@echo "make blends    build the .blend files of demo_blend/ anew"
	@echo "make scenes    render the pictures of the demo scenes into figures/scenes (half an hour)"
	@echo "make thumbnails  render the presets' pictures into addon/presets"
	@echo "make preset-sheet  lay those pictures out on one page, figures/all_presets.png"
	@echo "make assets    build the asset library of the presets in addon/presets anew"
	@echo "make charts    measure the tables of figures/ anew and draw them"
	@echo "make mitsuba   install Mitsuba 3 beside the rest and hold exports against it (a minute)"
	@echo "make mitsuba-slabs  hold stacks with media that scatter against explicit slabs in Mitsuba 3"
	@echo "make pareto    measure error against cost in Cycles anew and draw it (half an hour, best on a quiet machine)"
	@echo "make viewport  measure how EEVEE shows presets (half an hour without a graphics card; LAMINA_BLENDER names a Blender that has it)"
	@echo "make calibration  find the constants of the tier analytic and of the cost estimate again, and compare (an hour; writes tables alone)"
	@echo "make fit       measure how well stacks are found from measurements (an hour; goes on where it was stopped)"
	@echo "make fit-table measure how long the fit of a whole MERL table takes, beside a former commit (three minutes)"
	@echo "make tilted-lobes  measure what bakes reflect of a white world beside their formula (ten minutes)"
	@echo "make scale     measure time and memory as work grows, and draw them (ten minutes on a quiet machine)"
	@echo "make killed-batch  kill a batch of 200 pictures five times at random and compare it with an undisturbed one"
	@echo "make farm-tasks    measure what a farm's task costs beside its pictures"
	@echo "make farm-race     kill two workers of a farm at random for ten minutes and compare their pictures with an undisturbed run's"
	@echo "make production    put a scene as productions have them through batch, farm, apply and saves, beside a former commit (ten minutes)"
	@echo "make field     try a material beside a Principled one through the rest of Blender, and write figures/field.csv (ten minutes)"
	@echo "make bakes     measure what bakes cost beside those of a former commit, and how they follow a base's color (fifteen minutes)"
	@echo "make bake-errors  compare the errors of all bakes of chart tiers with those of a former commit (twenty minutes)"
	@echo "make start     measure what the extension adds to Blender's start (two minutes on a quiet machine; LAMINA_BLENDER names a Blender)"
	@echo "make felt      measure what a hand waits for: opening a file of 200 materials, a preset, a layer (two minutes on a quiet machine)"
	@echo "make budget    measure what a material costs with OSL and without, beside Principled: nodes, text, start, shading, growth (ten minutes on a quiet machine)"
	@echo "make branches  measure what both branches of a material cost beside one alone (five minutes on a quiet machine)"
	@echo "make gpu       hold ten presets on this machine's graphics card against the model (three minutes, no network; LAMINA_BLENDER names a Blender from blender.org)"
	@echo "make surroundings  render one file in its four surroundings (LAMINA_BLENDER names a Blender that has EEVEE)"
	@echo "make house     count how the code hangs together, beside what it was before it was rebuilt (a minute)"
	@echo "make numbers   put the numbers of the tables into README.md and docs/ (a test compares)"
	@echo "make fuzz      throw 100000 broken inputs at every reader"
	@echo "make faults    put deliberate faults into a copy, one at a time, and say which the tests catch (three minutes)"
	@echo "make docs      build the manual as a site, manual/index.html, which the extension ships"
	@echo "make sliders   render the manual's strips, one for each parameter (ten minutes)"
	@echo "make manual-pictures  take the pictures of the manual's first hour in a real window (LAMINA_BLENDER names a Blender that has one, as tools/window_blender.sh sets up)"
	@echo "make matrix    run the tests on every supported Blender whose Python is here, and print a table"
	@echo "make licences  print the licence of every pinned package"
	@echo "make clean     remove what was built (not $(VENV))"

$(READY): tools/setup.sh tools/check_bpy.py pyproject.toml setup.py $(wildcard requirements/*.txt)
	@tools/setup.sh $(VENV)
	@touch $@

demo: build/demo/ready
	@echo "The demo is in build/demo"

build/demo/ready: $(READY) $(SOURCES)
	@mkdir -p build
	$(VENV)/bin/lamina demo -o build/demo
	@touch $@

style: $(READY) $(CHECK)/ready
	$(CHECK)/bin/ruff check .
	$(CHECK)/bin/ruff format --check --quiet .
	@mkdir -p $(CHECK)/tree && ln -sfn $(CURDIR) $(CHECK)/tree/lamina
	@cd $(CHECK)/tree && ../bin/mypy --config-file $(CURDIR)/pyproject.toml --python-executable $(CURDIR)/$(RUN) --follow-imports silent \
	  --no-error-summary -p lamina.reference_py -p lamina.addon -p lamina.study -p lamina.demo_blend

check: style
	@# side by side; what the second says follows the first
	@$(RUN) -m pytest $(QUICK) tests/reference_py $(BESIDE:%=--ignore=%) & first=$$!; \
	{ $(RUN) -m pytest $(QUICK) $(BESIDE); beside=$$?; \
	$(RUN) -m pytest $(QUICK) tests --ignore=tests/reference_py; second=$$?; } >$(CHECK)/second.txt 2>&1; \
	wait $$first; first=$$?; cat $(CHECK)/second.txt; exit $$((first || beside || second))

slow-tests: $(READY)
	: > tests/slow.txt
	LAMINA_MEASURE_TESTS=1 $(RUN) -m pytest -q -m "not blender" tests
	@# without these, others are the first that need a bake or a model
	@before=; while [ "$$before" != "$$(cat tests/slow.txt)" ]; do before=$$(cat tests/slow.txt); \
	LAMINA_MEASURE_TESTS=1 $(RUN) -m pytest $(QUICK) tests; done

$(CHECK)/ready: requirements/check.txt
	$(RUN) -m venv $(CHECK)
	$(CHECK)/bin/python -m pip --disable-pip-version-check install --quiet --require-hashes --only-binary :all: -r requirements/check.txt
	@touch $@

test: $(READY)
	@# side by side: each is bound to one core, and tests/first_half.txt makes the halves about even
	@$(RUN) -m pytest $(FIRST_HALF) & first=$$!; \
	$(RUN) -m pytest tests $(FIRST_HALF:%=--ignore=%); second=$$?; \
	wait $$first && exit $$second
	@$(MAKE) --no-print-directory validate

thorough: $(READY)
	@# each line is a name, which may have spaces and quotes
	tr '\n' '\0' < tests/thorough.txt | LAMINA_THOROUGH=1 xargs -0 $(RUN) -m pytest

operations: $(READY)
	LAMINA_OPERATIONS=1000 $(RUN) -m pytest tests/addon/test_operations.py

bench: $(READY)
	$(RUN) tests/benchmarks/reference.py

zip: $(READY) docs
	@rm -rf dist
	$(RUN) tools/extension.py build dist

validate: zip
	$(RUN) tools/extension.py validate dist/*.zip

release: validate
	$(RUN) tools/release.py dist/listing dist/*.zip

blends: $(READY)
	$(RUN) -m lamina.demo_blend.build_presets
	$(RUN) -m lamina.demo_blend.scenes build

scenes: $(READY)
	$(RUN) -m lamina.demo_blend.scenes render

thumbnails: $(READY)
	$(RUN) -m lamina.demo_blend.thumbnails

preset-sheet: $(READY)
	$(RUN) -m lamina.demo_blend.thumbnails sheet

assets: $(READY)
	$(RUN) -m lamina.demo_blend.assets

charts: $(READY)
	for chart in lobes presets tiers error stress suite scattering peers; do $(VENV)/bin/lamina chart $$chart -o figures || exit 1; done
	$(VENV)/bin/lamina figures --out figures/paper

$(VENV)/mitsuba: $(READY) requirements/mitsuba.txt
	$(RUN) -m pip --disable-pip-version-check install --quiet --require-hashes --only-binary :all: -r requirements/mitsuba.txt
	@touch $@

mitsuba: $(VENV)/mitsuba
	$(RUN) -m pytest -q tests/reference_py/test_mitsuba.py

mitsuba-slabs: $(VENV)/mitsuba
	$(RUN) -m lamina.study.mitsuba_slabs

pareto: $(READY)
	$(VENV)/bin/lamina chart cost_factors -o figures
	$(VENV)/bin/lamina chart pareto -o figures
	$(VENV)/bin/lamina chart pair -o figures

viewport: $(READY)
	$(VENV)/bin/lamina chart viewport -o figures

calibration: $(READY)
	$(RUN) -m lamina.study.calibrate_analytic
	$(RUN) -m lamina.study.calibrate_cost --measure

fit: $(READY)
	$(VENV)/bin/lamina chart fit -o figures

fit-table: $(READY)
	$(RUN) tests/benchmarks/fit_table.py figures/fit_table.csv

tilted-lobes: $(READY)
	$(RUN) tests/benchmarks/tilted_lobes.py

scale: $(READY)
	$(VENV)/bin/lamina chart scale -o figures

killed-batch: $(READY)
	$(RUN) tests/benchmarks/killed_batch.py figures/killed_batch.csv

farm-tasks: $(READY)
	$(RUN) tests/benchmarks/farm_tasks.py figures/farm_tasks.csv figures/openjd.txt

farm-race: $(READY)
	$(RUN) tests/benchmarks/farm_race.py figures/farm_race.csv

production: $(READY)
	$(RUN) tests/benchmarks/production.py figures/production.csv

field: $(READY)
	$(RUN) tests/field figures/field.csv

bakes: $(READY)
	$(RUN) tests/benchmarks/bakes.py figures/bakes.csv
	$(VENV)/bin/lamina chart base_color -o figures

bake-errors: $(READY)
	$(RUN) tests/benchmarks/bake_errors.py

felt: $(READY)
	$(RUN) tests/benchmarks/felt.py figures/felt.csv

start: $(READY)
	$(RUN) tests/benchmarks/start.py figures/start.csv

branches: $(READY)
	$(RUN) tests/benchmarks/branches.py figures/branches.csv

budget: $(READY)
	$(RUN) tests/benchmarks/budget.py figures/budget.csv

surroundings: $(READY)
	$(RUN) tests/benchmarks/surroundings.py figures/surroundings.png figures/surroundings.csv

gpu:
	@test -n "$(LAMINA_BLENDER)" || { echo "make gpu: LAMINA_BLENDER names no Blender; give the program of a folder from blender.org: make gpu LAMINA_BLENDER=/path/to/blender"; exit 2; }
	@"$(LAMINA_BLENDER)" --background --factory-startup --python-exit-code 1 --python tests/benchmarks/gpu.py -- figures/gpu.csv $(DEVICES)

house: zip
	$(RUN) -m lamina.study.house

numbers: $(READY)
	$(RUN) -m lamina.study.numbers

fuzz: $(READY)
	$(RUN) tests/benchmarks/fuzz.py 100000 figures/fuzz.txt

faults: $(READY)
	$(RUN) tests/deliberate_faults.py

docs: $(DOCS)/ready
	@rm -rf manual
	$(DOCS)/bin/mkdocs build --quiet

$(DOCS)/ready: requirements/docs.txt
	$(or $(PYTHON),python3) -m venv $(DOCS)
	$(DOCS)/bin/python -m pip --disable-pip-version-check install --quiet --require-hashes --only-binary :all: -r requirements/docs.txt
	@touch $@

manual-pictures: zip
	$(RUN) tests/window/manual.py dist/lamina-*.zip docs/pictures
	cp docs/pictures/first_hour_car_paint.jpg tools/listing/featured.jpg

sliders: $(READY)
	$(VENV)/bin/lamina chart sliders -o docs/pictures

matrix:
	@$(or $(PYTHON),python3) tools/matrix.py -o figures/matrix.txt

licences: $(READY)
	@$(RUN) tools/licences.py

clean:
	rm -rf build dist manual .pytest_cache .hypothesis
	find . -name __pycache__ -not -path './.venv*' -prune -exec rm -rf {} +
