# SPDX-License-Identifier: Apache-2.0
# Install the packages that a target needs: build/setup/<level> is a stamp file for each level of
# gse/setup/packages.txt.

build/setup/%: gse/setup/setup.sh gse/setup/python.sh gse/setup/unity.sh gse/setup/station.sh gse/setup/expat_s390x.sh \
               gse/setup/debian_source.sh gse/setup/expat_source.sh gse/setup/crate_source.sh gse/setup/freertos.sh \
               gse/setup/littlefs.sh gse/setup/cbmc.sh gse/setup/yamcs.sh gse/yamcs/pom.xml gse/setup/packages.txt \
               gse/page/package-lock.json gse/requirements.txt test/requirements.txt
	@sh gse/setup/setup.sh $*
setup: build/setup/full build/setup/vm
doctor:
	@sh gse/setup/doctor.sh

# Peers: software of other projects with which `make bench` compares this project.
build/setup/peers: gse/setup/peers.sh gse/setup/peers.txt $(shell find test/bench/peers -type f)
	@sh gse/setup/peers.sh
build/setup/peer-spacepackets: gse/setup/peers.sh $(shell find test/bench/peers/spacepackets -type f)
	@sh gse/setup/peers.sh spacepackets
