# SPDX-License-Identifier: Apache-2.0
# Libraries: one for each directory.

SOURCES  := $(shell find base osal pus fsw launcher sim -name '*.c' 2>/dev/null | LC_ALL=C sort)
ifneq ($(S390X)$(BOARD),) # Programs of subsystems alone: without Lua, Nettle and all that only other programs need.
SOURCES  := $(filter-out fsw/procedures/% fsw/supervisor/% fsw/framework/sdls/% fsw/programs/ground_key.c \
            fsw/programs/supervisor_% fsw/programs/communication_% fsw/subsystems/communication/% \
            pus/tool/% launcher/% sim/%,$(SOURCES))
endif
ifdef BOARD
SOURCES  := $(filter-out osal/posix/%,$(SOURCES))
# Programs for a board contain their descriptors, and the device classes that these name, as compiled tables. They need
# no code that reads descriptors, only the code that uses them.
ifdef TARGET
MODELS   := $(addprefix fsw/framework/descriptor/,subsystem_descriptor.c mission_descriptor.c mission_lookup.c \
            descriptor_refusal.c)
SOURCES  := $(filter-out $(filter-out $(MODELS),$(filter fsw/framework/descriptor/%,$(SOURCES))) fsw/framework/xml/% \
            fsw/canopen/device_classes.c fsw/programs/descriptor_files.c \
            fsw/programs/executive_files.c %_main.c,$(SOURCES))
endif
else
SOURCES  := $(filter-out osal/freertos/%,$(SOURCES))
endif
TESTS    := $(shell find test/unit test/contract -name 'test_*.c' 2>/dev/null | LC_ALL=C sort)
# Tests of the port to FreeRTOS run only on a board.
BOARD_ONLY_TESTS := $(filter test/unit/osal/freertos/%,$(TESTS))
TESTS    := $(filter-out $(if $(BOARD),,$(BOARD_ONLY_TESTS)),$(TESTS))
BENCHES  := $(wildcard test/bench/bench_*.c)
FUZZ_SOURCES := $(wildcard test/fuzz/*.c)
FUZZ_TARGETS := $(patsubst test/fuzz/fuzz_%.c,%,$(filter test/fuzz/fuzz_%,$(FUZZ_SOURCES)))
MAINS    := $(filter %_main.c,$(SOURCES))
DIRS     := $(sort $(patsubst %/,%,$(dir $(filter-out %_main.c,$(SOURCES)))))
library   = $B/lib/lib$(subst /,_,$1).a
objects   = $(patsubst %.c,$B/obj/%.o,$1)
LIBRARIES := $(foreach d,$(DIRS),$(call library,$d))

define library_rule
$(call library,$1): $(call objects,$(filter $(wildcard $1/*.c),$(filter-out %_main.c,$(SOURCES)))) $1
	@mkdir -p $$(@D) && rm -f $$@
	$(Q)$(AR) rcs $$@ $$(filter %.o,$$^)
endef
$(foreach d,$(DIRS),$(eval $(call library_rule,$d)))

ifdef BOARD # The kernel, the file system and the XML parser, compiled from their sources.
FOREIGN_SOURCES := $(addprefix $(KERNEL)/,tasks.c queue.c list.c) $(KERNEL_PORT)/port.c \
                   $(addprefix build/third_party/littlefs/,lfs.c lfs_util.c) \
                   $(if $(TARGET),,$(addprefix build/third_party/expat/lib/,xmlparse.c xmlrole.c xmltok.c))
FOREIGN_A := $B/lib/libforeign.a
$B/obj/build/third_party/%.o: build/third_party/%.c $B/flags osal/freertos/FreeRTOSConfig.h osal/freertos/board.h
	@mkdir -p $(@D)
	$(if $(V),,@echo "  $(CC) $(VARIANT) $<")
	$(Q)$(CC) $(CPPFLAGS) $(PROCESSOR) -std=c99 $(OPTIMIZE) -w -c $< -o $@
# c_library.c defines functions of the C library; -fno-builtin keeps the compiler from using its own versions of them.
$B/obj/osal/freertos/c_library.o: CFLAGS += -fno-builtin
$(FOREIGN_A): $(call objects,$(FOREIGN_SOURCES))
	@mkdir -p $(@D) && rm -f $@
	$(Q)$(AR) rcs $@ $^
$(call objects,$(FOREIGN_SOURCES) $(SOURCES)): | build/setup/rtos
$(FOREIGN_SOURCES): | build/setup/rtos ;
endif
