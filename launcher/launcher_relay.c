// SPDX-License-Identifier: Apache-2.0
#include "launcher/launcher_relay.h"

#include "base/assertion.h"
#include "fsw/framework/rtlink/link_frame.h"

#define TIMEOUT_MS 100U
/// Number of waits for announced datagrams: 50 waits of 100 ms are five seconds of wall-clock time.
#define TRIES 50U

CAPACITY_CHECK(a_frame_fits, RELAY_FRAME_MAX >= LINK_FRAME_MAX);
CAPACITY_CHECK(every_link_is_relayed, RELAY_LINKS_MAX >= RUN_LINKS_MAX);

const char* launcher_relay_open(launcher_relay_t* const self, run_state_t* const run,
                                osal_lockstep_t* const scheduler)
{
    FSW_ASSERT((self != NULL) && (run != NULL) && (scheduler != NULL));
    const relay_law_t law = {.delay_ns = (uint64_t)run->relay.delay_us * 1000U,
                             .jitter   = LAUNCHER_RELAY_JITTER,
                             .loss     = LAUNCHER_RELAY_LOSS};
    self->run             = run;
    self->scheduler       = scheduler;
    self->sender          = (osal_socket_t)OSAL_SOCKET_CLOSED;
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        self->sockets[i] = (osal_socket_t)OSAL_SOCKET_CLOSED;
    }
    if ((run->relay.delay_us == 0U) || run->relay.is_network) {
        return NULL;
    }
    relay_init(&self->relay, run->relay.seed, &law);
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        if ((run->relay.descriptors[i] >= 0) &&
            (osal_socket_adopt(&self->sockets[i], run->relay.descriptors[i]) != STATUS_OK)) {
            return "the relay cannot take over its sockets; start the mission again";
        }
    }
    const status_t status = osal_udp_open(&self->sender, (osal_address_t){run->computer_ipv4[0], 0U}, 0U);
    return (status == STATUS_OK) ? NULL : "the relay cannot open a socket to send; raise `ulimit -n`";
}

/// Receive from a socket until it is empty. Returns the number of datagrams received.
static uint32_t receive_link(launcher_relay_t* const self, const unsigned link, const uint64_t now_ns)
{
    uint8_t frame[LINK_FRAME_MAX];
    osal_address_t from = {0U, 0U};
    uint32_t taken      = 0U;
    size_t size         = 0U;
    while (osal_udp_receive(&self->sockets[link], &from, frame, sizeof frame, &size) == STATUS_OK) {
        relay_take(&self->relay, link, frame, size, now_ns);
        taken++;
    }
    return taken;
}

static uint32_t receive_all(launcher_relay_t* const self, const uint64_t now_ns)
{
    uint32_t taken = 0U;
    for (unsigned link = 0U; link < RUN_LINKS_MAX; link++) {
        taken += osal_socket_is_open(&self->sockets[link]) ? receive_link(self, link, now_ns) : 0U;
    }
    return taken;
}

/// Wait until a frame of a producer can be read; at most TIMEOUT_MS, which the open sockets share equally.
static void wait_for_frame(launcher_relay_t* const self)
{
    uint32_t open = 0U;
    for (unsigned link = 0U; link < RUN_LINKS_MAX; link++) {
        open += osal_socket_is_open(&self->sockets[link]) ? 1U : 0U;
    }
    for (unsigned link = 0U; link < RUN_LINKS_MAX; link++) {
        if (osal_socket_is_open(&self->sockets[link]) &&
            (osal_socket_wait_readable(&self->sockets[link], TIMEOUT_MS / open) == STATUS_OK)) {
            break;
        }
    }
}

/// Receive all frames that the producers have announced. The random numbers of the links are independent, so
/// the order in which the kernel delivers frames of different links has no effect.
static void take_announced(launcher_relay_t* const self, const osal_grant_t* const grant)
{
    uint32_t taken = receive_all(self, grant->now_ns);
    for (unsigned i = 0U; (taken < grant->messages) && (i < TRIES); i++) {
        wait_for_frame(self);
        taken += receive_all(self, grant->now_ns);
    }
    if (taken < grant->messages) {
        __atomic_store_n(&self->run->is_lossy, 1U, __ATOMIC_RELAXED);
    }
}

/// Send a frame to its consumer and announce it. A frame whose epoch the present life of the consumer refuses
/// is dropped.
static void pass_on(launcher_relay_t* const self, const relay_frame_t* const frame)
{
    const unsigned component         = self->run->relay.consumers[frame->link];
    const run_component_t* const one = &self->run->components[component];
    const uint32_t life              = __atomic_load_n(&one->life, __ATOMIC_ACQUIRE);
    const uint32_t floor             = __atomic_load_n(&one->link_floor, __ATOMIC_RELAXED);
    const osal_address_t to = {self->run->computer_ipv4[one->computer], self->run->link_ports[frame->link]};
    if ((rtlink_frame_epoch(frame->octets, frame->size) > floor) &&
        (osal_udp_send(&self->sender, to, frame->octets, frame->size) == STATUS_OK)) {
        osal_lockstep_deliver(self->scheduler, run_relay(self->run), run_participant(component), life, 1U,
                              0U);
    }
}

uint64_t launcher_relay_step(launcher_relay_t* const self, const osal_grant_t* const grant)
{
    FSW_ASSERT((self != NULL) && (grant != NULL));
    run_relay_t* const published = &self->run->relay;
    take_announced(self, grant);
    // The relay runs last in a time step, so consumers receive the frames in the next step. Therefore the
    // relay sends a frame one step before the frame is due for its consumer.
    const uint64_t read_ns = grant->now_ns + RUN_STEP_NS;
    for (const relay_frame_t* frame = relay_give(&self->relay, read_ns); frame != NULL;
         frame                      = relay_give(&self->relay, read_ns)) {
        pass_on(self, frame);
    }
    published->delayed     = self->relay.counters.delayed;
    published->lost        = self->relay.counters.lost;
    published->reordered   = self->relay.counters.reordered;
    const uint64_t next_ns = relay_next_ns(&self->relay);
    return (next_ns == RELAY_NEVER) ? OSAL_LOCKSTEP_NEVER : (next_ns - RUN_STEP_NS);
}

void launcher_relay_close(launcher_relay_t* const self)
{
    FSW_ASSERT(self != NULL);
    for (size_t i = 0U; i < RUN_LINKS_MAX; i++) {
        osal_socket_close(&self->sockets[i]);
    }
    osal_socket_close(&self->sender);
}
