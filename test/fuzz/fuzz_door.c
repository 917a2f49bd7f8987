// SPDX-License-Identifier: Apache-2.0
// The calendar's door: a client says anything, in pieces. It is inside only after it has joined in due form,
// and what it is let go for is counted once. Each record is what the client says before the door's next turn;
// kind 1 comes anew.
#include "sim/clock/door.h"
#include "test/fuzz/fuzz.h"
#include "test/fuzz/memory_socket.h"

#include <string.h>

static uint8_t storage[OSAL_CALENDAR_BYTES] __attribute__((aligned(64)));

static uint32_t gone(const door_t* const door)
{
    return door->count.left + door->count.vanished + door->count.malformed + door->count.silent;
}

static void turn(door_t* const door)
{
    const osal_grant_t grant = {1000U, 1U, 0U};
    const door_t before      = *door;
    uint64_t wake_ns         = 0U;
    uint32_t octets          = 0U;
    if (!osal_socket_is_open(&door->client)) {
        const bool is_inside = (door_accept(door, 0U) == STATUS_OK);
        FUZZ_CHECK(is_inside == osal_socket_is_open(&door->client));
        FUZZ_CHECK(door->count.joined == (before.count.joined + (is_inside ? 1U : 0U)));
        return;
    }
    const status_t status = door_exchange(door, &grant, 0U, &wake_ns, &octets);
    FUZZ_CHECK((status == STATUS_OK) || (status == STATUS_CLOSED));
    FUZZ_CHECK((status == STATUS_OK) == osal_socket_is_open(&door->client));
    FUZZ_CHECK(gone(door) == (gone(&before) + ((status == STATUS_OK) ? 0U : 1U)));
    FUZZ_CHECK(door->line_size <= DOOR_LINE_BYTES);
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    door_t door;
    osal_socket_t client = OSAL_SOCKET_CLOSED;
    fuzz_input_t input   = fuzz_input(data, size);
    fuzz_record_t record;
    memory_sockets_reset();
    osal_calendar_t* const calendar = osal_calendar_create(storage, 500000U, false);
    FUZZ_CHECK((calendar != NULL) && (door_open(&door, "door", "operator", calendar, 0U) == STATUS_OK));
    while (fuzz_next(&input, &record)) {
        size_t sent = 0U;
        if (((record.kind % 4U) == 1U) || !osal_socket_is_open(&client)) {
            osal_socket_close(&client);
            (void)!osal_local_connect(&client, "door");
        }
        (void)!osal_stream_send(&client, record.octets, record.size, &sent);
        turn(&door);
    }
    door_close(&door);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, NULL);
}
