# SPDX-License-Identifier: Apache-2.0
# The one entry to the project. All output goes under build/ and runs/.
#
# Every folder with C sources becomes one static library; every *_main.c becomes a program in build/bin/. Lines that
# begin with two number signs are what `make help` prints.

## hirosco: flight software, simulator and ground segment
##
##   make [all]      build all programs into build/bin/          SANITIZE=1  TSAN=1  CC=gcc|clang  V=1  JOBS=2
##   make sim-run    fly a mission, leave its report in runs/    MISSION=rokviss  SCENARIO=telepresence|none  SEED=1
##                                                               FORM=processes|image  TIME=stepped|real|free  BUS=shm|vcan|can
##                                                               TRANSPORT=udp|tipc  LINKS=shm|udp|tipc  NODES=1|2
##                                                               PORT=  TOOLS=  OUT=runs/...  STORAGE=<folder that stays>
##                                                               KEY=<file>: take telecommands only that it protects
##                                                               BUS=can: ROBOT_IF=can0  JOYSTICK_IF=  SIM_ROBOT_IF=
##                                                               FOREIGN=<subsystem>: its program big-endian, emulated
##   make test       build and run every test, end with a summary line      ONLY=<part of a test's path>
##   make test-hil   hardware in the loop only: on this kernel if it has vcan, vxcan and TIPC, else in the micro-VM
##                   ONLY=<part of a test's path>  PLACE=vm|kernel
##   make check      format, warnings and analysers of gcc and clang, MISRA of what changed, complexity, layers,
##                   symbols, words, lengths, spelling, links, Python, coverage; what passed once is not looked at again
##   make check-full check, MISRA of the whole flight side, five minutes of each fuzz target, 300 mutants, many deaths in flight
##   make coverage   branches the C unit tests take, compared with test/lint/coverage.txt: build/coverage/index.html
##                   ONLY=<part of a test's path>  UPDATE=1 raises the marks
##   make mutants    change the flight sources in COUNT places drawn by SEED, one at a time; which do the C tests notice?
##                   ONLY=<part of a source's path>  COUNT=20  SEED=1  CHECK=1 fails below 95 % (90 % in a folder)
##   make pus-coverage   fly the conformance suite of the packet services and write docs/pus-coverage.md
##   make fuzz       run every fuzz target in turn on its kept corpus          ONLY=<part of a name>  SECONDS=20
##   make vm         a shell in a micro-VM with vcan and TIPC over this tree; what is written there is forgotten, but
##                   for build/vm/out            CMD='one command instead'  SECONDS=300  CANS=0  MEMORY=1024  OUT=folder
##   make bench      measure, print a table, write build/bench.json         ONLY=<part of a name>  CHECK=1
##   make new-subsystem NAME=gripper    begin a subsystem that builds and flies     APID=  MISSION=<one that is there>
##   make foreign    the subsystems' programs for the big-endian s390x: build/s390x/bin/
##   make yamcs      run Yamcs at a mission that flies on this machine     MISSION=  PORT=<its ground port>  HTTP=8090
##   make docs       API reference, architecture and interface control document: build/docs/index.html
##   make gse        set up the ground segment's command line and show how to call it
##   make compile-commands   write build/compile_commands.json, which clangd and other tools read
##   make format     clang-format all C sources in place
##   make doctor     show what is there, what is missing, and the next step
##   make setup      install all that any target needs (each target installs its own needs by itself)
##   make clean      remove build/ except the Python environment and what was fetched; ALL=1 removes that too

SHELL         := /bin/sh
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules
JOBS ?= 2
OPTIONS := ALL ANALYZE APID BUS CANS CC CHECK CMD COUNT COVERAGE FOREIGN FORM FUZZ HTTP JOBS JOYSTICK_IF KEY LINKS MEMORY MISSION NAME NODES \
           ONLY OUT PLACE PORT ROBOT_IF S390X SANITIZE SCENARIO SECONDS SEED SIM_JOYSTICK_IF SIM_ROBOT_IF STORAGE TIME TOOLS \
           TRANSPORT TSAN UPDATE V
