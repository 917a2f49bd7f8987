# SPDX-License-Identifier: Apache-2.0
# Files generated from descriptors and catalogue; the rules that compile sources to objects.

GENERATOR := $(wildcard gse/generator/*.py gse/generator/*.lua)
GENERATED := build/generated/stamp build/generated/programs.h
MISSIONS := $(sort $(wildcard descriptors/missions/*.xml))

build/generated/stamp: $(GENERATOR) $(wildcard descriptors/*.txt pus/catalogue/*.txt pus/catalogue/private/*.txt) \
                       pus/core/tailoring.h pus/st18/st18_procedures.h fsw/canopen/network.h base/status.h \
                       $(shell find descriptors -name '*.xml' -o -name '*.xsd' -o -name '*.eds' 2>/dev/null)
	$(Q)$(PYTHON) gse/generator/generate.py --mission $(MISSIONS) --out build/generated
	@touch $@
build/generated/%.h: build/generated/stamp ;
# Components of the image: one for each fsw/programs/<name>_program.c.
build/generated/programs.h: $(wildcard fsw/programs/*_program.c) fsw/programs
	@mkdir -p $(@D)
	@{ echo '/* Components in fsw/programs: COMPONENT(name in C, executable). Made by the Makefile. */'; \
	   for name in $(patsubst %_program.c,%,$(notdir $(sort $(wildcard fsw/programs/*_program.c)))); do \
	       echo "COMPONENT($$name, \"$$(echo "$$name" | tr _ -)\")"; done; } >$@.part
	@cmp -s $@.part $@ && rm $@.part || mv $@.part $@
# Directories whose sources include generated files, and the directories of their tests: the generator runs before
# the compiler.
SEES_GENERATED := $(foreach p,pus fsw/canopen fsw/drives fsw/equipment fsw/supervisor fsw/subsystems fsw/programs \
                  launcher,$p/% test/unit/$p/%) \
                  test/bench/% test/fuzz/%
$(call objects,$(filter $(SEES_GENERATED),$(SOURCES) $(TESTS) $(BENCHES) $(FUZZ_SOURCES))): | $(GENERATED)

.PHONY: generated
generated: $(GENERATED)
	@:

# This file changes when the flags or the compiler change. Every object depends on it, so all are built again.
$B/flags: force
	@mkdir -p $(@D) && echo '$(CC) $(CPPFLAGS) $(CFLAGS) $(TEST_FLAGS)' | cmp -s - $@ || \
	    echo '$(CC) $(CPPFLAGS) $(CFLAGS) $(TEST_FLAGS)' >$@
force:

$B/obj/%.o: %.c $B/flags | build/setup/build
	@mkdir -p $(@D)
	$(if $(V),,@echo "  $(CC) $(VARIANT:%=% )$<")
	$(Q)$(CC) $(CPPFLAGS) $(CFLAGS) $(if $(filter $(TEST_OBJECTS),$@),$(TEST_FLAGS)) -MMD -MP -c $< -o $@

-include $(patsubst %.o,%.d,$(call objects,$(SOURCES)))
