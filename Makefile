# SPDX-License-Identifier: GPL-3.0-or-later
# Every target sets up what it needs; tools/setup.sh tells which Python and Blender it takes and how to choose others.
LAMINA_BPY ?=
VENV ?= .venv$(addprefix -,$(LAMINA_BPY))
export LAMINA_BPY

READY := $(VENV)/ready
RUN := $(VENV)/bin/python
SOURCES := $(shell find addon demo_blend osl reference_py -type f \( -name '*.py' -o -name '*.osl' -o -name '*.h' -o -name '*.json' \))

.PHONY: help demo test bench zip validate blends charts pareto clean

help:
	@echo "make demo      render every demo scene into build/demo"
	@echo "make test      run all tests, then build and validate the extension"
	@echo "make bench     print how fast the reference models are"
	@echo "make zip       build the extension into dist/"
	@echo "make validate  build it and check it with Blender's own tool"
	@echo "make blends    build the .blend files of demo_blend/ anew"
	@echo "make charts    measure the tables of figures/ anew and draw them"
	@echo "make pareto    measure error against cost in Cycles anew and draw it (half an hour, best on a quiet machine)"
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

test: $(READY)
	@# side by side: each is bound to one core
	@$(RUN) -m pytest tests/reference_py & reference=$$!; \
	$(RUN) -m pytest tests/addon tests/test_package.py; addon=$$?; \
	wait $$reference && exit $$addon
	@$(MAKE) --no-print-directory validate

bench: $(READY)
	$(RUN) tests/benchmarks/reference.py

zip: $(READY)
	@rm -rf dist
	$(RUN) tools/extension.py build dist

validate: zip
	$(RUN) tools/extension.py validate dist/*.zip

blends: $(READY)
	$(RUN) -m lamina.demo_blend.presets

charts: $(READY)
	$(RUN) -m pip install --quiet --disable-pip-version-check -e '.[figures]'
	for chart in network tiers error stress suite; do $(VENV)/bin/lamina chart $$chart -o figures || exit 1; done
	$(VENV)/bin/lamina figures --out figures/paper

pareto: $(READY)
	$(RUN) -m pip install --quiet --disable-pip-version-check -e '.[figures]'
	$(VENV)/bin/lamina chart levers -o figures
	$(VENV)/bin/lamina chart pareto -o figures
	$(VENV)/bin/lamina chart pair -o figures

clean:
	rm -rf build dist .pytest_cache .hypothesis
	find . -name __pycache__ -not -path './.venv*' -prune -exec rm -rf {} +