ifeq ($(MAKELEVEL),0)
$(foreach v,$(filter-out $(OPTIONS),$(.VARIABLES)),$(if $(findstring command line,$(origin $v)),\
    $(error $v=$($v): there is no such option; there are: $(OPTIONS): see make help)))
$(if $(filter-out vm kernel,$(PLACE)),$(error PLACE=$(PLACE): expected vm or kernel))
.NOTPARALLEL: # `make check test` does one after the other; the work inside each runs in parallel.
endif
PARALLEL := +$(if $(V),,@)$(MAKE) --no-print-directory -j$(JOBS)
Q        := $(if $(V),,@)
PYTHON   := /usr/bin/python3
export PYTHONPYCACHEPREFIX := $(CURDIR)/build/pycache
unexport PYTHONDONTWRITEBYTECODE # Else each start of Python compiles its own library anew.
VENV     := build/venv/bin/python

# --- compiler and variant --------------------------------------------------------------------------------------
ifeq ($(origin CC),default)
CC := gcc
endif
VARIANT := $(if $(FUZZ),fuzz,$(if $(COVERAGE),coverage,$(if $(SANITIZE),sanitize,$(if $(ANALYZE),analyze,$(if $(findstring clang,$(CC)),clang)))))
ifdef TSAN # With CC=clang.
VARIANT := thread
endif
AR := ar
ifdef S390X # Programs of a big-endian processor, for qemu-s390x.
override CC := s390x-linux-gnu-gcc
AR      := s390x-linux-gnu-ar
VARIANT := s390x
endif
B       := build$(addprefix /,$(VARIANT))

WARNINGS := -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wstrict-prototypes -Wvla -Werror
OPTIMIZE := -O2 -g
ifeq ($(shell uname -m)$(S390X)$(findstring clang,$(CC)),x86_64)
# No jump across 32 octets: the processors that had to be corrected for these (Intel, 2019) run them slowly, and the time
# of a function would depend on what stands before it.
OPTIMIZE += -Wa,-mbranches-within-32B-boundaries
# A prefetch to write takes the line from other processors (one that does not know it does nothing).
OPTIMIZE += -mprfchw
endif
ifdef SANITIZE
OPTIMIZE := -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=all -DRESOURCE_CHECKS
endif
ifdef TSAN
OPTIMIZE := -O1 -g -fno-omit-frame-pointer -fsanitize=thread -DTHREAD_CHECKS
endif
ifdef ANALYZE
OPTIMIZE := -O0 -g -fanalyzer
endif
ifdef COVERAGE
OPTIMIZE := -O0 -g --coverage -fprofile-update=atomic
endif
ifdef FUZZ # With CC=clang.
OPTIMIZE := -O1 -g -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow \
            -fno-sanitize-recover=all
endif
CFLAGS   := -std=c99 $(WARNINGS) $(OPTIMIZE) -ffp-contract=off
CPPFLAGS := -D_POSIX_C_SOURCE=200809L -I. -Ibuild -isystem build/third_party/unity/src
ifdef S390X
CPPFLAGS += -isystem build/third_party/expat-s390x/include
CFLAGS   += -fexcess-precision=fast # Else a float is a double there as long as it is not stored.
LDFLAGS  := -static -Lbuild/third_party/expat-s390x/lib
endif

# --- libraries: one per folder -----------------------------------------------------------------------------------
SOURCES  := $(shell find base osal pus fsw launcher sim -name '*.c' 2>/dev/null | LC_ALL=C sort)
ifdef S390X # Procedures run in the supervisor, which is never a remote-endian program: no Lua for that processor.
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

