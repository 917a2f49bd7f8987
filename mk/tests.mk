# SPDX-License-Identifier: Apache-2.0
# C tests, each linked with its own layer and the layers that this layer may include; benches; targets that run tests.

selected   = $(if $(ONLY),$(foreach t,$1,$(if $(findstring $(ONLY),$t),$t)),$1)
# Headers of POSIX and of libraries that need Linux. C files that include none of them are portable.
MACHINE_HEADERS := <\(cmocka\|dirent\|expat\|fcntl\|linux/.*\|mqueue\|net.*/.*\|nettle/.*\|poll\|pthread\|sched\|\
                   signal\|sys/.*\|time\|unistd\)\.h>\|test/support/clients\.h
MACHINE_HEADERS := $(subst $() ,,$(MACHINE_HEADERS))
portable   = $(if $1,$(shell grep -L '$(MACHINE_HEADERS)' $1))
SUPPORT_SOURCES := $(wildcard test/support/*.c)
ifdef BOARD
SUPPORT_SOURCES := $(filter-out test/support/sealer.c,$(call portable,$(SUPPORT_SOURCES)))
# What a test on a board needs: the port of the operating system layer, and the system calls that the C library uses.
BOARD_SYSTEM := $(call objects,test/support/board/system.c) \
                $(foreach d,base $(filter osal/%,$(DIRS)),$(call library,$d))
CPPFLAGS  += -DUNITY_SUPPORT_64 -DTEST_DIRECTORY='"/eeprom"' # The EEPROM of the board.
endif
SUPPORT   := $(call objects,$(SUPPORT_SOURCES))
SUPPORT_A := $B/lib/libtest_support.a
LAYERS    := $(shell awk -F ' *: *' \
               'NF == 2 && /^[a-z]/ { gsub(/\*/, "%", $$1); gsub(/ +/, ",", $$2); print $$1 ":" $$2 }' \
               test/lint/layers.txt)

comma     := ,
under      = $(foreach l,$(DIRS),$(if $(filter $1 $1/%,$l),$l))
# layer_of: line `layer:included,included` of the layer to which a directory belongs. A test in the directory links
# the libraries of this layer and of all layers that it may include. If a single header may be included, the
# library of its directory is linked; a layer that may include the headers of osal/ links a port of it.
layer_of   = $(firstword $(foreach l,$(LAYERS),$(if $(filter $(call home,$l) $(call home,$l)/%,$1),$l)))
# home: directory of such a line; seen: directories that it may include; under: the directory and all below it.
home       = $(firstword $(subst :, ,$1))
seen       = $(patsubst %/status.h,%,$(patsubst osal/include,osal,$(subst $(comma), ,$(word 2,$(subst :, ,$1)))))
layer_libraries = $(foreach d,$(sort $(foreach s,$1 $(call home,$(call layer_of,$1)) $(call seen,$(call layer_of,$1)),\
               $(call under,$s))),$(call library,$d))

