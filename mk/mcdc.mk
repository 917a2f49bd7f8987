# SPDX-License-Identifier: Apache-2.0
# Modified condition/decision coverage (MC/DC) of the sources in test/lint/mcdc.txt by their unit tests. clang 19
# compiles only these sources; all other objects are those of the plain build.

MCDC_SOURCES := $(shell sed -n 's/^\([a-z][^ ]*\.c\)$$/\1/p' test/lint/mcdc.txt)
MCDC_DIRS    := $(sort $(patsubst %/,%,$(dir $(MCDC_SOURCES))))
MCDC_TESTS   := $(filter-out %_stress.c %_endurance.c,$(filter $(MCDC_DIRS:%=test/unit/%/%),$(TESTS)))
mcdc_objects  = $(patsubst %.c,build/mcdc/obj/%.o,$1)
mcdc_library  = build/mcdc/$(call library,$1)

build/mcdc/obj/%.o: %.c | build/setup/mcdc $(GENERATED)
	@mkdir -p $(@D)
	$(if $(V),,@echo "  clang-19 mcdc $<")
	$(Q)clang-19 -std=c99 $(CPPFLAGS) -O0 -g -ffp-contract=off -fprofile-instr-generate -fcoverage-mapping \
	    -fcoverage-mcdc -MMD -MP -c $< -o $@
-include $(patsubst %.o,%.d,$(call mcdc_objects,$(MCDC_SOURCES)))

# The libraries that contain these sources, with instrumented objects instead of the plain ones.
define mcdc_library_rule
$(call mcdc_library,$1): $(call mcdc_objects,$(filter $(wildcard $1/*.c),$(MCDC_SOURCES))) \
    $(call objects,$(filter $(wildcard $1/*.c),$(filter-out %_main.c $(MCDC_SOURCES),$(SOURCES)))) test/lint/mcdc.txt
	@mkdir -p $$(@D) && rm -f $$@
	$(Q)$(AR) rcs $$@ $$(filter %.o,$$^)
endef
$(foreach d,$(MCDC_DIRS),$(eval $(call mcdc_library_rule,$d)))
MCDC_PLAIN   := $(foreach d,$(MCDC_DIRS),$(call library,$d))
mcdc_of       = $(foreach a,$1,$(if $(filter $a,$(MCDC_PLAIN)),build/mcdc/$a,$a))

define mcdc_rule
$(patsubst %.c,build/mcdc/%,$1): $(call objects,$1 $(call fixtures,$1)) $(call caught,$1) \
    $(call mcdc_of,$(call layer_libraries,$(call mirrored,$1))) $(SUPPORT_A)
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)clang-19 $(LDFLAGS) -fprofile-instr-generate $(call wraps_of,$1) $(counted) -o $$@ $$(filter %.o,$$^) \
	    $$(call group,$$^) -Wl,--as-needed $(TEST_EXTERNALS)
endef
$(foreach t,$(MCDC_TESTS),$(eval $(call mcdc_rule,$t)))

.PHONY: mcdc mcdc-tests
mcdc-tests: $(patsubst %.c,build/mcdc/%,$(MCDC_TESTS))
	@:
mcdc: build/setup/mcdc
	$(PARALLEL) ONLY= mcdc-tests
	@$(PYTHON) test/lint/check_mcdc.py --jobs $(JOBS) $(MCDC_TESTS)
