# SPDX-License-Identifier: GPL-2.0-or-later
# Thin front of CMake; `make help` lists the targets. See README.md and CONTRIBUTING.md.
BUILD ?= build
JOBS  ?= $(shell nproc)
RANKS ?= 2
EXE   := $(abspath $(BUILD))/liggghts-mpdem
DEMO  := $(BUILD)/demo

# Open MPI refuses to run as root unless told twice.
ifeq ($(shell id -u),0)
export OMPI_ALLOW_RUN_AS_ROOT = 1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM = 1
endif

.PHONY: help all demo test docs docs-pdf fuzz stress long tables check-deep mutants bench liggghts-from-source clean
.DEFAULT_GOAL := all

help:  ## this list
	@sed -n 's/^\([a-z-]*\):[^=]*## \(.*\)/\1 \2/p' $(firstword $(MAKEFILE_LIST)) | sed 's|$$(BUILD)|$(BUILD)|g; s|$$(DEMO)|$(DEMO)|g' | \
	  while read -r target words; do printf '  %-26s %s\n' "make $$target" "$$words"; done

all: $(BUILD)/.setup  ## set-up, and the program in $(BUILD); what `make` alone does
	cmake -S . -B $(BUILD) $(CMAKE_OPTIONS)
	cmake --build $(BUILD) --parallel $(JOBS)

$(BUILD)/.setup: tools/setup.sh
	tools/setup.sh
	mkdir -p $(BUILD)
	touch $@

