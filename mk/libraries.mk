# SPDX-License-Identifier: Apache-2.0
# Libraries: one for each folder.

SOURCES  := $(shell find base osal pus fsw launcher sim -name '*.c' 2>/dev/null | LC_ALL=C sort)
ifdef S390X # Lua runs procedures in the supervisor, which is never a remote-endian program.
SOURCES  := $(filter-out fsw/procedures/%,$(SOURCES))
endif
TESTS    := $(shell find test/unit test/contract -name 'test_*.c' 2>/dev/null | LC_ALL=C sort)
BENCHES  := $(wildcard test/bench/bench_*.c)
FUZZ_SOURCES := $(wildcard test/fuzz/*.c)
FUZZ_TARGETS := $(patsubst test/fuzz/fuzz_%.c,%,$(filter test/fuzz/fuzz_%,$(FUZZ_SOURCES)))
MAINS    := $(filter %_main.c,$(SOURCES))
DIRS     := $(sort $(patsubst %/,%,$(dir $(filter-out %_main.c,$(SOURCES)))))
library   = $B/lib/lib$(subst /,_,$1).a
objects   = $(patsubst %.c,$B/obj/%.o,$1)
LIBRARIES := $(foreach d,$(DIRS),$(call library,$d))

define library_rule
$(call library,$1): $(call objects,$(filter-out %_main.c,$(wildcard $1/*.c))) $1
	@mkdir -p $$(@D) && rm -f $$@
	$(Q)$(AR) rcs $$@ $$(filter %.o,$$^)
endef
$(foreach d,$(DIRS),$(eval $(call library_rule,$d)))
