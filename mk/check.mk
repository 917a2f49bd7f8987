# SPDX-License-Identifier: Apache-2.0
# The format of the sources, and the checks of `make check` and `make check-full`.

C_FILES = $(shell find base osal pus fsw launcher sim test -name '*.[ch]')
PAGE_FILES = $(wildcard gse/page/src/*.js) gse/docs/search.js gse/yamcs/view.js
PRETTIER := build/station/node_modules/.bin/prettier --log-level warn
format: build/setup/check build/setup/station
	$(Q)clang-format -i $(C_FILES)
	$(Q)$(PRETTIER) --write $(PAGE_FILES)

.PHONY: compile-commands
compile-commands: $(GENERATED)
	@separator='['; for file in $(filter %.c,$(C_FILES)); do \
	    printf '%s\n{"directory": "%s", "file": "%s", "command": "%s -c %s"}' "$$separator" '$(CURDIR)' "$$file" \
	        '$(strip $(CC) $(CPPFLAGS) $(CFLAGS))' "$$file"; \
	    separator=','; done >build/compile_commands.json && printf '\n]\n' >>build/compile_commands.json

CHECKS := check-format check-gcc check-tidy check-misra check-complexity check-layers \
          check-worlds check-symbols check-text check-spelling check-links check-python check-page \
          check-proofs
.PHONY: $(CHECKS) check-clang check-analyzer check-misra-all check-tidy-all check-mutants check-fuzz mutants \
        flight-objects read-by-clang tidied coverage-tests
# Other checks read what check-gcc has built; while it builds, the packages of the other checks are installed. One job
# more than JOBS runs, because some wait for the network or for one long process. `make check test` installs what the
# tests need while the checks run.
FIRST_CHECKS := check-gcc build/setup/check
check: build/setup/unit
	+@failed=; \
	$(MAKE) --no-print-directory -k -j$(shell expr $(JOBS) + 1) $(FIRST_CHECKS) || failed=1; \
	$(MAKE) --no-print-directory -k -j$(shell expr $(JOBS) + 1) --output-sync=target \
	    $(if $(filter test,$(MAKECMDGOALS)),test-setup) $(filter-out $(FIRST_CHECKS),$(CHECKS)) || failed=1; \
	[ -z "$$failed" ] && echo 'check: all passed'
check-full: check build/setup/full
	+@$(MAKE) --no-print-directory -k coverage mcdc check-clang check-analyzer check-misra-all check-tidy-all \
	    check-all-proofs check-fuzz check-mutants check-tests check-board check-flights check-times \
	    && echo 'check-full: all passed'

check-format: build/setup/check
	@clang-format --dry-run -Werror $(C_FILES) && echo 'check: format is right'
check-gcc: build/setup/unit
	$(PARALLEL) CC=gcc programs benches && echo 'check: no warning from gcc'
# The warnings of clang for tests and measuring programs, in check-full; check-tidy shows those for all other sources.
# They need neither objects nor programs. A source that passed leaves a stamp file; a newer source, header or makefile
# makes it out of date.
check-clang: build/setup/check
	$(PARALLEL) -k read-by-clang && echo 'check: no warning from clang'
READ_BY_CLANG := $(sort $(TESTS) $(foreach t,$(TESTS),$(call fixtures,$t)) \
                   $(wildcard test/bench/*.c test/support/*.c))
read-by-clang: $(READ_BY_CLANG:%.c=build/lint/clang/%.passed)
	@:
build/lint/clang/%.passed: %.c Makefile mk/check.mk | $(GENERATED)
	@mkdir -p $(@D)
	$(Q)clang -std=c99 $(CPPFLAGS) $(WARNINGS) -fsyntax-only -MMD -MP -MT $@ -MF $(@:.passed=.d) $< && touch $@
-include $(READ_BY_CLANG:%.c=build/lint/clang/%.d)

# `make check` follows the paths of each function with the analyzer of clang (check-tidy), check-full also with that of
# gcc.
check-analyzer: build/setup/check
	$(PARALLEL) ANALYZE=1 flight-objects && echo 'check: the analyzer of gcc finds nothing'
flight-objects: $(call objects,$(filter-out sim/%,$(SOURCES)))
	@:

# A source that passed leaves a stamp file; a newer source, header or makefile makes it out of date. The analyzer of
# clang follows TIDY_STATES states of each function; check-full lets it follow as many as it does by default (225000),
# which takes many times as long.
TIDY        ?= tidy
TIDY_STATES := 2000
TIDY_BOUND   = $(if $(filter tidy,$(TIDY)),\
               $(addprefix --extra-arg=,-Xclang -analyzer-config -Xclang max-nodes=$(TIDY_STATES)))
check-tidy: build/setup/check
	$(PARALLEL) -k tidied && echo 'check: no warning from clang-tidy'
check-tidy-all: build/setup/check
	$(PARALLEL) -k TIDY=tidy-all tidied && echo 'check: clang-tidy finds nothing in any state'
tidied: $(patsubst %.c,build/lint/$(TIDY)/%.passed,$(SOURCES))
	@:
build/lint/$(TIDY)/%.passed: %.c .clang-tidy Makefile mk/check.mk | $(GENERATED)
	@mkdir -p $(@D) && gcc -std=c99 $(CPPFLAGS) -MM -MP -MT $@ -MF $(@:.passed=.d) $<
	@clang-tidy --quiet $(TIDY_BOUND) $< -- -std=c99 $(CPPFLAGS) $(WARNINGS) >$(@:.passed=.txt) 2>&1 && touch $@ || \
	    { sed -n 's|$(CURDIR)/||; / error: /p' $(@:.passed=.txt); exit 1; }
-include $(patsubst %.c,build/lint/$(TIDY)/%.d,$(SOURCES))

FLIGHT = $(filter-out sim/%,$(SOURCES))
check-misra: build/setup/check $(GENERATED)
	@$(PYTHON) test/lint/check_misra.py --jobs $(JOBS) $(FLIGHT)
check-misra-all: build/setup/check $(GENERATED)
	@$(PYTHON) test/lint/check_misra.py --all --jobs $(JOBS) $(FLIGHT)
check-complexity: build/setup/check
	@build/venv/bin/lizard -l c -l python -w -C 15 base osal pus fsw launcher sim gse && \
	    echo 'check: no function is too complex'
# The C tests without sanitizers, as the compiler optimizes them (`make test` runs them with sanitizers), and all tests
# with several tasks.
.PHONY: check-tests
check-tests: build/setup/unit build/setup/clang
	+@LONG=1 $(MAKE) --no-print-directory ONLY= check-tests-run
check-tests-run:
	$(PARALLEL) tests
	$(PARALLEL) TSAN=1 CC=clang thread-tests
	@$(PYTHON) test/support/run_tests.py --no-pytest --variant build --threads '$(THREAD_TESTS)' --jobs $(JOBS) $(TESTS)
# All portable tests on a board, including those that take long there.
.PHONY: check-board
check-board: build/setup/rtos build/setup/unit
	+@LONG=1 $(MAKE) --no-print-directory ONLY= board-tests-run
board-tests-run:
	$(PARALLEL) BOARD=$(TEST_BOARD) board-tests
	@$(PYTHON) test/support/run_tests.py --no-pytest --variant build/$(TEST_BOARD) --jobs $(JOBS) $(PORTABLE_TESTS)
.PHONY: check-flights
# The tests that are marked `long`: many deaths of processes and power cuts at random instants, 24 h of flight, and
# comparisons with other implementations of PUS.
check-flights: build/setup/vm build/setup/full build/setup/peer-spacepackets all remote-endian random-flight
	@LONG=1 SOAK_HOURS=24 $(VENV) -m pytest -q -p no:cacheprovider -m long -n $(JOBS) --dist loadfile \
	    test/mission test/hil test/conformance test/lint test/fuzz/test_random_flight.py && \
	    echo 'check: every flight ends as it should'
# Measure the wall-clock time in which hangs and deaths are detected and repaired; the machine must have no other
# load.
.PHONY: check-times
check-times: build/setup/test all
	@$(VENV) test/bench/run_bench.py --only bench_lives --out build/bench-lives.json --check && \
	    echo 'check: deaths and hangs are detected and repaired in time'
check-layers:
	@$(PYTHON) test/lint/check_layers.py
check-worlds:
	@$(PYTHON) test/lint/check_worlds.py
check-symbols: all
	@$(PYTHON) test/lint/check_symbols.py $(call objects,$(filter-out sim/% pus/tool/%,$(SOURCES)))
check-text:
	@$(PYTHON) test/lint/check_text.py
check-python: build/setup/check
	@build/venv/bin/ruff check --quiet --no-cache --select E9,F gse test && echo 'check: Python is well-formed'
# prettier reads .editorconfig for width and indentation; .prettierrc keeps search.js in ECMAScript 5.
check-page: build/setup/station
	@$(PRETTIER) --check $(PAGE_FILES) && echo 'check: format of the JavaScript is right'
check-spelling: build/setup/check
	@build/venv/bin/codespell --ignore-words test/lint/spelling.txt --skip '$(subst $() ,$(comma),$(UNSPELLED))' && \
	    echo 'check: no known misspelling'
UNSPELLED := ./build ./runs ./.git ./.ruff_cache ./.pytest_cache ./test/fuzz/corpus ./test/lint/words.txt *.pyc
check-links:
	@$(PYTHON) test/lint/check_links.py
check-mutants:
	+@$(MAKE) --no-print-directory mutants ONLY= COUNT=300 FLY=1 CHECK=1
check-fuzz: build/setup/check
	+@$(MAKE) --no-print-directory fuzz $(if $(HOURS),,SECONDS=300)