# The flat pair pulled apart: figures on screen, CSV, PNG and GIF in $(DEMO). Those of doc/data/demo_* are made so.
# Files are compiled several at a time, which shortens a first build.
demo test: CMAKE_OPTIONS += -DMPDEM_UNITY=ON
demo: $(BUILD)/.setup  ## a pair pulled apart: figures on screen, CSV, PNG and GIF in $(DEMO); RANKS=
	cmake -S . -B $(BUILD) $(CMAKE_OPTIONS)
	cmake --build $(BUILD) --parallel $(JOBS) --target liggghts-mpdem
	rm -rf $(DEMO)
	mkdir -p $(DEMO)
	cp examples/pair_flat/* $(DEMO)/
	cd $(DEMO) && mpirun -np $(RANKS) $(EXE) -in in.flat_scaled
	/usr/bin/python3 tools/mpdem_plot.py $(DEMO) --points 'cut_*.txt'
	/usr/bin/python3 tools/mpdem_movie.py $(DEMO)
	@echo "Results: $(DEMO)/bond_scaled.csv, $(DEMO)/force_displacement.png, $(DEMO)/damage_cut.png, $(DEMO)/bond_breaks.gif"

# The benchmarks run in their short form. The tutorials of LIGGGHTS that a test runs come from its source.
test: CMAKE_OPTIONS += -DMPDEM_BENCH=ON -DCMAKE_COMPILE_WARNING_AS_ERROR=ON
test: all  ## set-up, build and every test in its short form; JOBS=1 for one at a time
	tools/setup.sh tests
	tools/fetch_liggghts.sh $(BUILD) || echo "Without the source of LIGGGHTS the test of its tutorials is skipped"
	cd $(BUILD) && ctest --output-on-failure --parallel $(JOBS)

# The manual of all pages: HTML whose search needs no network, and PDF.
docs:  ## the manual as HTML, which needs no network, in $(BUILD)/manual
	tools/setup.sh docs
	/usr/bin/sphinx-build -W --keep-going -q -b html -c doc/manual . $(BUILD)/manual
	@echo "The manual: $(BUILD)/manual/index.html"

docs-pdf:  ## the manual as PDF, in $(BUILD)/manual-pdf (LaTeX, some minutes)
	tools/setup.sh docs pdf
	/usr/bin/sphinx-build -W --keep-going -q -b latex -c doc/manual . $(BUILD)/manual-pdf
	$(MAKE) -C $(BUILD)/manual-pdf
	@echo "The manual: $(BUILD)/manual-pdf/user-mpdem.pdf"

# Scripts, point files and restart files with changed words and bytes, under AddressSanitizer and
# UndefinedBehaviorSanitizer; about half an hour. Findings are scripts in $(BUILD)/fuzz. MINUTES=20: no round of
# 3000 inputs begins later.
INPUTS ?= 100000
SEED   ?= 1
fuzz: $(BUILD)/.setup  ## scripts and files with changed words and bytes, half an hour; INPUTS=, SEED=, MINUTES=
	cmake -S . -B $(BUILD) $(CMAKE_OPTIONS)
	cmake --build $(BUILD) --parallel $(JOBS) --target fuzz_input
	mkdir -p $(BUILD)/figures
	$(BUILD)/tests/fuzz/fuzz_input --inputs $(INPUTS) --seed $(SEED) --jobs $(JOBS) --folder $(BUILD)/fuzz \
	  $(if $(MINUTES),--minutes $(MINUTES)) --json $(BUILD)/figures/fuzz.json

# Every test, those of stability at full length, and the table of doc/reliability.md from what they
# measured. The long form takes about half an hour on two cores.
stress: test  ## every test, those of stability at full length, and the tables of doc/reliability.md
	$(MAKE) long
	$(MAKE) tables

LONG ?= $(wildcard tests/stability/test_*.py)
long: all  ## the tests of stability at full length; LONG=files
	MPDEM_EXE=$(EXE) MPDEM_FIGURES=$(abspath $(BUILD))/figures JOBS=$(JOBS) tools/test_files.sh $(BUILD)/stress --long $(LONG)

tables:  ## the tables of doc/reliability.md from what the last tests measured
	/usr/bin/python3 tools/reliability.py $(BUILD)/figures doc/reliability.md

# Stress, pairs of options, changes, 20 minutes of fuzzing and the preset `sanitize`, in pieces. Called again it goes on where it was stopped.
check-deep:  ## before a release: stress, pairs of options, changes, fuzzing, clang, sanitizers; PIECES=names
	tools/check_deep.py --build $(BUILD) --jobs $(JOBS) $(PIECES)

# Bugs planted in a copy of the source, one at a time, and which test fails with each; hours. See tests/mutation/README.md.
# MUTANTS="--new 20 --since COMMIT" plants 20 more in the lines that changed since a commit.
mutants: $(BUILD)/.setup  ## bugs planted one at a time, and which test finds each; hours; MUTANTS=options
	mkdir -p $(BUILD)/figures
	/usr/bin/python3 -B tests/mutation/mutate.py --folder $(BUILD)/mutation --jobs $(JOBS) $(MUTANTS) --json $(BUILD)/figures/mutants.json
	/usr/bin/python3 tools/reliability.py $(BUILD)/figures doc/reliability.md

# LIGGGHTS itself from source, with the series of patches/ and the package inside, in
# $(BUILD)/from-source. TARBALL=... if it is at hand, JOBS=... for other than 2.
liggghts-from-source: $(BUILD)/.setup  ## LIGGGHTS compiled with the package inside; TARBALL=file
	tools/fetch_liggghts.sh $(BUILD)
	TARBALL=$(BUILD)/liggghts_3.8.0+repack1.orig.tar.xz tools/liggghts_from_source.sh $(BUILD)/from-source

# Rates, accuracy, tables and figures in $(BUILD)/bench/results. BENCH="--quick", or names such as
# BENCH="vortex step/total"; see doc/performance.md.
bench: $(BUILD)/.setup  ## rates, accuracy and figures in $(BUILD)/bench/results; BENCH=names
	cmake -S . -B $(BUILD) -DMPDEM_BENCH=ON $(CMAKE_OPTIONS)
	cmake --build $(BUILD) --parallel $(JOBS) --target bench_step accuracy law cpu_clock liggghts-mpdem
	/usr/bin/python3 tools/bench_report.py --build $(BUILD) $(BENCH)

clean:  ## removes $(BUILD)
	rm -rf $(BUILD)
