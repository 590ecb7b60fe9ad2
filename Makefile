# Everything a person does with this checkout. `make` alone prints this list.
# The environment in .venv is made, with the locked versions, by the first target that needs it.

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
# names of cases that golden leaves out, or alone takes, for who has little time
LEFT_OUT ?=
ONLY ?= *
SKIPPED := $(LEFT_OUT:%=cases/%.toml)
SHIPPED := $(filter-out $(SKIPPED),$(sort $(wildcard $(ONLY:%=cases/%.toml))))
SWEEPS := $(filter %_sweep.toml,$(SHIPPED))
CASES := $(filter-out %_sweep.toml,$(SHIPPED))
NAMES := $(basename $(notdir $(CASES)))
SWEPT := $(SWEEPS:cases/%.toml=%.sweep)
RESULTS = $(NAMES:%=outputs/golden/%.h5) $(SWEPT:%=outputs/golden/%.h5)
WORKERS ?= 2
PYTEST_OPTIONS ?=
DIST ?= dist
# another BLAS kernel for `make test-kernel`, or "commit": the one that the commit's hash chooses; and
# tests of docs, packaging, pictures, reports, files, words and the command line: none hangs on a kernel
KERNEL ?= commit
NO_NUMBERS := docs* site package examples ci_example *plots *pictures python \
  cli* start_up architecture bad_cases_streams bad_cases_reports bad_cases_cli bad_cases_results \
  property_every_key property_store property_compare property_units property_select golden up_to_date \
  *_editors *_html *_template *_report *_files *_needs *_saying \
  *_sweep_assembly *_sweep_pool *_sweep_survival *_verdicts *_migrate \
  *_json *_store *_references *_overrides *_locate \
  bad_cases bad_cases_absorber bad_cases_compressor bad_cases_coupling bad_cases_engine \
  bad_cases_m* bad_cases_pump bad_cases_roll bad_cases_rows \
  bad_cases_rules bad_cases_sweep* bad_cases_values bad_cases_where*
# where the commit's hash chooses the kernel, its last digit chooses the eighth that runs of two sorts
DIGIT = $(if $(filter commit,$(KERNEL)),$(shell git rev-parse HEAD | tail -c 2))
IDLE = $(if $(filter 0 8,$(DIGIT)),[!ab])$(if $(filter 1 9,$(DIGIT)),[!c-e])$(if $(filter 2 a,$(DIGIT)),[!f-i])$(if \
  $(filter 3 b,$(DIGIT)),[!j-m])$(if $(filter 4 c,$(DIGIT)),[!n-q])$(if $(filter 5 d,$(DIGIT)),[!r])$(if \
  $(filter 6 e,$(DIGIT)),[!s])$(if $(filter 7 f,$(DIGIT)),[!t-z])

export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help run sweep test test-kernel check lint types golden golden-results accept-golden accept-snapshots \
  plots docs package bench matrix test-long clean

help: ## print this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 16

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt --upgrade pip
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt \
	  -e '.[plot,accuracy]' --group test
	$(BIN)/python -m compileall -q -j $(WORKERS) -x '/(tests?|pip|setuptools|mypyc?|fontTools)/' \
	  $(VENV)/lib vibecalc tests docs/site
	@touch $@

run: $(READY) ## run the three-cylinder generator and print its report
	$(BIN)/vibecalc run cases/generator.toml -q
	@cat outputs/generator.txt

sweep: $(SWEPT:%=outputs/%.h5) ## compute the sweeps of cases/*_sweep.toml that are not up to date

# What an interrupt left is taken up, what a changed case made useless is thrown away. The sweep
# renames the whole file onto its target; the touch is for one that was up to date already.
# Next to it stands which data files it was made from.
outputs/%.sweep.h5: cases/%.toml $(READY)
	$(BIN)/vibecalc check $< --depfile $@.d -q
	$(BIN)/vibecalc sweep $< -o $@ -j $(WORKERS) --if-needed --resume -q
	@touch $@

-include $(wildcard outputs/*.sweep.h5.d)

test: $(READY) ## run the tests
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -m "not long" $(PYTEST_OPTIONS)

test-kernel: $(READY) ## run the tests of numbers with another BLAS kernel, KERNEL=Nehalem
	$(BIN)/python tests/matrix/kernel.py $(KERNEL) $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal \
	  -m "not long" $(foreach one,$(NO_NUMBERS),--ignore-glob='tests/test_$(one).py') \
	  $(if $(IDLE),$(foreach one,consistency property,--ignore-glob='tests/test_$(one)_$(IDLE)*.py')) $(PYTEST_OPTIONS)

check: lint types test golden ## lint, types, tests, golden files

lint: $(READY) ## ruff
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY) ## mypy
	$(BIN)/mypy

golden: $(READY) golden-results ## run every case, compare with tests/golden
	@printf '%s\n' $(RESULTS) | xargs -P $(WORKERS) -n 14 $(BIN)/vibecalc diff \
	  --partial --rules tests/golden/rules.toml tests/golden/

# WORKERS processes at a time, a few cases in each.
golden-results: $(READY)
	@mkdir -p outputs/golden
	@printf '%s\n' $(CASES) | xargs -r -P $(WORKERS) -n 5 $(BIN)/vibecalc run -q -o outputs/golden/
	@printf '%s\n' $(SWEPT:%.sweep=%) | xargs -r -P $(WORKERS) -I {} $(BIN)/vibecalc sweep cases/{}.toml -q \
	  --fresh -j 1 -o outputs/golden/{}.sweep.h5

accept-golden: $(READY) golden-results ## make the numbers of this checkout the golden ones
	@$(BIN)/vibecalc diff --accept --partial tests/golden/ $(RESULTS)

accept-snapshots: $(READY) ## make reports, checks, words of pictures and refusals those to hold
	$(BIN)/python tests/snapshots/said.py
	$(BIN)/python tests/refused.py

plots: $(READY) sweep ## draw the pictures of every case into outputs/
	$(BIN)/vibecalc run $(CASES) -q
	$(BIN)/vibecalc plot $(NAMES:%=outputs/%.h5) $(SWEPT:%=outputs/%.h5)

# The same bytes wherever and whenever it is built; tests/test_package.py installs and uses it.
package: $(READY) ## build the source distribution and, from it, the wheel, into dist/
	@rm -f $(DIST)/vibecalc-*
	$(BIN)/python -m hatchling build -t sdist -d $(DIST)
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation \
	  -w $(DIST) $(DIST)/vibecalc-*.tar.gz

docs: $(VENV)/.docs sweep ## build the site into docs/_build/html; a warning is an error
	$(BIN)/python docs/site/generate.py $(WORKERS)
	$(BIN)/sphinx-build -q -j $(WORKERS) -W --keep-going -c docs/site -d docs/_build/doctrees docs docs/_build/html
	@echo docs/_build/html/index.html

$(VENV)/.docs: $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt --group docs
	@touch $@

bench: $(READY) ## all benchmarks as ratios: benchmarks/RESULTS.md (10 minutes)
	$(BIN)/python benchmarks/run.py

matrix: $(READY) ## every case with other versions, Pythons, kernels and threads; into tests/matrix/ENVIRONMENTS.md
	$(BIN)/python tests/matrix/run.py --environments $(VENV)/matrix

test-long: $(READY) $(VENV)/.docs matrix ## long searches, the full fuzz, the matrix
	$(BIN)/python -m pytest -n $(WORKERS) -m long --timeout 14400

clean: ## remove the environment, caches and outputs
	rm -rf docs/_build docs/generated
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
	find outputs -mindepth 1 ! -name .gitkeep -delete
