// SPDX-License-Identifier: Apache-2.0
#include "pus/st17/st17_test.h"

#include "base/assertion.h"
#include "generated/pus/st17_request_formats.h"

enum {
    ALIVE     = 2,
    CONNECTED = 4
};

void pus_test_init(pus_test_t* const test, const pus_test_port_t* const port)
{
    FSW_ASSERT((test != NULL) && ((port == NULL) || (port->connect != NULL)));
    *test = (pus_test_t){0};
    if (port != NULL) {
        test->port = *port;
    }
}

static pus_reply_t answer_alive(void* const self, pus_request_t* const request)
{
    (void)self;
    pus_request_perform(request);
    octet_writer_t writer = pus_answer_begin(request, ALIVE);
    (void)pus_tm_post(request->process, &writer); // The process counts lost reports.
    return pus_done();
}

status_t pus_test_connected(pus_app_process_t* const process, const pus_token_t* const token,
                            const uint16_t apid, const uint64_t now_ns)
{
    FSW_ASSERT((process != NULL) && (token != NULL));
    octet_writer_t writer = pus_tm_begin(process, PUS_SERVICE_TEST, CONNECTED, token->source, now_ns);
    octet_write_u16(&writer, apid);
    return pus_tm_post(process, &writer);
}

static pus_reply_t connect(void* const self, pus_request_t* const request)
{
    const pus_test_t* const test = self;
    const uint16_t apid          = octet_read_u16(&request->reader);
    const pus_reply_t reply = test->port.connect(test->port.context, apid, &request->token, request->now_ns);
    if (reply.kind == PUS_DONE) {
        pus_request_perform(request);
        (void)pus_test_connected(request->process, &request->token, apid, request->now_ns);
    }
    return reply;
}

pus_service_t pus_test_service(pus_test_t* const test)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(17, 1, answer_alive),
        PUS_REQUEST(17, 3, connect),
    };
    return pus_service_of(PUS_SERVICE_TEST, subtypes, (test->port.connect != NULL) ? 2U : 1U, test);
}
