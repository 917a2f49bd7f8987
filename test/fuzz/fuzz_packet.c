// SPDX-License-Identifier: Apache-2.0
// A space packet that is accepted and encoded again has the same octets. A report of services 1, 129 and 130
// that can be read and is written again has the same source data; its reader ends on the last octet.
#include "base/octets.h"
#include "pus/core/packet.h"
#include "pus/st01/st01_verification.h"
#include "pus/private/st129_management.h"
#include "pus/private/st130_rtlink.h"
#include "test/fuzz/fuzz.h"

#include <string.h>

static struct { // The last report sent.
    uint8_t octets[PUS_PACKET_MAX];
    size_t size;
} sent;

static pus_app_process_t process;

static status_t keep(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    FUZZ_CHECK(size <= sizeof sent.octets);
    (void)memcpy(sent.octets, packet, size);
    sent.size = size;
    return STATUS_OK;
}

/// Expect these source data in the last report.
static void expect_data(const pus_tm_t* const tm)
{
    pus_tm_t again;
    pus_failure_t failure;
    FUZZ_CHECK(pus_tm_decode(sent.octets, sent.size, &again, &failure) == STATUS_OK);
    FUZZ_CHECK((again.service == tm->service) && (again.subtype == tm->subtype));
    FUZZ_CHECK((again.size == tm->size) && (memcmp(again.data, tm->data, tm->size) == 0));
}

static void read_management(const pus_tm_t* const tm)
{
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    pus_transition_t transition;
    pus_subsystem_status_t status;
    if ((tm->subtype == PUS_MANAGEMENT_TRANSITION) &&
        (pus_transition_read(&reader, &transition) == STATUS_OK)) {
        (void)pus_transition_report(&process, &transition, 0U);
        expect_data(tm);
    } else if ((tm->subtype == PUS_MANAGEMENT_STATUS) &&
               (pus_subsystem_status_read(&reader, &status) == STATUS_OK)) {
        (void)pus_subsystem_status_report(&process, 1U, &status, 0U);
        expect_data(tm);
    } else {
        // There is no reader for this report.
    }
}

static void read_link_statuses(const uint8_t subtype, octet_reader_t reader)
{
    uint16_t count = 0U;
    if ((subtype == PUS_LINK_STATUS) && (pus_link_statuses_read(&reader, &count) == STATUS_OK)) {
        pus_link_status_t status;
        for (uint16_t i = 0U; i < count; i++) {
            pus_link_status_read(&reader, &status);
        }
        FUZZ_CHECK(octet_reader_is_done(&reader));
    }
}

static void read_link(const pus_tm_t* const tm)
{
    octet_reader_t reader = octet_reader(tm->data, tm->size);
    pus_link_accept_t accept;
    pus_link_refuse_t refuse;
    pus_link_transition_t transition;
    read_link_statuses(tm->subtype, reader);
    if ((tm->subtype == PUS_LINK_ACCEPT) && (pus_link_accept_read(&reader, &accept) == STATUS_OK)) {
        (void)pus_link_accept_report(&process, 1U, &accept, 0U);
        expect_data(tm);
    } else if ((tm->subtype == PUS_LINK_REFUSE) && (pus_link_refuse_read(&reader, &refuse) == STATUS_OK)) {
        (void)pus_link_refuse_report(&process, 1U, &refuse, 0U);
        expect_data(tm);
    } else if ((tm->subtype == PUS_LINK_TRANSITION) &&
               (pus_link_transition_read(&reader, &transition) == STATUS_OK)) {
        (void)pus_link_transition_report(&process, &transition, 0U); // The mission's epoch is 1958.
        expect_data(tm);
    } else {
        // There is no reader for this report.
    }
}

static void read_report(const pus_tm_t* const tm)
{
    pus_verification_t verification;
    if (pus_verification_read(tm, &verification) == STATUS_OK) {
        FUZZ_CHECK((tm->service == PUS_SERVICE_VERIFICATION) && (verification.subtype == tm->subtype));
        FUZZ_CHECK(pus_verification_is_final(&verification) || (verification.subtype == 6U) ||
                   (verification.failure.code == 0U));
    }
    if (tm->service == PUS_SERVICE_MANAGEMENT) {
        read_management(tm);
    } else if (tm->service == PUS_SERVICE_RTLINK) {
        read_link(tm);
    } else {
        // There is no reader for this service.
    }
}

static void read_request(const pus_tc_t* const tc)
{
    static uint8_t octets[PUS_PACKET_MAX];
    octet_reader_t reader = octet_reader(tc->data, tc->size);
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    pus_link_request_t request;
    pus_link_open_t open;
    pus_link_close_t close;
    if ((tc->subtype == PUS_LINK_REQUEST) && (pus_link_request_read(&reader, &request) == STATUS_OK)) {
        pus_link_request_write(&writer, &request);
    } else if ((tc->subtype == PUS_LINK_OPEN) && (pus_link_open_read(&reader, &open) == STATUS_OK)) {
        pus_link_open_write(&writer, &open);
    } else if ((tc->subtype == PUS_LINK_CLOSE) && (pus_link_close_read(&reader, &close) == STATUS_OK)) {
        pus_link_close_write(&writer, &close);
    } else {
        return;
    }
    FUZZ_CHECK((writer.position == tc->size) && (memcmp(octets, tc->data, tc->size) == 0));
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    static const pus_port_t port = {NULL, keep};
    static uint8_t again[PUS_PACKET_MAX];
    size_t again_size = 0U;
    pus_failure_t failure;
    pus_tc_t tc;
    pus_tm_t tm;
    pus_app_process_init(&process, 1U, 0U, &port);

    size_t frame_size     = 0U;
    const status_t framed = pus_packet_frame(data, size, &frame_size);
    const status_t as_tc  = pus_tc_decode(data, size, &tc, &failure);
    FUZZ_CHECK((as_tc == STATUS_OK) == (failure.code == PUS_FAILURE_NONE));
    const status_t as_tm = pus_tm_decode(data, size, &tm, &failure);
    FUZZ_CHECK((as_tm == STATUS_OK) == (failure.code == PUS_FAILURE_NONE));
    FUZZ_CHECK((as_tc != STATUS_OK) || (as_tm != STATUS_OK));
    if (as_tc == STATUS_OK) {
        FUZZ_CHECK((framed == STATUS_OK) && (frame_size == size) && pus_packet_is_tc(data, size));
        FUZZ_CHECK(pus_tc_encode(&tc, again, sizeof again, &again_size) == STATUS_OK);
        FUZZ_CHECK((again_size == size) && (memcmp(again, data, size) == 0));
        read_request(&tc);
    }
    if (as_tm == STATUS_OK) {
        FUZZ_CHECK((framed == STATUS_OK) && (frame_size == size) && !pus_packet_is_tc(data, size));
        FUZZ_CHECK(pus_tm_encode(&tm, again, sizeof again, &again_size) == STATUS_OK);
        FUZZ_CHECK((again_size == size) && (memcmp(again, data, size) == 0));
        read_report(&tm);
    }
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_message(data, size, max_size, seed, fuzz_repair_packet);
}
