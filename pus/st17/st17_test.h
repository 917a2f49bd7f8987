// SPDX-License-Identifier: Apache-2.0
/// ST[17] test: TM[17,2] answers TC[17,1], are-you-alive. TM[17,4] {APID u16} answers TC[17,3] {APID u16},
/// the on-board connection test, which is only available with a port.
#ifndef PUS_ST17_ST17_TEST_H
#define PUS_ST17_ST17_TEST_H

#include "pus/core/service.h"

#define PUS_TEST_ARE_YOU_ALIVE 1U ///< Subtype of the request that is answered at once.

typedef struct {
    void* context;
    /// Begin a connection test with `apid`. PUS_LATER: the port ends the test later with pus_test_connected
    /// and pus_verify_completed, or with pus_verify_failed. PUS_DONE: the connection exists; the service
    /// sends the report.
    pus_reply_t (*connect)(void* context, uint16_t apid, const pus_token_t* token, uint64_t now_ns);
} pus_test_port_t;

typedef struct { // Private.
    pus_test_port_t port;
} pus_test_t;

/// If `port` is null, there is no connection test, and TC[17,3] is an unknown subtype.
void pus_test_init(pus_test_t* test, const pus_test_port_t* port);
pus_service_t pus_test_service(pus_test_t* test);
/// Send TM[17,4] to the request's source. Status of pus_tm_post.
status_t pus_test_connected(pus_app_process_t* process, const pus_token_t* token, uint16_t apid,
                            uint64_t now_ns);

#endif // PUS_ST17_ST17_TEST_H
