// SPDX-License-Identifier: Apache-2.0
#include "pus/tool/pusdump_messages.h"

#define FAILURE "code:code instruction:u16 detail:u32"
#define LISTS "parameters[8 id:x32 ] sets[8 repetitions:u16 parameters[8 id:x32 ] ]"
#define ENDS "producer:u16 producer_port:u16 consumer:u16 consumer_port:u16"
#define PROPERTIES                                                                                           \
    "layout_hash:x32 layout_size:u32 byte_order:u8 period_us:u32 tolerance_permille:u16 method:u8 depth:u8 " \
    "age_max_us:u32"
#define ENDPOINT "endpoint_kind:u8 endpoint:octets"

static const struct {
    uint8_t service;
    uint8_t subtype;
    const char* layout;
} layouts[] = {
    {1U, 1U, "request:id"},
    {1U, 2U, "request:id " FAILURE},
    {1U, 3U, "request:id"},
    {1U, 4U, "request:id " FAILURE},
    {1U, 5U, "request:id step:u16"},
    {1U, 6U, "request:id step:u16 " FAILURE},
    {1U, 7U, "request:id"},
    {1U, 8U, "request:id " FAILURE},
    {1U, 10U, "request:id " FAILURE},
    {3U, 1U, "structure:u16 interval:u32 " LISTS},
    {3U, 3U, "structures[8 structure:u16 ]"},
    {3U, 5U, "structures[8 structure:u16 ]"},
    {3U, 6U, "structures[8 structure:u16 ]"},
    {3U, 9U, "structures[8 structure:u16 ]"},
    {3U, 10U,
     "structure:u16 enabled:u8 interval:u32 parameters[16 id:x32 ] sets[16 repetitions:u16 parameters[16 "
     "id:x32 "
     "] ]"},
    {3U, 25U, "structure:u16 values:rest"},
    {3U, 27U, "structures[8 structure:u16 ]"},
    {3U, 29U, "structure:u16 " LISTS},
    {3U, 31U, "structures[8 structure:u16 interval:u32 ]"},
    {3U, 33U, "structures[8 structure:u16 ]"},
    {3U, 35U, "structures[16 structure:u16 enabled:u8 interval:u32 ]"},
    {5U, 1U, "event:u16 auxiliary:rest"},
    {5U, 2U, "event:u16 auxiliary:rest"},
    {5U, 3U, "event:u16 auxiliary:rest"},
    {5U, 4U, "event:u16 auxiliary:rest"},
    {5U, 5U, "events[8 event:u16 ]"},
    {5U, 6U, "events[8 event:u16 ]"},
    {5U, 7U, ""},
    {5U, 8U, "events[16 event:u16 ]"},
    {8U, 1U, "function:text n:u8 arguments:rest"},
    {17U, 1U, ""},
    {17U, 2U, ""},
    {17U, 3U, "apid:u16"},
    {17U, 4U, "apid:u16"},
    {20U, 1U, "parameters[8 id:x32 ]"},
    {20U, 2U, "n:u16 values:rest"},
    {20U, 3U, "n:u8 values:rest"},
    {129U, 1U, "target:u8"},
    {129U, 2U, "previous:u8 state:u8 phase:u8 configuration:u16 cause:u8 code:x16 cycle:u32"},
    {129U, 3U, "configuration:u16"},
    {129U, 4U, ""},
    {129U, 5U,
     "state:u8 phase:u8 target:u8 configuration:u16 interface_hash:x64 configuration_hash:x64 epoch:u32 "
     "cycle:u32"},
    {129U, 6U, ""},
    {129U, 7U, "event:u16 severity:u8"},
    {129U, 8U, "target:u8 cause:u8"},
    {130U, 1U, "ports[8 port:u16 ]"},
    {130U, 2U, "offers[16 port:u16 role:u8 " PROPERTIES " ]"},
    {130U, 3U, "transaction:u32 link:u16 " ENDS " " PROPERTIES},
    {130U, 4U, "transaction:u32 link:u16 " PROPERTIES " " ENDPOINT},
    {130U, 5U, "transaction:u32 reason:u8 field:u8 " PROPERTIES},
    {130U, 6U, "link:u16 epoch:u32"},
    {130U, 7U, "link:u16 reason:u8"},
    {130U, 8U, "links[8 link:u16 ]"},
    {130U, 9U,
     "links[16 link:u16 state:u8 " ENDS " " PROPERTIES
     " sent:u32 received:u32 lost:u32 late:u32 last_sequence:u32 ]"},
    {130U, 10U, "link:u16 previous:u8 state:u8 cause:u8 time:time"},
    {131U, 1U, "mode:u8"},
    {131U, 2U, "previous:u8 mode:u8 cause:u8"},
    {131U, 3U, "strategy:u8"},
    {131U, 4U, "previous:u8 strategy:u8 first_record:u64 code:x16"},
    {131U, 5U, ""},
    {131U, 6U, "process:u16"},
    {131U, 7U, "process:u16"},
    {131U, 8U, ""},
    {131U, 9U, "subsystems[16 apid:u16 process:u8 state:u8 phase:u8 configuration:u16 restarts:u8 ]"},
    {131U, 10U, ""},
    {131U, 11U, "networks[16 network:u16 members[16 apid:u16 ] links[16 link:u16 ] ]"},
};

const char* message_layout(const uint8_t service, const uint8_t subtype)
{
    for (size_t i = 0U; i < (sizeof layouts / sizeof layouts[0]); i++) {
        if ((layouts[i].service == service) && (layouts[i].subtype == subtype)) {
            return layouts[i].layout;
        }
    }
    return NULL;
}
