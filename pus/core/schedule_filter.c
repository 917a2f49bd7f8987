// SPDX-License-Identifier: Apache-2.0
#include "pus/core/schedule_internal.h"

enum {
    WINDOW_ALL     = 0,
    WINDOW_FROM_TO = 1,
    WINDOW_FROM    = 2,
    WINDOW_TO      = 3
};

pus_schedule_filter_t schedule_filter_all(void)
{
    return (pus_schedule_filter_t){.to = TAG_NEVER};
}

/// Read N x {id} into a bit set; without an id (*out_has is false) the filter selects all. PUS_DONE, or
/// PUS_REFUSED.
static pus_reply_t read_ids(pus_schedule_t* const schedule, octet_reader_t* const reader,
                            const pus_schedule_set_t* const set, bool* const out_has, uint8_t* const bits)
{
    const uint8_t count = octet_read_u8(reader);
    *out_has            = count > 0U;
    for (uint8_t i = 0U; i < count; i++) {
        const uint8_t id = octet_read_u8(reader);
        if ((set->flags[id] & EXISTS) == 0U) {
            return schedule_refuse(schedule, PUS_FAILURE_UNKNOWN_ID, id);
        }
        bits[id / 8U] |= (uint8_t)(1U << (id % 8U));
    }
    return pus_done();
}

pus_reply_t schedule_read_filter(pus_schedule_t* const schedule, octet_reader_t* const reader,
                                 pus_schedule_filter_t* const out_filter)
{
    const uint8_t window  = octet_read_u8(reader);
    const uint32_t offset = (uint32_t)reader->position;
    bool is_good          = true;
    *out_filter           = schedule_filter_all();
    if ((window == (uint8_t)WINDOW_FROM_TO) || (window == (uint8_t)WINDOW_FROM)) {
        is_good = schedule->kind->read_tag(reader, &out_filter->from);
    }
    if ((window == (uint8_t)WINDOW_FROM_TO) || (window == (uint8_t)WINDOW_TO)) {
        is_good = schedule->kind->read_tag(reader, &out_filter->to) && is_good;
    }
    if (!is_good || (out_filter->from > out_filter->to)) {
        return schedule_refuse(schedule, PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    const pus_reply_t reply = read_ids(schedule, reader, &schedule->sub_schedules,
                                       &out_filter->has_sub_schedules, out_filter->sub_schedules);
    return (reply.kind == PUS_DONE)
               ? read_ids(schedule, reader, &schedule->groups, &out_filter->has_groups, out_filter->groups)
               : reply;
}

static bool has_bit(const uint8_t* const bits, const uint8_t id)
{
    return ((bits[id / 8U] >> (id % 8U)) & 1U) != 0U;
}

static bool is_selected(const pus_activity_t* const activity, const pus_schedule_filter_t* const filter)
{
    return ((filter->report == 0U) || (filter->report == activity->report)) &&
           (!filter->has_sub_schedules || has_bit(filter->sub_schedules, activity->sub_schedule)) &&
           (!filter->has_groups || has_bit(filter->groups, activity->group));
}

/// Returns the first activity at or after `first`, in the order of the schedule, that the filter selects;
/// NO_SLOT if there is none.
static uint16_t select_from(const pus_schedule_t* const schedule, const pus_schedule_filter_t* const filter,
                            const uint16_t first)
{
    uint16_t slot = first;
    while ((slot != NO_SLOT) && (schedule->config.nodes[slot].tag <= filter->to)) {
        if (is_selected(&schedule->config.activities[slot], filter)) {
            return slot;
        }
        slot = pus_sorted_index_next(&schedule->order, slot);
    }
    return NO_SLOT;
}

uint16_t schedule_select(const pus_schedule_t* const schedule, const pus_schedule_filter_t* const filter)
{
    return select_from(schedule, filter,
                       pus_sorted_index_from(&schedule->order, filter->from, filter->serial));
}

uint16_t schedule_select_next(const pus_schedule_t* const schedule, const pus_schedule_filter_t* const filter,
                              const uint16_t slot)
{
    return select_from(schedule, filter, pus_sorted_index_next(&schedule->order, slot));
}
