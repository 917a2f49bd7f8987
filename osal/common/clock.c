// SPDX-License-Identifier: Apache-2.0
// The part of a clock that is the same on every operating system.
#include "osal/include/osal/clock.h"

#include "base/assertion.h"

#include <stddef.h>

void osal_clock_open_stepped(osal_clock_t* const clock, osal_lockstep_t* const scheduler,
                             const unsigned participant, const uint32_t life)
{
    FSW_ASSERT((clock != NULL) && (scheduler != NULL) && (participant < OSAL_LOCKSTEP_PARTICIPANTS_MAX));
    *clock = (osal_clock_t){
        .mode = OSAL_CLOCK_STEPPED, .scheduler = scheduler, .participant = participant, .life = life};
}

void osal_clock_open_granted(osal_clock_t* const clock, osal_deliveries_t* const deliveries)
{
    FSW_ASSERT((clock != NULL) && (deliveries != NULL));
    *clock      = (osal_clock_t){.mode = OSAL_CLOCK_STEPPED, .deliveries = deliveries};
    *deliveries = (osal_deliveries_t){.messages = {0U}};
}

void osal_clock_take_grant(osal_clock_t* const clock, const osal_grant_t* const grant)
{
    FSW_ASSERT((clock != NULL) && (grant != NULL) && (clock->deliveries != NULL));
    clock->grant       = *grant;
    *clock->deliveries = (osal_deliveries_t){.messages = {0U}};
}

uint64_t osal_clock_now_ns(const osal_clock_t* const clock)
{
    FSW_ASSERT(clock != NULL);
    if (clock->mode == OSAL_CLOCK_STEPPED) {
        return clock->grant.now_ns;
    }
    const uint64_t now_ns = osal_clock_monotonic_ns();
    return (now_ns > clock->origin_ns) ? (now_ns - clock->origin_ns) : 0U;
}

static void add_saturating(uint32_t* const sum, const uint32_t more)
{
    *sum = (more < (UINT32_MAX - *sum)) ? (*sum + more) : UINT32_MAX;
}

void osal_clock_deliver(osal_clock_t* const clock, const unsigned receiver, const uint32_t life,
                        const uint32_t messages, const uint32_t octets)
{
    FSW_ASSERT((clock != NULL) && (receiver < OSAL_LOCKSTEP_PARTICIPANTS_MAX));
    if (clock->deliveries != NULL) {
        clock->deliveries->lives[receiver] = life;
        add_saturating(&clock->deliveries->messages[receiver], messages);
        add_saturating(&clock->deliveries->octets[receiver], octets);
    } else if (clock->mode == OSAL_CLOCK_STEPPED) {
        osal_lockstep_deliver(clock->scheduler, clock->participant, receiver, life, messages, octets);
    } else {
        // In real time, deliveries are not counted.
    }
}

uint32_t osal_clock_messages_due(const osal_clock_t* const clock)
{
    FSW_ASSERT(clock != NULL);
    return clock->grant.messages;
}

uint32_t osal_clock_octets_due(const osal_clock_t* const clock)
{
    FSW_ASSERT(clock != NULL);
    return clock->grant.octets;
}
