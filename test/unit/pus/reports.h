// SPDX-License-Identifier: Apache-2.0
/// A process of APID 16 whose reports are kept for inspection, and a ground that sends it requests.
#ifndef TEST_UNIT_PUS_REPORTS_H
#define TEST_UNIT_PUS_REPORTS_H

#include "pus/service.h"

#define TEST_APID 16U
#define TEST_SOURCE 7U
#define TEST_EPOCH_S 2000000000U
#define TEST_NOW_NS 1500000000ULL
#define REPORTS_MAX 600U

/// The process under test, its port and what came out of it.
typedef struct {
    pus_process_t process;
    pus_rings_t rings;
    pus_dispatcher_t dispatcher;
    pus_service_t services[1];
    uint8_t ack;         ///< Of requests sent from now on; PUS_ACK_ALL after a reset.
    uint16_t source;     ///< Of requests sent from now on; TEST_SOURCE after a reset.
    uint16_t sequence;   ///< Of the next request.
    uint32_t request_id; ///< Of the last request.
    unsigned refusals;   ///< Packets the port refuses from now on.
    size_t accepts;      ///< The port refuses all when it has so many reports; 0: no limit.
    size_t count;        ///< Reports sent.
    size_t sizes[REPORTS_MAX];
    uint8_t packets[REPORTS_MAX][PUS_PACKET_MAX];
} bench_t;

extern bench_t bench;

/// Port that keeps what is sent in the bench.
pus_port_t bench_port(void);
/// Forget everything and start the process and a dispatcher with one service.
void bench_start(void);
void bench_serve(pus_service_t service);
/// Forget the reports sent so far.
void bench_clear(void);

/// Send a request of the bench's service to the dispatcher.
status_t bench_request(uint8_t subtype, const void* data, size_t size);
/// The same with a request that may be longer than a packet.
status_t bench_request_large(uint8_t subtype, const void* data, size_t size);
/// Decoded report number `index`, which must be well-formed.
pus_tm_t bench_report(size_t index);
/// Source data of report `index` as a reader.
octet_reader_t bench_data(size_t index);

/// The reports since the last clear are exactly these messages: pairs of service and subtype, ended by 0.
void expect_messages(const uint8_t* pairs);
#define EXPECT_MESSAGES(...) expect_messages((const uint8_t[]){__VA_ARGS__, 0})
/// Report `index` is TM[1,subtype] of the last request with this failure notice.
void expect_failure(size_t index, uint8_t subtype, uint16_t code, uint16_t instruction, uint32_t detail);
/// The request is rejected with PUS_FAILURE_DATA when cut at any length, and with one octet too many.
void expect_strict_shape(uint8_t subtype, const void* data, size_t size);

#endif // TEST_UNIT_PUS_REPORTS_H