mirrored   = $(patsubst test/unit/%,%,$(patsubst test/contract/%,%,$(patsubst %/,%,$(dir $1))))
test_name  = $(patsubst %.c,$B/%,$1)
parent     = $(dir $(patsubst %/,%,$(dir $1)))
fixtures   = $(filter-out $(dir $1)test_% $(parent)test_%,$(wildcard $(dir $1)*.c $(parent)*.c $(parent)fixtures/*.c))

# If a test defines __wrap_x, the code that the test links calls it instead of x; __real_x calls x itself.
WRAPPED   := $(shell grep -o '__wrap_[A-Za-z0-9_]*' $(TESTS) $(wildcard test/board/*.c) /dev/null | \
               LC_ALL=C sort -u)
wraps_of   = $(patsubst $1:__wrap_%,-Wl$(comma)--wrap=%,$(filter $1:%,$(WRAPPED)))
# The runners of Unity and cmocka are replaced by runners that also count open files (test/support/descriptors.h).
# On a board, test/support/board provides the memory that a test allocates, because the port provides none.
counted    = $(if $(BOARD),$(foreach f,malloc calloc realloc free,-Wl$(comma)--wrap=$f))
counted   += $(if $(S390X)$(BOARD),,-Wl$(comma)--wrap=UnityDefaultTestRun -Wl$(comma)--wrap=_cmocka_run_group_tests)
TEST_EXTERNALS = $(if $(BOARD),-lm -lc -lgcc,\
               $(if $(S390X),,-lcmocka -lode -llcm -lsqlite3) $(LUA) $(NETTLE) -lexpat -lpthread -lm)

# Only a test that expects a failing assertion links the fsw_assertion_failed of test/support; all other tests link the
# one of the port.
ASSERTING := $(shell grep -l assertion_fails $(TESTS) /dev/null)
caught     = $(if $(filter $1,$(ASSERTING)),$B/obj/test/support/assertion.o)

# Tests whose data do not fit the 4 MiB of the board (osal/freertos/mps2.ld).
LARGE_TESTS := $(foreach s,st11 st15 st22,test/unit/pus/$s/%) test/unit/pus/core/test_packet_store_power.c
large        = $(if $(BOARD),$(if $(filter $(LARGE_TESTS),$1),-Wl$(comma)--defsym=port_large_data=1))

define test_rule
$(call test_name,$1): $(call objects,$1 $(call fixtures,$1)) $(call caught,$1) \
    $(call layer_libraries,$(call mirrored,$1)) $(SUPPORT_A) $(BOARD_SYSTEM) $(FOREIGN_A)
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(TEST_LINKER) $(call large,$1) $(call wraps_of,$1) $(counted) -o $$@ \
	    $$(filter %.o,$$^) $$(call group,$$^) -Wl,--as-needed $(TEST_EXTERNALS)
endef
$(foreach t,$(TESTS),$(eval $(call test_rule,$t)))

$(SUPPORT_A): $(SUPPORT) $B/obj/unity.o
	@mkdir -p $(@D) && rm -f $@
	$(Q)$(AR) rcs $@ $^
$B/obj/unity.o: | build/setup/unit
	@mkdir -p $(@D)
	$(Q)$(CC) $(CPPFLAGS) $(PROCESSOR) -std=c99 $(OPTIMIZE) -c build/third_party/unity/src/unity.c -o $@
$(call objects,$(TESTS)) $(SUPPORT): | build/setup/unit
-include $(patsubst %.o,%.d,$(call objects,$(SUPPORT_SOURCES) $(wildcard test/bench/*.c test/unit/*/fixtures/*.c \
         $(addsuffix *.c,$(sort $(dir $(TESTS)))))))

define bench_rule
$(patsubst test/bench/%.c,$B/bench/%,$1): \
    $(call objects,$1 $(filter-out test/bench/bench_%,$(wildcard test/bench/*.c))) $(LIBRARIES)
	@mkdir -p $$(@D)
	$(Q)$(CC) $(CFLAGS) -o $$@ $$(filter %.o,$$^) $$(call group,$$^) \
	    -Wl,--as-needed -lexpat $(LUA) $(NETTLE) -lode -llcm -lsqlite3 -lpthread -lm
endef
$(foreach b,$(BENCHES),$(eval $(call bench_rule,$b)))
include test/bench/transport.mk

# Tests in which several tasks use one object; they are built and run again with the thread sanitizer. Those of
# programs and supervisor link nearly all libraries, and run again only with LONG=1.
THREAD_TESTS := $(filter %_stress.c %/test_loop_tasks.c %/test_write_behind.c %/test_packet_log_writer.c \
                $(patsubst %,test/contract/osal/test_%.c,mutex event task) \
                $(patsubst %,test/contract/osal/posix/test_%.c,mutex event task inversion),$(TESTS))
THREAD_TESTS := $(filter-out $(if $(LONG),,test/unit/fsw/programs/% test/unit/fsw/supervisor/%),$(THREAD_TESTS))
thread-tests: $(foreach t,$(call selected,$(THREAD_TESTS)),$(call test_name,$t))
	@:
tests: $(foreach t,$(call selected,$(TESTS)),$(call test_name,$t))
	@:
# Tests of conversions between numbers and octets, which also run for a big-endian processor. They use Unity, because
# cmocka is not available for that processor, and they need neither several tasks (the emulator has no locks with
# priority inheritance) nor wall-clock time. They are built and run with LONG=1.
REMOTE_ENDIAN_TESTS := $(filter test/unit/pus/% test/unit/fsw/canopen/% test/unit/base/% \
                 %/test_remote_endian_wire.c $(foreach f,parameter rtlink message,test/unit/fsw/framework/$f/%),\
                 $(filter-out test/unit/pus/tool/% %_stress.c %_endurance.c,$(TESTS)))
REMOTE_ENDIAN_TESTS := $(if $(REMOTE_ENDIAN_TESTS),$(shell grep -L cmocka.h $(REMOTE_ENDIAN_TESTS)))
remote-endian-tests: $(REMOTE_ENDIAN_PROGRAMS) $(foreach t,$(REMOTE_ENDIAN_TESTS),$(call test_name,$t))
	@:
remote-endian-programs: $(REMOTE_ENDIAN_PROGRAMS)
	@:
# Portable tests that also run on a board: tests of the contracts of the operating system layer, of base, of the
# packet services, and of all that a subsystem links. The list omits tests that need more memory than the board has,
# several processes, or a heap of a certain size.
PORTABLE_TESTS := $(filter test/contract/osal/test_% test/unit/base/% test/unit/pus/% test/unit/fsw/canopen/% \
    test/unit/fsw/drives/% \
    $(foreach t,compiled_descriptors loop_watchdog run_flow_address subsystem_host,test/unit/fsw/programs/test_$t.c) \
    $(foreach f,control dataflow descriptor journal message parameter rtlink subsystem,test/unit/fsw/framework/$f/%) \
    $(foreach s,actuators arm joystick manipulator,test/unit/fsw/subsystems/$s/%),\
    $(filter-out test/unit/pus/tool/% %_endurance.c %/test_long_lists.c %/test_link_stress.c,$(TESTS)))
# Portable tests of packet services, those that take long on the board, and those that link libraries that no other test
# needs there: they run on the board only with LONG=1 (`make check-full`).
LONG_BOARD_TESTS := $(filter test/unit/pus/st% test/unit/pus/private/% test/unit/fsw/programs/% \
    test/unit/fsw/subsystems/% test/unit/fsw/framework/descriptor/% \
    %_stress.c %_fuzz.c %/test_elementary.c %/test_number.c %/test_agreement.c %/test_subsystem_errors.c \
    $(foreach t,ring epochs lives overload,%/test_message_$t.c) \
    $(foreach t,power damage,%/test_journal_$t.c) $(LARGE_TESTS),$(PORTABLE_TESTS))
PORTABLE_TESTS := $(call portable,$(if $(LONG),$(PORTABLE_TESTS),$(filter-out $(LONG_BOARD_TESTS),$(PORTABLE_TESTS)))) \
    $(BOARD_ONLY_TESTS)
board-tests: $(foreach t,$(call selected,$(PORTABLE_TESTS)),$(call test_name,$t))
	@:
# The program of the manipulator, linked with one file of test/board: with steps.c it is
# build/mps2-an500/steps/manipulator. real_time.c also needs scripted drives.
PARTS_OF_steps := test/support/board/numbers.c
PARTS_OF_real_time := test/support/scripted_bus.c $(addprefix test/support/board/,numbers.c system.c)
define board_program_rule
build/$(BOARD)/$1/manipulator: $(SIZED)/manipulator/obj/test/board/$1.o $(call objects,$(PARTS_OF_$1)) \
        $(call target_parts,manipulator) osal/freertos/mps2.ld
	@mkdir -p $$(@D)
	$(if $(V),,@echo "  link $$@")
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) $(call wraps_of,test/board/$1.c) -o $$@ $$(filter %.o,$$^) \
	    $$(call group,$$^) -lm -lc -lgcc
endef
BOARD_PARTS := $(patsubst test/board/%.c,%,$(wildcard test/board/*.c))
$(foreach p,$(if $(TARGET),$(BOARD_PARTS)),$(eval $(call board_program_rule,$p)))
board-programs: $(if $(TARGET),$(BOARD_PARTS:%=build/$(BOARD)/%/manipulator),build/setup/rtos)
	$(if $(TARGET),@:,$(PARALLEL) BOARD=$(or $(BOARD),mps2-an500) TARGET=1 MISSION= board-programs)
# Tests that test/hil runs again on a kernel with CAN buses and TIPC.
KERNEL_TESTS := $(filter %/test_flow_can_socket.c test/unit/fsw/framework/message/% \
                test/contract/osal/test_can.c \
                $(patsubst %,test/contract/osal/posix/test_%.c,\
                    lockstep_scheduler_blocking can can_socket tipc network),\
                $(TESTS))
kernel-tests: $(foreach t,$(KERNEL_TESTS),$(call test_name,$t))
	@:
# bench_mission.py runs two of these programs.
RUN_BY_SCRIPTS := $(if $(call selected,test/bench/bench_mission.py),\
    test/bench/bench_plant.c test/bench/bench_futex_ring.c)
benches: $(patsubst test/bench/%.c,$B/bench/%,$(sort $(call selected,$(BENCHES)) $(RUN_BY_SCRIPTS))) \
    $(TRANSPORTS:%=$B/bench/transport/%)
	@:

# The tests that ONLY selects, and what they need: `make test` installs and builds nothing else.
PYTHON_TESTS   := $(strip $(call selected,$(shell find test -name 'test_*.py' | LC_ALL=C sort)))
FLYING_TESTS   := $(filter test/conformance/% test/mission/% test/hil/% test/fuzz/test_random_flight.py,$(PYTHON_TESTS))
HIL_TESTS      := $(filter test/hil/%,$(PYTHON_TESTS))
NEEDS_PROGRAMS := $(if $(FLYING_TESTS),programs random-flight)
NEEDS_KEPT_INPUTS := $(if $(filter test/fuzz/test_fuzz.py,$(PYTHON_TESTS)),kept-inputs)
NEEDS_REMOTE_ENDIAN  := $(filter test/hil/test_remote_endian.py,$(PYTHON_TESTS))
TEST_BOARD     := mps2-an500
BOARD_TESTS    := $(if $(wildcard osal/freertos/startup.c),$(strip $(call selected,$(PORTABLE_TESTS))))
NEEDS_THREADS  := $(strip $(call selected,$(THREAD_TESTS)))
TEST_SETUP     := $(if $(FLYING_TESTS),test) $(if $(HIL_TESTS),vm) $(if $(NEEDS_REMOTE_ENDIAN),s390x) \
                  $(if $(BOARD_TESTS),rtos) $(if $(PYTHON_TESTS),pytest) \
                  $(if $(NEEDS_THREADS),clang) unit
BUILD_REMOTE_ENDIAN   = $(MAKE) --no-print-directory -j$(JOBS) ONLY= S390X=1 remote-endian-programs
test-setup: $(TEST_SETUP:%=build/setup/%)
	@:
test: test-setup
	+@failed=; \
	$(MAKE) -k --no-print-directory -j$(JOBS) $(NEEDS_PROGRAMS) $(if $(LONG),tests) \
	    $(if $(PYTHON_TESTS),generated) $(if $(HIL_TESTS),kernel-tests) || failed='the build'; \
	$(MAKE) -k --no-print-directory -j$(JOBS) SANITIZE=1 $(NEEDS_PROGRAMS) $(NEEDS_KEPT_INPUTS) tests || \
	    failed="$$failed the sanitizer build"; \
	$(if $(NEEDS_THREADS),$(MAKE) -k --no-print-directory -j$(JOBS) TSAN=1 CC=clang thread-tests || \
	    failed="$$failed the build against data races";) \
	$(if $(BOARD_TESTS),$(MAKE) -k --no-print-directory -j$(JOBS) BOARD=$(TEST_BOARD) board-tests || \
	    failed="$$failed the build for a board";) \
	$(if $(NEEDS_REMOTE_ENDIAN),$(BUILD_REMOTE_ENDIAN) -k || failed="$$failed the big-endian build";) \
	$(if $(PYTHON_TESTS),$(VENV),$(PYTHON)) test/support/run_tests.py --threads '$(NEEDS_THREADS)' \
	    --board $(TEST_BOARD) --on-board '$(BOARD_TESTS)' --jobs $(JOBS) \
	    --only '$(ONLY)' --failed "$$failed" $(call selected,$(TESTS))

test-hil: build/setup/vm $(if $(NEEDS_REMOTE_ENDIAN),build/setup/s390x) all
	$(PARALLEL) kernel-tests
	+$(if $(NEEDS_REMOTE_ENDIAN),@$(BUILD_REMOTE_ENDIAN))
	@$(if $(HIL_TESTS),,$(error no test in test/hil has '$(ONLY)' in its path))HIL_ENVIRONMENT='$(TEST_ENVIRONMENT)' \
	    $(VENV) test/support/run_tests.py --jobs $(JOBS) --under test/hil --only '$(ONLY)'

mutants: build/setup/unit $(if $(FLY),build/setup/test all)
	+@$(MAKE) --no-print-directory -j$(JOBS) ONLY= tests
	@$(PYTHON) test/mutants/run_mutants.py --jobs $(JOBS) --only '$(ONLY)' \
	    $(call option,count,COUNT) $(call option,seed,SEED) $(if $(FLY),--fly) $(if $(CHECK),--check)

pus-coverage: build/setup/test all
	@UPDATE_COVERAGE=1 $(VENV) -m pytest -q -p no:cacheprovider --timeout=600 --rootdir=. test/conformance/pus

# Only bench_link.py compares with software of other projects, the peers.
bench: build/setup/test $(if $(call selected,test/bench/bench_link.py),build/setup/peers)
	$(PARALLEL) programs benches
	@$(VENV) test/bench/run_bench.py --only '$(ONLY)' --out build/bench.json $(if $(CHECK),--check)
