// SPDX-License-Identifier: Apache-2.0
#include "test/fuzz/can_records.h"

#include <string.h>

#define CLASSIC_OCTETS 8U
#define FIRST_NODE 0x11U // Of the two nodes of the fuzzed descriptors.

osal_can_frame_t fuzz_can_frame(const fuzz_record_t* const record)
{
    osal_can_frame_t frame = {.id = 0U};
    if (record->size < CAN_RECORD_HEADER) {
        return frame;
    }
    const bool is_fd    = ((record->argument & 8U) != 0U);
    const size_t limit  = is_fd ? OSAL_CAN_DATA_MAX : CLASSIC_OCTETS;
    const size_t octets = record->size - CAN_RECORD_HEADER;
    frame.id            = (uint32_t)(((unsigned)record->octets[0] << 8U) | record->octets[1]) & 0x7FFU;
    frame.id |= ((record->argument & 1U) != 0U) ? OSAL_CAN_EXTENDED : 0U;
    frame.id |= ((record->argument & 2U) != 0U) ? OSAL_CAN_REMOTE : 0U;
    frame.id |= ((record->argument & 4U) != 0U) ? OSAL_CAN_ERROR : 0U;
    frame.flags  = is_fd ? OSAL_CAN_FLAG_FD : 0U;
    frame.length = (uint8_t)((octets < limit) ? octets : limit);
    (void)memcpy(frame.data, &record->octets[CAN_RECORD_HEADER], frame.length);
    return frame;
}

void fuzz_repair_can(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    // NMT, EMCY, PDOs, SDO answers and requests (twice, since most depends on them) and heartbeat of CiA 301.
    static const uint16_t functions[] = {0x000U, 0x080U, 0x180U, 0x200U, 0x280U, 0x300U, 0x380U,
                                         0x400U, 0x580U, 0x580U, 0x600U, 0x600U, 0x700U};
    (void)kind;
    if (size < CAN_RECORD_HEADER) {
        return;
    }
    const uint32_t choice = fuzz_random(random);
    uint16_t identifier   = functions[choice % (sizeof functions / sizeof functions[0])];
    if (identifier != 0U) { // That of NMT has no node.
        identifier = (uint16_t)(identifier + FIRST_NODE + (fuzz_random(random) % 2U));
    }
    octets[0] = (uint8_t)(identifier >> 8U);
    octets[1] = (uint8_t)identifier;
}
