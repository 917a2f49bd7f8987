# SPDX-License-Identifier: Apache-2.0
# The programs of test/bench/transport, one per transport, which bench_link.py runs alternately.
TRANSPORTS := lcm link_shm link_udp seqlock udp

transport_needs_lcm := -llcm

define transport_rule
$B/bench/transport/$1: $(call objects,test/bench/transport/$1.c test/bench/transport/round_trip.c) \
                       $(foreach d,osal/posix osal/common base fsw/framework/rtlink,$(call library,$d))
	@mkdir -p $$(@D)
	$(Q)$(CC) $(CFLAGS) -o $$@ $$(filter %.o,$$^) $$(call group,$$^) $(transport_needs_$1) -lpthread
endef
$(foreach t,$(TRANSPORTS),$(eval $(call transport_rule,$t)))
-include $(patsubst %.o,%.d,$(call objects,$(wildcard test/bench/transport/*.c)))
