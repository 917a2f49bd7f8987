// SPDX-License-Identifier: Apache-2.0
#include "pus/tool/pusdump_messages.h"

#include "generated/pus/message_titles.h"

const char* message_name(const uint8_t service, const uint8_t subtype)
{
    size_t low  = 0U;
    size_t high = sizeof pus_message_titles / sizeof pus_message_titles[0];
    while (low < high) {
        const size_t middle = low + ((high - low) / 2U);
        const int here      = (pus_message_titles[middle].service * 256) + pus_message_titles[middle].subtype;
        const int wanted    = (service * 256) + subtype;
        if (here == wanted) {
            return pus_message_titles[middle].title;
        }
        low  = (here < wanted) ? (middle + 1U) : low;
        high = (here < wanted) ? high : middle;
    }
    return (service >= 128U) || (subtype >= 128U) ? "mission message" : "unknown message";
}
