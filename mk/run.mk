# SPDX-License-Identifier: Apache-2.0
# Flights and other targets for users.

# Pass on only options of the command line, not variables of the environment. The launcher has the defaults and
# refuses invalid values.
option = $(if $(filter command%,$(origin $2)),$(if $($2),--$1 '$($2)'))
adapter = $(if $(filter command%,$(origin $3)),$(if $($3),--$1 '$2=$($3)'))
# The boards of RTOS=SUBSYSTEM[:BOARD],...; the default board is mps2-an500.
rtos_boards = $(if $(findstring mps2-an385,$(RTOS)),rtos-mps2-an385) \
              $(if $(filter-out %:mps2-an385,$(subst $(comma), ,$(RTOS))),rtos-mps2-an500)
# The report takes film and charts from the code of the web page. If the packages of the page cannot be installed, the
# mission flies, and its report has neither.
sim-run: build/setup/run all $(if $(REMOTE_ENDIAN),remote-endian) $(if $(RTOS),$(rtos_boards))
	@$(MAKE) --no-print-directory -s build/station/page/index.html || \
	    echo 'sim-run: the report will have no film and no charts'
	@build/bin/hirosco run $(call option,mission,MISSION) $(call option,scenario,SCENARIO) $(call option,world,WORLD) \
	    $(call option,seed,SEED) \
	    $(call option,form,FORM) $(call option,time,TIME) $(call option,bus,BUS) \
	    $(call option,transport,TRANSPORT) $(call option,nodes,NODES) $(call option,links,LINKS) \
	    $(call option,delay,DELAY) $(call option,port,PORT) $(call option,tools,TOOLS) $(call option,out,OUT) \
	    $(call option,storage,STORAGE) $(call option,key,KEY) $(call option,remote-endian,REMOTE_ENDIAN) \
	    $(call option,rtos,RTOS) \
	    $(call adapter,interface,robot,ROBOT_IF) $(call adapter,interface,joystick,JOYSTICK_IF) \
	    $(call adapter,sim-interface,robot,SIM_ROBOT_IF) $(call adapter,sim-interface,joystick,SIM_JOYSTICK_IF)

report: build/setup/station build/station/page/index.html $(GENERATED)
	@build/venv/bin/python -m hirosco_gse.report $(or $(OUT),runs/latest) && echo '$(or $(OUT),runs/latest)/report.html'

build/vm/initramfs.cpio: build/setup/hil gse/vm/prepare.py gse/vm/init.sh
	@$(PYTHON) gse/vm/prepare.py && touch $@
build/setup/vm: build/vm/initramfs.cpio
	@touch $@
# $(value CMD) passes the command on unchanged: make does not expand its dollar signs.
vm: export VM_COMMAND := $(value CMD)
vm: build/setup/vm
	@$(PYTHON) gse/vm/microvm.py $(call option,seconds,SECONDS) $(call option,cans,CANS) $(call option,memory,MEMORY) \
	    $(call option,out,OUT)

# If no flight is running, the station starts one with TIME=real.
gse: build/setup/station build/station/page/index.html all
	@echo 'The command line is build/venv/bin/gse --help'
	@build/venv/bin/python -m hirosco_gse.station $(call option,http-port,HTTP) $(call option,run,OUT) \
	    $(call option,replay,REPLAY) $(if $(READ_ONLY),--read-only) $(call option,framed-by,FRAMED_BY) \
	    --fly build/bin/hirosco run --time real $(call option,mission,MISSION) $(call option,scenario,SCENARIO) \
	    $(call option,world,WORLD) $(call option,seed,SEED) $(call option,port,PORT) $(call option,out,OUT) \
	    $(call option,key,KEY)

.PHONY: yamcs
yamcs: build/setup/full $(GENERATED)
	@$(PYTHON) gse/yamcs/run.py $(call option,mission,MISSION) $(call option,ground-port,PORT) \
	    $(call option,http-port,HTTP) $(call option,station,STATION) $(call option,out,OUT)

new-subsystem:
	@$(PYTHON) gse/scaffold/new_subsystem.py $(call option,name,NAME) $(call option,apid,APID) \
	    $(call option,mission,MISSION)

# The simulator checks the new world.
new-robot: build/bin/simulator
	@$(PYTHON) gse/scaffold/new_robot.py $(call option,urdf,URDF) $(call option,name,NAME) $(call option,tool,TOOL) \
	    $(if $(START),--start='$(START)') $(call option,apid,APID) $(call option,base,BASE) $(call option,with,WITH)

docs: build/setup/docs
	@$(PYTHON) gse/docs/make_docs.py --out build/docs