# --- generated from descriptors and catalogue ------------------------------------------------------------------------------
GENERATOR := $(wildcard gse/generator/*.py)
GENERATED := build/generated/stamp build/generated/programs.h
MISSIONS := $(sort $(wildcard descriptors/missions/*.xml))

build/generated/stamp: $(GENERATOR) $(wildcard pus/catalogue/*.txt) pus/core/tailoring.h \
                       $(shell find descriptors -name '*.xml' -o -name '*.xsd' -o -name '*.eds' 2>/dev/null)
	$(Q)$(PYTHON) gse/generator/generate.py --mission $(MISSIONS) --out build/generated
	@touch $@
build/generated/%.h: build/generated/stamp ;
# What the image holds: one component for each fsw/programs/<name>_program.c.
build/generated/programs.h: $(wildcard fsw/programs/*_program.c) fsw/programs
	@mkdir -p $(@D)
	@{ echo '/* Components in fsw/programs: COMPONENT(name in C, executable). Made by the Makefile. */'; \
	   for name in $(patsubst %_program.c,%,$(notdir $(sort $(wildcard fsw/programs/*_program.c)))); do \
	       echo "COMPONENT($$name, \"$$(echo "$$name" | tr _ -)\")"; done; } >$@.part
	@cmp -s $@.part $@ && rm $@.part || mv $@.part $@
# The folders whose layer sees them, with their tests.
SEES_GENERATED := $(foreach p,pus fsw/supervisor fsw/subsystems fsw/programs launcher,$p/% test/unit/$p/%) test/bench/% test/fuzz/%
$(call objects,$(filter $(SEES_GENERATED),$(SOURCES) $(TESTS) $(BENCHES) $(FUZZ_SOURCES))): | $(GENERATED)

# Other flags, or another compiler, build anew.
$B/flags: force
	@mkdir -p $(@D) && echo '$(CC) $(CPPFLAGS) $(CFLAGS)' | cmp -s - $@ || echo '$(CC) $(CPPFLAGS) $(CFLAGS)' >$@
force:

$B/obj/%.o: %.c $B/flags | build/setup/run
	@mkdir -p $(@D)
	$(if $(V),,@echo "  $(CC) $(VARIANT:%=% )$<")
	$(Q)$(CC) $(CPPFLAGS) $(CFLAGS) -MMD -MP -c $< -o $@

-include $(patsubst %.o,%.d,$(call objects,$(SOURCES)))

# --- programs ----------------------------------------------------------------------------------------------------
# A flight program knows nothing of the simulator, and the simulator only the operating system layer and the status
# type of the flight side; the image program holds both.
SIM_LIBRARIES    := $(foreach d,$(filter sim/% osal/% base,$(DIRS)),$(call library,$d))
FLIGHT_LIBRARIES := $(foreach d,$(filter-out sim/%,$(DIRS)),$(call library,$d))

LUA   := $(if $(S390X),,-llua5.4)
NETTLE := $(if $(S390X),,-lnettle) # No program of another byte order frames packets.
group = -Wl,--start-group $(filter %.a,$1) -Wl,--end-group
program_name = $B/bin/$(subst _,-,$(patsubst %_main.c,%,$(notdir $1)))
libraries_of = $(if $(findstring image,$1),$(LIBRARIES),$(if $(filter sim/%,$1),$(SIM_LIBRARIES),$(FLIGHT_LIBRARIES)))
externals_of = $(if $(findstring image,$1)$(filter sim/%,$1),-lode -llcm) $(if $(findstring sqlite,$1),-lsqlite3) \
               $(if $(filter sim/%,$1),,-lexpat $(LUA) $(NETTLE)) -lpthread -lm

define program_rule
$(call program_name,$1): $(call objects,$1) $(call libraries_of,$1)
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) -o $$@ $$(filter %.o,$$^) $$(call group,$$^) -Wl,--as-needed $(call externals_of,$1)
endef
$(foreach m,$(MAINS),$(eval $(call program_rule,$m)))
PROGRAMS := $(foreach m,$(MAINS),$(call program_name,$m))
# Those that a proxy can take part for: all components but the two that others reach in shared memory.
FOREIGN_PROGRAMS := $(foreach p,$(filter-out supervisor communication,$(patsubst %_program.c,%,\
                    $(notdir $(wildcard fsw/programs/*_program.c)))),$B/bin/$(subst _,-,$p))

# --- C tests: each links its own layer and those its layer sees ----------------------------------------------------
selected   = $(if $(ONLY),$(foreach t,$1,$(if $(findstring $(ONLY),$t),$t)),$1)
SUPPORT   := $(call objects,$(wildcard test/support/*.c))
SUPPORT_A := $B/lib/libtest_support.a
LAYERS    := $(shell awk -F ' *: *' 'NF == 2 && /^[a-z]/ { gsub(/\*/, "%", $$1); gsub(/ +/, ",", $$2); print $$1 ":" $$2 }' \
               test/lint/layers.txt)

comma     := ,
under      = $(foreach l,$(DIRS),$(if $(filter $1 $1/%,$l),$l))
# `layer:seen,seen` of a folder, and what it links: its whole layer and all that one sees. A header that is seen brings
# the library of its folder; who sees the contract of the operating system links a port.
layer_of   = $(firstword $(foreach l,$(LAYERS),$(if $(filter $(call home,$l) $(call home,$l)/%,$1),$l)))
home       = $(firstword $(subst :, ,$1))
seen       = $(patsubst %/status.h,%,$(patsubst osal/include,osal,$(subst $(comma), ,$(word 2,$(subst :, ,$1)))))
layer_libraries = $(foreach d,$(sort $(foreach s,$1 $(call home,$(call layer_of,$1)) $(call seen,$(call layer_of,$1)),\
               $(call under,$s))),$(call library,$d))

mirrored   = $(patsubst test/unit/%,%,$(patsubst test/contract/%,%,$(patsubst %/,%,$(dir $1))))
test_name  = $(patsubst %.c,$B/%,$1)
fixtures   = $(filter-out $(dir $1)test_%,$(wildcard $(dir $1)*.c $(dir $(patsubst %/,%,$(dir $1)))fixtures/*.c))

# A test that defines __wrap_x takes the part of x in what it links; __real_x is x itself.
WRAPPED   := $(shell grep -o '__wrap_[A-Za-z0-9_]*' $(TESTS) /dev/null | LC_ALL=C sort -u)
wraps_of   = $(patsubst $1:__wrap_%,-Wl$(comma)--wrap=%,$(filter $1:%,$(WRAPPED)))
counted    = $(if $(S390X),,-Wl$(comma)--wrap=UnityDefaultTestRun) # See test/support/descriptors.h.
TEST_EXTERNALS = $(if $(S390X),,-lcmocka -lode -llcm -lsqlite3) $(LUA) $(NETTLE) -lexpat -lpthread -lm

define test_rule
$(call test_name,$1): $(call objects,$1 $(call fixtures,$1)) $(SUPPORT_A) $(call layer_libraries,$(call mirrored,$1))
	@mkdir -p $$(@D)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(call wraps_of,$1) $(counted) -o $$@ $$(filter %.o,$$^) $$(call group,$$^) -Wl,--as-needed $(TEST_EXTERNALS)
endef
$(foreach t,$(TESTS),$(eval $(call test_rule,$t)))

$(SUPPORT_A): $(SUPPORT) $B/obj/unity.o
	@mkdir -p $(@D) && rm -f $@
	$(Q)$(AR) rcs $@ $^
$B/obj/unity.o: | build/setup/test
	@mkdir -p $(@D)
	$(Q)$(CC) -std=c99 $(OPTIMIZE) -c build/third_party/unity/src/unity.c -o $@
$(call objects,$(TESTS)) $(SUPPORT): | build/setup/test
-include $(patsubst %.o,%.d,$(call objects,$(wildcard test/support/*.c test/bench/*.c test/unit/pus/fixtures/*.c $(addsuffix *.c,$(sort $(dir $(TESTS)))))))

define bench_rule
$(patsubst test/bench/%.c,$B/bench/%,$1): $(call objects,$1 $(filter-out test/bench/bench_%,$(wildcard test/bench/*.c))) $(LIBRARIES)
	@mkdir -p $$(@D)
	$(Q)$(CC) $(CFLAGS) -o $$@ $$(filter %.o,$$^) $$(call group,$$^) \
	    -Wl,--as-needed -lexpat $(LUA) $(NETTLE) -lode -llcm -lsqlite3 -lpthread -lm
endef
$(foreach b,$(BENCHES),$(eval $(call bench_rule,$b)))
include test/bench/transport.mk

# --- fuzz targets: built by clang in their own variant, each with what all of them share ------------------------
define fuzz_rule
$B/target/$1: $(call objects,test/fuzz/fuzz_$1.c $(filter-out test/fuzz/fuzz_%,$(FUZZ_SOURCES)) test/support/scripted_bus.c) \
              $(LIBRARIES)
	@mkdir -p $$(@D)
	$(Q)$(CC) $(CFLAGS) -fsanitize=fuzzer -o $$@ $$(filter %.o,$$^) $$(call group,$$^) \
	    -Wl,--as-needed -lexpat $(LUA) $(NETTLE) -lode -llcm -lsqlite3 -lpthread -lm
endef
$(if $(FUZZ),$(foreach t,$(FUZZ_TARGETS),$(eval $(call fuzz_rule,$t))))
-include $(patsubst %.o,%.d,$(call objects,$(FUZZ_SOURCES)))

# --- targets for people --------------------------------------------------------------------------------------------
.PHONY: force all help programs tests thread-tests kernel-tests foreign foreign-programs foreign-tests benches fuzzers fuzz fuzz-corpus sim-run vm test test-hil check check-full bench doctor setup clean gse format new-subsystem docs
help:
	@sed -n 's/^## \{0,1\}//p' $(firstword $(MAKEFILE_LIST))

all: build/setup/run
	$(PARALLEL) programs
programs: $(LIBRARIES) $(PROGRAMS)
	@:
foreign: build/setup/test
	$(PARALLEL) S390X=1 foreign-programs
# What has several tasks at one thing: built and run once more to look for data races.
THREAD_TESTS := $(filter %_torture.c %/test_loop_tasks.c %/test_link_doorbell.c %/test_packet_log_writer.c \
                $(patsubst %,test/contract/osal/test_%.c,mutex event task doorbell inversion),$(TESTS))
thread-tests: $(foreach t,$(call selected,$(THREAD_TESTS)),$(call test_name,$t))
	@:
tests: $(foreach t,$(call selected,$(TESTS)),$(call test_name,$t))
	@:
# What puts numbers into octets, where numbers lie the other way round. Only Unity's, since cmocka is not there for it,
# and what needs neither several tasks (the emulator has no locks with inheritance of priority) nor the clock on the wall.
FOREIGN_TESTS := $(filter test/unit/pus/% test/unit/fsw/canopen/% %/test_remote_endian_wire.c test/unit/base/% $(foreach f,parameter rtlink message,\
                 test/unit/fsw/framework/$f/%),$(filter-out test/unit/pus/tool/% %_torture.c %_endurance.c,$(TESTS)))
FOREIGN_TESTS := $(if $(FOREIGN_TESTS),$(shell grep -L cmocka.h $(FOREIGN_TESTS)))
foreign-tests: $(FOREIGN_PROGRAMS) $(foreach t,$(FOREIGN_TESTS),$(call test_name,$t))
	@:
foreign-programs: $(FOREIGN_PROGRAMS)
	@:
# What the tests in test/hil run once more on a kernel that has such buses.
KERNEL_TESTS := $(filter $(patsubst %,test/contract/osal/test_%.c,lockstep_scheduler_blocking can can_socket tipc network) %/test_flow_can_socket.c \
                test/unit/fsw/framework/message/%,$(TESTS))
kernel-tests: $(foreach t,$(KERNEL_TESTS),$(call test_name,$t))
	@:
benches: $(patsubst test/bench/%.c,$B/bench/%,$(call selected,$(BENCHES))) $(TRANSPORTS:%=$B/bench/transport/%)
	@:

build/setup/%: gse/setup/setup.sh gse/setup/unity.sh gse/setup/expat_s390x.sh gse/setup/yamcs.sh gse/yamcs/pom.xml gse/setup/packages.txt gse/requirements.txt test/requirements.txt
	@sh gse/setup/setup.sh $*
setup: build/setup/full
doctor:
	@sh gse/setup/doctor.sh

# Only what was said on the command line is passed on; the launcher knows the defaults and refuses nonsense.
option = $(if $(filter command%,$(origin $2)),$(if $($2),--$1 '$($2)'))
adapter = $(if $(filter command%,$(origin $3)),$(if $($3),--$1 '$2=$($3)'))
sim-run: all $(if $(FOREIGN),foreign)
	@build/bin/hirosco run $(call option,mission,MISSION) $(call option,scenario,SCENARIO) $(call option,seed,SEED) \
	    $(call option,form,FORM) $(call option,time,TIME) $(call option,bus,BUS) \
	    $(call option,transport,TRANSPORT) $(call option,nodes,NODES) $(call option,links,LINKS) $(call option,port,PORT) $(call option,tools,TOOLS) $(call option,out,OUT) \
	    $(call option,storage,STORAGE) $(call option,key,KEY) $(call option,foreign,FOREIGN) $(call adapter,interface,robot,ROBOT_IF) $(call adapter,interface,joystick,JOYSTICK_IF) \
	    $(call adapter,sim-interface,robot,SIM_ROBOT_IF) $(call adapter,sim-interface,joystick,SIM_JOYSTICK_IF)

NEEDS_FOREIGN = $(findstring $(or $(ONLY),test/hil),test/hil/test_big_endian.py)
BUILD_FOREIGN = $(MAKE) --no-print-directory -j$(JOBS) ONLY= S390X=1 foreign-tests
HIL_TESTS = $(strip $(call selected,$(sort $(wildcard test/hil/test_*.py))))
test: build/setup/$(if $(HIL_TESTS),vm,test)
	+@failed=; \
	$(MAKE) -k --no-print-directory -j$(JOBS) programs tests $(if $(HIL_TESTS),kernel-tests) || failed='the build'; \
	$(MAKE) -k --no-print-directory -j$(JOBS) SANITIZE=1 programs tests || failed="$$failed the sanitizer build"; \
	$(if $(or $(if $(ONLY),,all),$(findstring fuzz,$(ONLY))),$(BUILD_FUZZERS) -k ONLY= || failed="$$failed the fuzz build";) \
	$(MAKE) -k --no-print-directory -j$(JOBS) TSAN=1 CC=clang thread-tests || failed="$$failed the build against data races"; \
	$(if $(NEEDS_FOREIGN),$(BUILD_FOREIGN) -k || failed="$$failed the big-endian build";) \
	$(VENV) test/support/run_tests.py --threads '$(call selected,$(THREAD_TESTS))' --jobs $(JOBS) --only '$(ONLY)' --failed "$$failed" $(call selected,$(TESTS))

test-hil: build/setup/vm all
	$(PARALLEL) kernel-tests
	+$(if $(NEEDS_FOREIGN),@$(BUILD_FOREIGN))
	@$(if $(HIL_TESTS),,$(error no test in test/hil has '$(ONLY)' in its path))HIL_PLACE='$(PLACE)' \
	    $(VENV) test/support/run_tests.py --jobs $(JOBS) --under test/hil --only '$(ONLY)'

mutants: build/setup/test
	+@$(MAKE) --no-print-directory -j$(JOBS) ONLY= tests
	@$(PYTHON) test/mutants/run_mutants.py --jobs $(JOBS) --only '$(ONLY)' $(call option,count,COUNT) $(call option,seed,SEED) \
	    $(if $(CHECK),--check)

pus-coverage: build/setup/test all
	@UPDATE_COVERAGE=1 $(VENV) -m pytest -q -p no:cacheprovider --timeout=600 --rootdir=. test/conformance/pus

fuzzers: $(foreach t,$(call selected,$(FUZZ_TARGETS)),$B/target/$t)
	@:
BUILD_FUZZERS = $(MAKE) --no-print-directory -j$(JOBS) FUZZ=1 CC=clang fuzzers
SECONDS ?= 20
fuzz: build/setup/test
	$(if $(strip $(call selected,$(FUZZ_TARGETS))),,$(error ONLY=$(ONLY): no fuzz target has this in its name; there are: $(FUZZ_TARGETS)))
	+@$(BUILD_FUZZERS)
	@$(PYTHON) test/fuzz/run_fuzz.py --seconds $(SECONDS) $(call selected,$(FUZZ_TARGETS))
# Seeds from our own vectors, with what a run has found, reduced to what adds coverage: for whoever adds a target.
fuzz-corpus: build/setup/test
	+@$(BUILD_FUZZERS)
	@$(VENV) test/fuzz/make_corpus.py $(call selected,$(FUZZ_TARGETS))

# The command is passed on as it was written, without make reading its dollar signs.
build/vm/initramfs.cpio: build/setup/hil gse/vm/prepare.py gse/vm/init.sh
	@$(PYTHON) gse/vm/prepare.py && touch $@
build/setup/vm: build/vm/initramfs.cpio
	@touch $@
vm: export VM_COMMAND := $(value CMD)
vm: build/setup/vm
	@$(PYTHON) gse/vm/microvm.py $(call option,seconds,SECONDS) $(call option,cans,CANS) $(call option,memory,MEMORY) \
	    $(call option,out,OUT)

build/setup/peers: gse/setup/peers.sh gse/setup/peers.txt $(shell find test/bench/peers -type f)
	@sh gse/setup/peers.sh
build/setup/peer-spacepackets: gse/setup/peers.sh $(shell find test/bench/peers/spacepackets -type f)
	@sh gse/setup/peers.sh spacepackets
bench: build/setup/test build/setup/peers
	$(PARALLEL) programs benches
	@$(VENV) test/bench/run_bench.py --only '$(ONLY)' --out build/bench.json $(if $(CHECK),--check)

gse: build/setup/run $(GENERATED)
	@echo 'The ground segment is ready. Call it as:'
	@echo '    build/venv/bin/gse --help'
	@echo 'or put it into the path of this shell:'
	@echo '    . build/venv/bin/activate'

.PHONY: yamcs
yamcs: build/setup/full $(GENERATED)
	@$(PYTHON) gse/yamcs/run.py $(call option,mission,MISSION) $(call option,ground-port,PORT) $(call option,http-port,HTTP)

new-subsystem:
	@$(PYTHON) gse/scaffold/new_subsystem.py $(call option,name,NAME) $(call option,apid,APID) \
	    $(call option,mission,MISSION)

docs: build/setup/docs
	@$(PYTHON) gse/docs/make_docs.py --out build/docs

C_FILES = $(shell find base osal pus fsw launcher sim test -name '*.[ch]')
format: build/setup/check
	$(Q)clang-format -i $(C_FILES)

.PHONY: compile-commands
compile-commands: $(GENERATED)
	@separator='['; for file in $(filter %.c,$(C_FILES)); do \
	    printf '%s\n{"directory": "%s", "file": "%s", "command": "%s -c %s"}' "$$separator" '$(CURDIR)' "$$file" \
	        '$(strip $(CC) $(CPPFLAGS) $(CFLAGS))' "$$file"; \
	    separator=','; done >build/compile_commands.json && printf '\n]\n' >>build/compile_commands.json

clean:
	rm -rf $(if $(ALL),build,$(filter-out build/venv build/third_party build/setup build/vm,$(wildcard build/*)))

# --- checks ----------------------------------------------------------------------------------------------------------
CHECKS := check-format check-gcc check-clang check-analyzer check-tidy check-misra check-complexity check-layers \
          check-symbols check-text check-spelling check-links check-python coverage
.PHONY: $(CHECKS) check-misra-all check-mutants check-fuzz mutants flight-objects tidied coverage-tests
check: build/setup/check
	+@$(MAKE) --no-print-directory -k $(CHECKS) && echo 'check: all passed'
check-full: check build/setup/full
	+@$(MAKE) --no-print-directory -k check-misra-all check-fuzz check-mutants check-flights && echo 'check-full: all passed'

check-format: build/setup/check
	@clang-format --dry-run -Werror $(C_FILES) && echo 'check: format is right'
check-gcc: build/setup/check
	$(PARALLEL) CC=gcc programs tests benches && echo 'check: no warning from gcc'
check-clang: build/setup/check
	$(PARALLEL) CC=clang programs tests benches && echo 'check: no warning from clang'
check-analyzer: build/setup/check
	$(PARALLEL) ANALYZE=1 flight-objects && echo 'check: the analyzer of gcc finds nothing'
flight-objects: $(call objects,$(filter-out sim/%,$(SOURCES)))
	@:

# A source that passed leaves a stamp, which its headers outdate.
check-tidy: build/setup/check
	$(PARALLEL) -k tidied && echo 'check: clang-tidy finds nothing'
tidied: $(patsubst %.c,build/lint/tidy/%.passed,$(SOURCES))
	@:
build/lint/tidy/%.passed: %.c .clang-tidy | $(GENERATED)
	@mkdir -p $(@D) && gcc -std=c99 $(CPPFLAGS) -MM -MP -MT $@ -MF $(@:.passed=.d) $<
	@clang-tidy --quiet $< -- -std=c99 $(CPPFLAGS) >$(@:.passed=.txt) 2>&1 && touch $@ || \
	    { sed -n 's|$(CURDIR)/||; / error: /p' $(@:.passed=.txt); exit 1; }
-include $(patsubst %.c,build/lint/tidy/%.d,$(SOURCES))

FLIGHT = $(filter-out sim/%,$(SOURCES))
check-misra: build/setup/check $(GENERATED)
	@$(PYTHON) test/lint/check_misra.py --jobs $(JOBS) $(FLIGHT)
check-misra-all: build/setup/check $(GENERATED)
	@$(PYTHON) test/lint/check_misra.py --all --jobs $(JOBS) $(FLIGHT)
check-complexity: build/setup/check
	@build/venv/bin/lizard -l c -l python -w -C 15 base osal pus fsw launcher sim gse && echo 'check: no function is too complex'
.PHONY: check-flights
check-flights: build/setup/vm build/setup/full build/setup/peer-spacepackets all foreign # The long ones: many deaths at random moments and power cuts, peers.
	@LONG=1 $(VENV) -m pytest -q -p no:cacheprovider -m long -n $(JOBS) --dist loadfile test/mission test/hil test/conformance && echo 'check: every flight ends as it should'
check-layers:
	@$(PYTHON) test/lint/check_layers.py
check-symbols: all
	@$(PYTHON) test/lint/check_symbols.py $(call objects,$(filter-out sim/% pus/tool/%,$(SOURCES)))
check-text:
	@$(PYTHON) test/lint/check_text.py
check-python: build/setup/check
	@build/venv/bin/ruff check --quiet --no-cache --select E9,F gse test && echo 'check: Python is well-formed'
check-spelling: build/setup/check
	@build/venv/bin/codespell --ignore-words test/lint/spelling.txt --skip '$(subst $() ,$(comma),$(UNSPELLED))' && \
	    echo 'check: no known misspelling'
UNSPELLED := ./build ./runs ./.git ./.ruff_cache ./.pytest_cache ./test/fuzz/corpus ./test/lint/words.txt *.pyc
check-links:
	@$(PYTHON) test/lint/check_links.py
check-mutants:
	+@$(MAKE) --no-print-directory mutants ONLY= COUNT=300 CHECK=1
check-fuzz: build/setup/check
	+@$(MAKE) --no-print-directory fuzz SECONDS=300

# --- coverage: the C tests in a variant of their own ------------------------------------------------------------
COVERING = $(filter-out test/unit/sim/% test/unit/pus/tool/% %_endurance.c,$(TESTS))
coverage: build/setup/check
	$(if $(strip $(call selected,$(COVERING))),,$(error ONLY=$(ONLY): no C unit test has this in its path))
	$(PARALLEL) COVERAGE=1 coverage-tests
	@find build/coverage -name '*.gcda' -delete
	@$(VENV) test/support/run_tests.py --jobs $(JOBS) --only '$(ONLY)' --no-pytest --variant build/coverage \
	    $(call selected,$(COVERING)) >build/coverage/tests.txt || \
	    { grep ':FAIL\|did not build\|FAILED' build/coverage/tests.txt; echo 'coverage: some tests failed: see make test'; }
	@$(VENV) test/lint/check_coverage.py --jobs $(JOBS) $(if $(UPDATE),--update) $(if $(ONLY),--no-marks)
coverage-tests: $(foreach t,$(call selected,$(COVERING)),$(call test_name,$t))
	@:
