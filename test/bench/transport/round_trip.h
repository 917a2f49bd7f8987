// SPDX-License-Identifier: Apache-2.0
/// Round trips between two processes on two processors, the same for every transport.
///
/// A program per transport: its main calls round_trip_main with a transport_t. Process 0, on processor 0,
/// sends a payload that differs each time and checks every octet of the answer; process 1, on processor 1,
/// returns what it receives. Both run under SCHED_FIFO where permitted. The payload is copied in from, and
/// out to, a buffer of the user, also by transports that do not need the copies.
///
///     usage: <transport> poll|block <payload octets> <round trips>
///     prints: ROUND_TRIP <median ns> <99th percentile ns>
#ifndef TEST_BENCH_TRANSPORT_ROUND_TRIP_H
#define TEST_BENCH_TRANSPORT_ROUND_TRIP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define ROUND_TRIP_PAYLOAD_MAX 1024U

typedef struct {
    bool may_poll; ///< The transport can receive without waiting.
    /// Called before the processes are forked, for memory that both share; may be null.
    bool (*prepare)(size_t size);
    /// Called in each process (side 0 or 1) before the first payload. Returns false if the transport is not
    /// possible here.
    bool (*open)(unsigned side, size_t size, bool is_polled);
    void (*send)(const uint8_t* payload);
    void (*receive)(uint8_t* payload); ///< Waits for the next payload.
    void (*close)(void);               ///< May be null.
} transport_t;

int round_trip_main(int count, char** words, const transport_t* transport);
/// Memory that both processes share: for use in prepare.
void* round_trip_shared(size_t size);

#endif // TEST_BENCH_TRANSPORT_ROUND_TRIP_H
