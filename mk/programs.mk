# SPDX-License-Identifier: Apache-2.0
# The rules that link programs.

# A flight program links no library of the simulator; the simulator links only base and the operating system
# layer of the flight software. The image program links flight software and simulator.
SIM_LIBRARIES    := $(foreach d,$(filter sim/% osal/% base,$(DIRS)),$(call library,$d))
FLIGHT_LIBRARIES := $(foreach d,$(filter-out sim/%,$(DIRS)),$(call library,$d))

LUA   := $(if $(S390X)$(BOARD),,-llua5.4)
NETTLE := $(if $(S390X)$(BOARD),,-lnettle) # No program for s390x or a board protects frames.
group = -Wl,--start-group $(filter %.a,$1) -Wl,--end-group
program_name = $B/bin/$(subst _,-,$(patsubst %_main.c,%,$(notdir $1)))
libraries_of = $(if $(findstring image,$1)$(findstring relay,$1),$(LIBRARIES),\
               $(if $(filter sim/%,$1),$(SIM_LIBRARIES),$(FLIGHT_LIBRARIES)))
externals_of = $(if $(findstring image,$1)$(filter sim/%,$1),-lode -llcm) $(if $(findstring sqlite,$1),-lsqlite3) \
               -lexpat $(if $(filter sim/%,$1),,$(LUA) $(NETTLE)) -lpthread -lm

define program_rule
$(call program_name,$1): $(call objects,$1) $(call libraries_of,$1) $(FOREIGN_A)
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) -o $$@ $$(filter %.o,$$^) $$(call group,$$^) -Wl,--as-needed $(call externals_of,$1)
endef
ifndef BOARD
$(foreach m,$(MAINS),$(eval $(call program_rule,$m)))
endif
PROGRAMS := $(foreach m,$(MAINS),$(call program_name,$m))
# Programs that a proxy can replace: all components except supervisor and communication, whose shared memory
# other components access.
REMOTE_NAMES := $(filter-out supervisor communication,$(patsubst %_program.c,%,\
                $(notdir $(wildcard fsw/programs/*_program.c))))
REMOTE_ENDIAN_PROGRAMS := $(foreach p,$(REMOTE_NAMES),$B/bin/$(subst _,-,$p))
# Programs for a board without files: `descriptor-compiler`, which runs on this machine, writes their main function
# and their descriptors as C sources from the descriptors of the missions: of all missions, or with MISSION=<name> of
# this one alone, for the programs that it has.
ONE_MISSION  := $(if $(TARGET),$(if $(filter command%,$(origin MISSION)),$(MISSION)))
MISSION_FILE := $(filter descriptors/missions/$(ONE_MISSION).xml,$(MISSIONS))
ifneq ($(ONE_MISSION),)
$(if $(MISSION_FILE),,$(error MISSION=$(ONE_MISSION): expected one of: $(basename $(notdir $(MISSIONS)))))
endif
EXECUTABLES  := $(if $(MISSION_FILE),$(shell grep -o 'executable="[^"]*"' $(MISSION_FILE) | cut -d '"' -f 2 | tr - _))
TARGET_NAMES := $(if $(MISSION_FILE),$(filter $(EXECUTABLES),$(REMOTE_NAMES)),$(REMOTE_NAMES))
$(if $(TARGET_NAMES),,$(error MISSION=$(ONE_MISSION): its subsystems have no program for a board))
COMPILED     := build/generated/compiled$(addprefix /,$(ONE_MISSION))
SIZED        := $B$(addprefix /missions/,$(ONE_MISSION))
COMPILED_SOURCES  := $(foreach p,$(TARGET_NAMES),$(addprefix $(COMPILED)/$p_,main.c descriptors.c capacities.h))
$(COMPILED_SOURCES) &: descriptors/missions $(shell find descriptors -name '*.xml' -o -name '*.eds') \
        $(wildcard fsw/framework/descriptor/*.[ch] launcher/descriptor_*.[ch] fsw/programs/*_program.c) \
        $(if $(VARIANT),,build/bin/descriptor-compiler)
	$(if $(VARIANT),+@$(MAKE) --no-print-directory CC=gcc BOARD= TARGET= S390X= SANITIZE= TSAN= COVERAGE= FUZZ= ANALYZE= \
	    build/bin/descriptor-compiler)
	@mkdir -p $(COMPILED)
	@for name in $(TARGET_NAMES); do build/bin/descriptor-compiler $(COMPILED) $$name $$(echo $$name | tr _ -) \
	    $(or $(MISSION_FILE),$(MISSIONS)) || exit 1; done
# The storage of a program has the sizes that its descriptors need: sources with such storage are compiled for each
# program, after its header of capacities.
SIZED_DIRS    := $(filter fsw/programs fsw/drives fsw/equipment fsw/framework/subsystem fsw/subsystems/%,$(DIRS))
other_programs = $(filter-out $1,$(REMOTE_NAMES))
sized_dirs     = $(filter-out $(patsubst %,fsw/subsystems/%,$(call other_programs,$1)),$(SIZED_DIRS))
sized_objects  = $(patsubst %.c,$(SIZED)/$1/obj/%.o,\
                 $(filter-out $(patsubst %,fsw/programs/%_program.c,$(call other_programs,$1)),\
                 $(filter $(patsubst %,%/%.c,$(call sized_dirs,$1)),$(SOURCES))))
sized_library  = $(SIZED)/$1/lib/lib$(subst /,_,$2).a
target_parts   = $(patsubst %,$(SIZED)/$1/obj/$(COMPILED)/$1_%.o,main descriptors) build/$(BOARD)/mission \
                 $(foreach d,$(call sized_dirs,$1),$(call sized_library,$1,$d)) \
                 $(foreach d,$(filter-out sim/% $(SIZED_DIRS),$(DIRS)),$(call library,$d)) $(FOREIGN_A)
define sized_library_rule
$(call sized_library,$1,$2): $(filter $(SIZED)/$1/obj/$2/%,$(call sized_objects,$1)) $2
	@mkdir -p $$(@D) && rm -f $$@
	$(Q)$(AR) rcs $$@ $$(filter %.o,$$^)
endef
define target_rule
$(SIZED)/$1/obj/%.o: %.c $B/flags $(COMPILED)/$1_capacities.h | build/setup/build
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  $(CC) $(VARIANT)/$1 $$<")
	$(Q)$(CC) -include $(COMPILED)/$1_capacities.h $(CPPFLAGS) $(CFLAGS) -MMD -MP -c $$< -o $$@
$(foreach p,main descriptors,$(eval $(SIZED)/$1/obj/$(COMPILED)/$1_$p.o: $(COMPILED)/$1_$p.c))
-include $(patsubst %.o,%.d,$(call sized_objects,$1)) $(patsubst %,$(SIZED)/$1/obj/$(COMPILED)/$1_%.d,main descriptors)
build/$(BOARD)/bin/$(subst _,-,$1): $(call target_parts,$1) osal/freertos/mps2.ld
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) -Wl,-Map,$(SIZED)/$1/$1.map -o $$@ $$(filter %.o,$$^) $$(call group,$$^) -lm -lc -lgcc
endef
ifdef TARGET
# This file changes when MISSION changes. Every program depends on it, so the programs are always those of the missions
# that were requested last.
build/$(BOARD)/mission: force
	@mkdir -p $(@D) && echo '$(ONE_MISSION)' | cmp -s - $@ || echo '$(ONE_MISSION)' >$@
$(foreach p,$(TARGET_NAMES),$(foreach d,$(call sized_dirs,$p),$(eval $(call sized_library_rule,$p,$d))))
$(foreach p,$(TARGET_NAMES),$(eval $(call target_rule,$p)))
endif
target-programs: $(foreach p,$(or $(filter $(ONLY),$(TARGET_NAMES)),$(TARGET_NAMES)),build/$(BOARD)/bin/$(subst _,-,$p))
	@:

all: build/setup/build
	$(PARALLEL) programs
programs: $(LIBRARIES) $(PROGRAMS)
	@:
remote-endian: build/setup/s390x
	$(PARALLEL) S390X=1 remote-endian-programs
# Programs on FreeRTOS: `make rtos BOARD=mps2-an500`. Those of `make sim-run RTOS=...` contain all missions.
rtos: rtos-$(or $(BOARD),mps2-an500)
rtos-%: build/setup/rtos
	$(PARALLEL) BOARD=$* TARGET=1 MISSION=$(if $(filter rtos rtos-%,$(MAKECMDGOALS)),$(MISSION)) target-programs
