# SPDX-License-Identifier: Apache-2.0
# The only entry point of the project. All output goes under build/ and runs/.
#
# Every directory with C sources becomes one static library; every *_main.c becomes a program in build/bin/. Lines that
# begin with two number signs are what `make help` prints.

## hirosco: flight software, simulator and ground segment
##
##   make [all]      build all programs into build/bin/          SANITIZE=1  TSAN=1  CC=gcc|clang  V=1  JOBS=2
##   make sim-run    fly a mission, leave its report in runs/    MISSION=rokviss  SCENARIO=telepresence|none  SEED=1
##                                                               FORM=processes|image  TIME=stepped|real|free  WORLD=
##                                                               BUS=shm|vcan|can
##                                                               TRANSPORT=udp|tipc  LINKS=shm|udp|tipc  NODES=1|2
##                                                               DELAY=<ms>: round trip of real-time links by a relay
##                                                               PORT=  TOOLS=  OUT=runs/...  STORAGE=<path to keep>
##                                                               KEY=<file>: accept only telecommands protected by it
##                                                               BUS=can: ROBOT_IF=can0  JOYSTICK_IF=can1
##                                                                        SIM_ROBOT_IF=  SIM_JOYSTICK_IF=
##                                                               REMOTE_ENDIAN=<subsystem>: on an emulated s390x
##                                                               RTOS=<subsystem>[:<board>],...: on FreeRTOS on a board
##   make test       build and run the tests, end with a summary line       ONLY=<part of a test's path>  LONG=1: also
##                   those that take long
##   make test-hil   hardware in the loop only: on this kernel if it has vcan, vxcan and TIPC, else in the micro-VM
##                   ONLY=<part of a test's path>  TEST_ENVIRONMENT=vm|kernel
##   make check      format, warnings of gcc and clang, clang's analyzer, MISRA of what changed, complexity, layers,
##                   symbols, words, lengths, spelling, links, Python, quick proofs; what has passed is not repeated
##   make check-full check, coverage, MC/DC, gcc's analyzer, MISRA of all flight software, clang's analyzer without a
##                   limit of states, every proof, five minutes of each fuzz target, 300 mutants, C tests without
##                   sanitizers, all portable C tests on a board, flights with many deaths of processes, 24 h of
##                   flight, times to detect and repair deaths
##   make coverage   branches that C unit tests take, compared with test/lint/coverage.txt: build/coverage/index.html
##                   ONLY=<part of a test's path>  UPDATE=1 raises its required values
##   make mcdc       modified condition/decision coverage of the sources in test/lint/mcdc.txt by their unit tests
##   make proofs     prove parts of flight software for all inputs up to stated bounds (CBMC), and check that each proof
##                   finds the faults planted for it     ONLY=<part of a proof's path>
##   make mutants    change the flight sources in COUNT places drawn by SEED, one at a time; count the changes
##                   that the C tests detect                 FLY=1 also flies those that they do not detect
##                   ONLY=<part of a source's path:line:>  COUNT=20  SEED=1  CHECK=1: fail below 95 % (directory: 90 %)
##   make pus-coverage   fly the conformance suite of the packet services and write docs/pus-coverage.md
##   make fuzz       run every fuzz target in turn from its kept inputs        ONLY=<part of a name>  SECONDS=20
##                   HOURS=2: two hours for each target, also for make check-full
##   make vm         a shell in a micro-VM with vcan and TIPC over this tree; files written there are lost, except
##                   in build/vm/out             CMD='one command instead'  SECONDS=300  CANS=0  MEMORY=1024  OUT=path
##   make bench      measure speed and size, print a table, write build/bench.json    ONLY=<part of a name>  CHECK=1
##   make new-subsystem NAME=gripper    begin a subsystem that builds and flies     APID=  MISSION=<an existing one>
##   make new-robot URDF=arm.urdf       make a mission with that arm, which flies
##                   NAME=  TOOL=<link>  START=<angles in rad, with commas>  BASE=fixed|free  APID=
##                   WITH=<mission>: the arm flies with the subsystems of this mission, in a new one
##   make remote-endian   programs of subsystems for the big-endian s390x: build/s390x/bin/
##                   S390X=1 make remote-endian-tests: unit tests for that processor: build/s390x/test/
##   make rtos       programs of subsystems on FreeRTOS: build/mps2-an500/bin/          BOARD=mps2-an500|mps2-an385
##                   ONLY="<programs>": only these, such as manipulator joystick
##                   MISSION=<name>: with the descriptors of this mission only, not of all missions
##   make yamcs      run Yamcs for the flight of runs/latest      MISSION=  PORT=<ground port>  HTTP=8080
##                   STATION=http://127.0.0.1:8090/: the station whose 3D view it shows     OUT=runs/yamcs
##   make docs       API reference, architecture and interface control document: build/docs/index.html
##   make gse        web page of the flight that runs, or of one that it starts     HTTP=8090  OUT=  MISSION=  SCENARIO=
##                   REPLAY=runs/...: replay this run on the page instead     READ_ONLY=1: without commands
##                   FRAMED_BY=http://127.0.0.1:8080: the page that may show it in a frame
##   make report     write the report of a run again, with its film and charts      OUT=runs/latest
##   make compile-commands   write build/compile_commands.json, which clangd and other tools read
##   make format     format all C and JavaScript sources in place
##   make doctor     show what is installed, what is missing, and the next step
##   make setup      install all that any target needs (each target installs its own needs by itself)
##   make clean      remove build/ except the Python environment and fetched files; ALL=1 removes these, too

