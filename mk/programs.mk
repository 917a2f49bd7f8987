# SPDX-License-Identifier: Apache-2.0
# Programs.

# A flight program links no library of the simulator; the simulator links only base and the operating system
# layer of the flight side. The image program links both sides.
SIM_LIBRARIES    := $(foreach d,$(filter sim/% osal/% base,$(DIRS)),$(call library,$d))
FLIGHT_LIBRARIES := $(foreach d,$(filter-out sim/%,$(DIRS)),$(call library,$d))

LUA   := $(if $(S390X)$(BOARD),,-llua5.4)
NETTLE := $(if $(S390X)$(BOARD),,-lnettle) # No program for another processor protects frames.
group = -Wl,--start-group $(filter %.a,$1) -Wl,--end-group
program_name = $B/bin/$(subst _,-,$(patsubst %_main.c,%,$(notdir $1)))
libraries_of = $(if $(findstring image,$1)$(findstring relay,$1),$(LIBRARIES),\
               $(if $(filter sim/%,$1),$(SIM_LIBRARIES),$(FLIGHT_LIBRARIES)))
externals_of = $(if $(findstring image,$1)$(filter sim/%,$1),-lode -llcm) $(if $(findstring sqlite,$1),-lsqlite3) \
               $(if $(BOARD),-lm -lc -lgcc,-lexpat $(if $(filter sim/%,$1),,$(LUA) $(NETTLE)) -lpthread -lm)

define program_rule
$(call program_name,$1): $(call objects,$1) $(call libraries_of,$1) $(FOREIGN_A) $(if $(BOARD),osal/freertos/mps2.ld)
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) -o $$@ $$(filter %.o,$$^) $$(call group,$$^) -Wl,--as-needed $(call externals_of,$1)
endef
$(foreach m,$(MAINS),$(eval $(call program_rule,$m)))
PROGRAMS := $(foreach m,$(MAINS),$(call program_name,$m))
# Programs that a proxy can replace: all components except supervisor and communication, whose shared memory
# other components access.
REMOTE_ENDIAN_PROGRAMS := $(foreach p,$(filter-out supervisor communication,$(patsubst %_program.c,%,\
                    $(notdir $(wildcard fsw/programs/*_program.c)))),$B/bin/$(subst _,-,$p))

all: build/setup/build
	$(PARALLEL) programs
programs: $(LIBRARIES) $(PROGRAMS)
	@:
remote-endian: build/setup/s390x
	$(PARALLEL) S390X=1 remote-endian-programs
# Programs on FreeRTOS: `make rtos BOARD=mps2-an500`.
rtos: rtos-$(or $(BOARD),mps2-an500)
rtos-%: build/setup/rtos
	$(PARALLEL) BOARD=$* remote-endian-programs
