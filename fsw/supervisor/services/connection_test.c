// SPDX-License-Identifier: Apache-2.0
// Connects the on-board connection test of ST[17] to the supervisor: sends TC[17,1] to the other application
// and waits for its answer.
#include "fsw/supervisor/services/spacecraft_services.h"

#include "fsw/supervisor/supervisor_internal.h"
#include "pus/st01/st01_verification.h"

#define ALIVE_REPORT 2U
#define MILLISECOND_NS 1000000U

/// Begin an on-board connection test (TC[17,3]); the answer of the other application ends it.
static pus_reply_t connect(void* const context, const uint16_t apid, const pus_token_t* const token,
                           const uint64_t now_ns)
{
    supervisor_t* const supervisor      = context;
    spacecraft_connection_t* const list = supervisor->spacecraft.connections.tests;
    spacecraft_connection_t* slot       = NULL;
    if (apid == SUPERVISOR_APID) {
        return pus_done();
    }
    if (supervisor_registry_find(supervisor, apid) == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, apid);
    }
    for (size_t i = 0U; (i < SPACECRAFT_CONNECTIONS) && (slot == NULL); i++) {
        slot = list[i].is_used ? NULL : &list[i];
    }
    if (slot == NULL) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, SPACECRAFT_CONNECTIONS);
    }
    octet_writer_t writer =
        pus_tc_begin(&supervisor->requester, apid, PUS_SERVICE_TEST, PUS_TEST_ARE_YOU_ALIVE, 0U);
    if (pus_tc_send(&supervisor->requester, &writer, NULL) != STATUS_OK) {
        return pus_failed(PUS_FAILURE_UNAVAILABLE, apid);
    }
    *slot = (spacecraft_connection_t){.is_used     = true,
                                      .apid        = apid,
                                      .deadline_ns = now_ns + SPACECRAFT_CONNECTION_TIMEOUT_NS,
                                      .token       = *token};
    return pus_later();
}

static pus_service_t open_connection(supervisor_t* const supervisor)
{
    const pus_test_port_t port = {.context = supervisor, .connect = connect};
    pus_test_init(&supervisor->spacecraft.connections.service, &port);
    return pus_test_service(&supervisor->spacecraft.connections.service);
}

static void observe_connection(supervisor_t* const supervisor, const pus_tm_t* const tm,
                               const uint8_t* const packet, const size_t size)
{
    (void)packet;
    (void)size;
    if ((tm->service != PUS_SERVICE_TEST) || (tm->subtype != ALIVE_REPORT) ||
        (tm->destination != PUS_USER_SUPERVISOR)) {
        return;
    }
    // One report answers all tests of its application.
    for (size_t i = 0U; i < SPACECRAFT_CONNECTIONS; i++) {
        spacecraft_connection_t* const test = &supervisor->spacecraft.connections.tests[i];
        test->is_answered                   = test->is_answered || (test->apid == tm->apid);
    }
}

static uint64_t step_connection(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_app_process_t* const process = subsystem_process(&supervisor->subsystem);
    const pus_failure_t late =
        pus_failure(PUS_FAILURE_TIMEOUT, (uint32_t)(SPACECRAFT_CONNECTION_TIMEOUT_NS / MILLISECOND_NS));
    uint64_t wake_ns = SPACECRAFT_NEVER;
    for (size_t i = 0U; i < SPACECRAFT_CONNECTIONS; i++) {
        spacecraft_connection_t* const test = &supervisor->spacecraft.connections.tests[i];
        if (!test->is_used) {
            test->is_answered = false;
        } else if (test->is_answered) {
            test->is_used = false;
            (void)pus_test_connected(process, &test->token, test->apid, now_ns);
            pus_verify_completed(process, &test->token, now_ns);
        } else if (now_ns >= test->deadline_ns) {
            test->is_used = false;
            pus_verify_failed(process, &test->token, &late, now_ns);
        } else {
            wake_ns = (test->deadline_ns < wake_ns) ? test->deadline_ns : wake_ns;
        }
    }
    return wake_ns;
}

const spacecraft_binding_t spacecraft_connection = {.type    = PUS_SERVICE_TEST,
                                                    .open    = open_connection,
                                                    .step    = step_connection,
                                                    .observe = observe_connection};