SHELL         := /bin/sh
.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules
JOBS ?= 2
OPTIONS := ALL ANALYZE APID BASE BOARD BUS CANS CC CHECK CMD COUNT COVERAGE DELAY FLY FORM FRAMED_BY FUZZ HOURS HTTP \
           JOBS JOYSTICK_IF KEY LINKS LONG MEMORY MISSION NAME NODES ONLY OUT PORT READ_ONLY REMOTE_ENDIAN \
           REPLAY ROBOT_IF RTOS S390X SANITIZE SCENARIO SECONDS SEED SIM_JOYSTICK_IF SIM_ROBOT_IF START STATION \
           STORAGE TEST_ENVIRONMENT TIME TOOL TOOLS TRANSPORT TSAN UPDATE URDF V WITH WORLD
ifeq ($(MAKELEVEL),0)
$(foreach v,$(filter-out $(OPTIONS),$(.VARIABLES)),$(if $(findstring command line,$(origin $v)),\
    $(error $v=$($v): there is no such option; there are: $(OPTIONS): see make help)))
$(if $(filter-out vm kernel,$(TEST_ENVIRONMENT)),$(error TEST_ENVIRONMENT=$(TEST_ENVIRONMENT): expected vm or kernel))
.NOTPARALLEL: # `make check test` runs one target after the other; the work of each runs in parallel.
endif
# If another make with parallel jobs has started this one, both share these jobs.
PARALLEL = +$(if $(V),,@)$(MAKE) --no-print-directory $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(JOBS))
Q        := $(if $(V),,@)
PYTHON   := /usr/bin/python3
export PYTHONPYCACHEPREFIX := $(CURDIR)/build/pycache
unexport PYTHONDONTWRITEBYTECODE # Otherwise each start of Python compiles its library again.
VENV     := build/venv/bin/python

# The order matters: variables and rules use earlier ones.
# The programs and the station need no rules of tests and checks. Reading these rules takes most of the time of a
# `make` that finds everything built.
include mk/compiler.mk mk/libraries.mk mk/generated.mk mk/programs.mk mk/setup.mk mk/run.mk mk/station.mk
ifneq ($(filter-out all programs gse,$(or $(MAKECMDGOALS),all)),)
include mk/tests.mk mk/fuzz.mk mk/check.mk mk/coverage.mk mk/proofs.mk mk/mcdc.mk
endif

.PHONY: force all help programs tests test-setup thread-tests kernel-tests remote-endian remote-endian-programs \
        remote-endian-tests board-tests benches fuzzers kept-inputs fuzz fuzz-corpus sim-run report vm test test-hil \
        check check-full bench board-programs doctor setup clean gse format new-subsystem new-robot docs
help:
	@sed -n 's/^## \{0,1\}//p' $(firstword $(MAKEFILE_LIST))

clean:
	rm -rf $(if $(ALL),build,$(filter-out build/venv build/third_party build/setup build/vm,$(wildcard build/*)))
