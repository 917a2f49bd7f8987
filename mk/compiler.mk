# SPDX-License-Identifier: Apache-2.0
# Compiler, flags and variant of the build.

ifeq ($(origin CC),default)
CC := gcc
endif
VARIANT := $(firstword $(if $(FUZZ),fuzz) $(if $(COVERAGE),coverage) $(if $(SANITIZE),sanitize) \
           $(if $(ANALYZE),analyze) $(if $(findstring clang,$(CC)),clang))
ifdef TSAN # Thread sanitizer; needs CC=clang.
VARIANT := thread
endif
AR := ar
ifdef S390X # Programs of a big-endian processor, for qemu-s390x.
override CC := s390x-linux-gnu-gcc
AR      := s390x-linux-gnu-ar
VARIANT := s390x
endif
ifdef BOARD # Programs on FreeRTOS, for a board without Linux that qemu-system-arm emulates.
BOARDS := mps2-an385 mps2-an500
$(if $(filter $(BOARD),$(BOARDS)),,$(error BOARD=$(BOARD): expected one of: $(BOARDS)))
override CC := arm-none-eabi-gcc
AR      := arm-none-eabi-ar
VARIANT := $(BOARD)
ifdef TARGET # Programs that fly on the board: with its capacities (capacities.h) and with compiled descriptors.
VARIANT := $(BOARD)/flight
endif
endif
B       := build$(addprefix /,$(VARIANT))

WARNINGS := -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wstrict-prototypes -Wvla -Werror
OPTIMIZE := -O2 -g
ifeq ($(shell uname -m)$(S390X)$(BOARD)$(findstring clang,$(CC)),x86_64)
# A step of a flight executes most of its code once, and this code is larger than the first-level cache of instructions.
# Without padding before loops and jumps the code is smaller.
OPTIMIZE += -fno-align-jumps -fno-align-labels -fno-align-loops
# The assembler places no jump across a boundary of 32 octets. Intel processors with the microcode correction of 2019
# run such jumps slowly, so the time of a function would depend on its address.
OPTIMIZE += -Wa,-mbranches-within-32B-boundaries
# A prefetch for writing (prefetchw) takes the cache line from the other processors; a processor without this
# instruction ignores it.
OPTIMIZE += -mprfchw
ifeq ($(VARIANT),)
# The simulator calls functions of shared libraries (ODE, the mathematical functions) without a jump through a table,
# which would need cache lines of its own. Flight code is smaller with the table.
$B/obj/sim/%.o: CFLAGS += -fno-plt
endif
endif
ifdef SANITIZE
# -g1 suffices: the reports of the sanitizers need only the names of functions and the line numbers.
OPTIMIZE := -O1 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=all -DRESOURCE_CHECKS
endif
ifdef TSAN
OPTIMIZE := -O1 -g1 -fno-omit-frame-pointer -fsanitize=thread -DTHREAD_CHECKS
endif
ifdef ANALYZE
OPTIMIZE := -O0 -fanalyzer
endif
ifdef COVERAGE
OPTIMIZE := -O0 --coverage -fprofile-update=atomic
endif
ifdef FUZZ # Fuzz targets; needs CC=clang.
OPTIMIZE := -O1 -g1 -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow \
            -fno-sanitize-recover=all
endif
CFLAGS   := -std=c99 $(WARNINGS) $(OPTIMIZE) -ffp-contract=off
CPPFLAGS := -D_POSIX_C_SOURCE=200809L -I. -Ibuild -isystem build/third_party/unity/src
ifdef S390X
CPPFLAGS += -isystem build/third_party/expat-s390x/include
CFLAGS   += -fexcess-precision=fast # Without it a float keeps the precision of a double until it is stored.
LDFLAGS  := -static -Lbuild/third_party/expat-s390x/lib
endif
ifdef BOARD
KERNEL := build/third_party/freertos
KERNEL_PORT := $(KERNEL)/portable/GCC/$(if $(filter %an385,$(BOARD)),ARM_CM3,ARM_CM7/r0p1)
PROCESSOR := -mthumb $(if $(filter %an385,$(BOARD)),-mcpu=cortex-m3,-mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16)
OPTIMIZE := -Os -g -ffunction-sections -fdata-sections
CPPFLAGS += -isystem build/third_party/expat/lib -isystem $(KERNEL)/include -isystem $(KERNEL_PORT) -Iosal/freertos
CPPFLAGS += -isystem build/third_party/littlefs $(addprefix -DLFS_NO_,MALLOC DEBUG WARN ERROR)
CFLAGS   := $(PROCESSOR) -std=c99 $(WARNINGS) $(OPTIMIZE) -ffp-contract=off
ifdef TARGET
CPPFLAGS += -include osal/freertos/capacities.h
endif
LDFLAGS  := -nostartfiles -T osal/freertos/mps2.ld -Wl,-u,port_reset -Wl,--gc-sections
endif

# Compiling most tests takes longer than running them, so the compiler optimizes the sources of tests less; the sources
# under test keep their flags. The linker gold of binutils needs half of the time of the default linker.
TEST_OBJECTS := $B/obj/test/unit/% $B/obj/test/contract/%
TEST_FLAGS   := $(if $(COVERAGE)$(ANALYZE),,$(if $(SANITIZE),-O0,-O1))
TEST_LINKER  := $(if $(BOARD)$(S390X),,-fuse-ld=gold)
