# SPDX-License-Identifier: Apache-2.0
# Fuzz targets, built by clang in a variant of their own. Each target links the common sources of test/fuzz.

define fuzz_rule
$B/target/$1: $(call objects,test/fuzz/fuzz_$1.c $(filter-out test/fuzz/fuzz_%,$(FUZZ_SOURCES)) \
                       test/support/scripted_bus.c) $(LIBRARIES)
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)$(CC) $(CFLAGS) -fsanitize=fuzzer -o $$@ $$(filter %.o,$$^) $$(call group,$$^) \
	    -Wl,--as-needed -lexpat $(LUA) $(NETTLE) -lode -llcm -lsqlite3 -lpthread -lm
endef
$(if $(FUZZ),$(foreach t,$(FUZZ_TARGETS),$(eval $(call fuzz_rule,$t))))
# `make test` runs the kept inputs without an engine, in the build with the sanitizers of gcc.
define kept_inputs_rule
$B/kept-inputs/$1: $(call objects,test/fuzz/fuzz_$1.c test/fuzz/kept/kept_inputs.c test/support/scripted_bus.c \
                            $(filter-out test/fuzz/fuzz_%,$(FUZZ_SOURCES))) $(LIBRARIES)
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)$(CC) $(CFLAGS) -o $$@ $$(filter %.o,$$^) $$(call group,$$^) \
	    -Wl,--as-needed -lexpat $(LUA) $(NETTLE) -lode -llcm -lsqlite3 -lpthread -lm
endef
$(if $(SANITIZE),$(foreach t,$(FUZZ_TARGETS),$(eval $(call kept_inputs_rule,$t))))
-include $(patsubst %.o,%.d,$(call objects,$(FUZZ_SOURCES) test/fuzz/kept/kept_inputs.c))
kept-inputs: $(foreach t,$(FUZZ_TARGETS),$B/kept-inputs/$t)
	@:

fuzzers: $(foreach t,$(call selected,$(FUZZ_TARGETS)),$B/target/$t)
	@:
BUILD_FUZZERS = $(MAKE) --no-print-directory -j$(JOBS) FUZZ=1 CC=clang fuzzers
# Seconds for each target; HOURS=2 gives 7200, and HOURS=0.5 gives 1800.
of_hours = $(or $(shell echo '$1' | awk '/^[0-9]+([.][0-9]+)?$$/ { print int($$1 * 3600) }'),\
           $(error HOURS=$1: expected a number of hours, such as 2 or 0.5))
SECONDS ?= $(if $(HOURS),$(call of_hours,$(HOURS)),20)
fuzz: build/setup/clang
	$(if $(strip $(call selected,$(FUZZ_TARGETS))),,\
	    $(error ONLY=$(ONLY): no fuzz target has this in its name; there are: $(FUZZ_TARGETS)))
	+@$(BUILD_FUZZERS)
	@$(PYTHON) test/fuzz/run_fuzz.py --seconds $(SECONDS) $(call selected,$(FUZZ_TARGETS))
# Create the corpus of a new target from test vectors and from the inputs that fuzzing has found; keep only
# the inputs that add coverage.
fuzz-corpus: build/setup/pytest build/setup/clang
	+@$(BUILD_FUZZERS)
	@$(VENV) test/fuzz/make_corpus.py $(call selected,$(FUZZ_TARGETS))

# The image program with random telecommands (test/fuzz/flight): random_flight.py starts it by a launcher in the same
# directory. A function named __wrap_x replaces the function x.
FLIGHT_FUZZ := $(wildcard test/fuzz/flight/*.c)
FLIGHT_WRAPS := $(patsubst __wrap_%,-Wl$(comma)--wrap=%,$(if $(FLIGHT_FUZZ),$(shell grep -oh '__wrap_[A-Za-z0-9_]*' \
                $(FLIGHT_FUZZ) | LC_ALL=C sort -u)))
$B/random-flight/image: $(call objects,launcher/image_main.c $(FLIGHT_FUZZ)) $(LIBRARIES)
	@mkdir -p $(@D)
	$(if $(V),,@echo "  link $@")
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(FLIGHT_WRAPS) -o $@ $(filter %.o,$^) $(call group,$^) -Wl,--as-needed \
	    -lexpat $(LUA) $(NETTLE) -lode -llcm -lsqlite3 -lpthread -lm
-include $(patsubst %.o,%.d,$(call objects,$(FLIGHT_FUZZ)))
.PHONY: random-flight
random-flight: $B/random-flight/image
	@:
