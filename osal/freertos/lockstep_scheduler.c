// SPDX-License-Identifier: Apache-2.0
// The scheduler of stepped time is in memory that processes share, which this system does not have. A program
// of this port takes part through a granted clock (osal/clock.h); a call of any of these functions is a
// coding error.
#include "osal/include/osal/lockstep_scheduler.h"

#include "base/assertion.h"

#include <stddef.h>

static __attribute__((noreturn)) void no_scheduler(void)
{
    fsw_assertion_failed(__FILE__, __LINE__);
}

osal_lockstep_t* osal_lockstep_create(void* const storage, const uint64_t step_ns, const bool is_shared)
{
    FSW_ASSERT(storage != NULL);
    (void)step_ns;
    (void)is_shared;
    return NULL;
}

void osal_lockstep_set_patience(osal_lockstep_t* const scheduler, const uint64_t patience_ns)
{
    (void)scheduler;
    (void)patience_ns;
    no_scheduler();
}

osal_lockstep_t* osal_lockstep_attach(void* const storage)
{
    FSW_ASSERT(storage != NULL);
    return NULL;
}

void osal_lockstep_expect(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life,
                          const uint64_t at_ns)
{
    (void)scheduler;
    (void)participant;
    (void)life;
    (void)at_ns;
    no_scheduler();
}

void osal_lockstep_end(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life)
{
    (void)scheduler;
    (void)participant;
    (void)life;
    no_scheduler();
}

void osal_lockstep_dismiss(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life)
{
    (void)scheduler;
    (void)participant;
    (void)life;
    no_scheduler();
}

void osal_lockstep_kill(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life)
{
    (void)scheduler;
    (void)participant;
    (void)life;
    no_scheduler();
}

void osal_lockstep_set_succession(osal_lockstep_t* const scheduler, const unsigned participant,
                                  const uint64_t delay_ns)
{
    (void)scheduler;
    (void)participant;
    (void)delay_ns;
    no_scheduler();
}

void osal_lockstep_suspend(osal_lockstep_t* const scheduler, const unsigned participant)
{
    (void)scheduler;
    (void)participant;
    no_scheduler();
}

void osal_lockstep_resume(osal_lockstep_t* const scheduler, const unsigned participant)
{
    (void)scheduler;
    (void)participant;
    no_scheduler();
}

void osal_lockstep_close(osal_lockstep_t* const scheduler)
{
    (void)scheduler;
    no_scheduler();
}

bool osal_lockstep_is_closed(const osal_lockstep_t* const scheduler)
{
    (void)scheduler;
    no_scheduler();
}

status_t osal_lockstep_wait(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life,
                            const uint64_t wake_ns, osal_grant_t* const out_grant)
{
    (void)scheduler;
    (void)participant;
    (void)life;
    (void)wake_ns;
    (void)out_grant;
    no_scheduler();
}

void osal_lockstep_done(osal_lockstep_t* const scheduler, const unsigned participant, const uint64_t wake_ns)
{
    (void)scheduler;
    (void)participant;
    (void)wake_ns;
    no_scheduler();
}

status_t osal_lockstep_next(osal_lockstep_t* const scheduler, unsigned* const out_participant,
                            osal_grant_t* const out_grant)
{
    (void)scheduler;
    (void)out_participant;
    (void)out_grant;
    no_scheduler();
}

void osal_lockstep_deliver(osal_lockstep_t* const scheduler, const unsigned sender, const unsigned receiver,
                           const uint32_t life, const uint32_t messages, const uint32_t octets)
{
    (void)scheduler;
    (void)sender;
    (void)receiver;
    (void)life;
    (void)messages;
    (void)octets;
    no_scheduler();
}

uint64_t osal_lockstep_now_ns(const osal_lockstep_t* const scheduler)
{
    (void)scheduler;
    no_scheduler();
}

osal_lockstep_presence_t osal_lockstep_presence(const osal_lockstep_t* const scheduler,
                                                const unsigned participant, uint32_t* const out_life)
{
    (void)scheduler;
    (void)participant;
    (void)out_life;
    no_scheduler();
}

uint64_t osal_lockstep_begin_ns(osal_lockstep_t* const scheduler, const unsigned participant)
{
    (void)scheduler;
    (void)participant;
    no_scheduler();
}

bool osal_lockstep_is_present(const osal_lockstep_t* const scheduler, const unsigned participant)
{
    (void)scheduler;
    (void)participant;
    no_scheduler();
}

unsigned osal_lockstep_awaited(const osal_lockstep_t* const scheduler)
{
    (void)scheduler;
    no_scheduler();
}

void osal_lockstep_postpone(osal_lockstep_t* const scheduler, const unsigned participant, const uint32_t life,
                            const uint64_t at_ns)
{
    (void)scheduler;
    (void)participant;
    (void)life;
    (void)at_ns;
    no_scheduler();
}

unsigned osal_lockstep_holder(osal_lockstep_t* const scheduler, uint32_t* const out_grants)
{
    (void)scheduler;
    (void)out_grants;
    no_scheduler();
}

void osal_lockstep_hold(osal_lockstep_t* const scheduler, const bool is_held)
{
    (void)scheduler;
    (void)is_held;
    no_scheduler();
}

bool osal_lockstep_is_held(const osal_lockstep_t* const scheduler)
{
    (void)scheduler;
    no_scheduler();
}

void osal_lockstep_set_stream_port(osal_lockstep_t* const scheduler, const unsigned participant,
                                   const uint16_t port)
{
    (void)scheduler;
    (void)participant;
    (void)port;
    no_scheduler();
}

uint16_t osal_lockstep_stream_port(const osal_lockstep_t* const scheduler, const unsigned participant)
{
    (void)scheduler;
    (void)participant;
    no_scheduler();
}

void osal_lockstep_serve_stream(osal_lockstep_t* const scheduler, const unsigned participant,
                                const uint16_t port, const unsigned server)
{
    (void)scheduler;
    (void)participant;
    (void)port;
    (void)server;
    no_scheduler();
}

void osal_lockstep_cut_stream(osal_lockstep_t* const scheduler, const unsigned participant,
                              const uint16_t port)
{
    (void)scheduler;
    (void)participant;
    (void)port;
    no_scheduler();
}

uint16_t osal_lockstep_served_port(const osal_lockstep_t* const scheduler, const unsigned participant)
{
    (void)scheduler;
    (void)participant;
    no_scheduler();
}
