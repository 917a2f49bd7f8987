// SPDX-License-Identifier: Apache-2.0
// Requests about sub-schedules and groups.
#include "pus/core/schedule_internal.h"

enum {
    SUB_SCHEDULE_STATUS = 19,
    GROUP_STATUS        = 27
};

/// Store a changed set. If this fails, the set becomes as before.
static pus_reply_t keep(pus_schedule_t* const schedule, pus_schedule_set_t* const set,
                        const pus_schedule_set_t* const before)
{
    const pus_reply_t reply = schedule_put_state(schedule);
    if (reply.kind != PUS_DONE) {
        *set = *before;
    }
    return reply;
}

/// Store the changes that the instructions of a request have made.
static pus_reply_t keep_changes(pus_schedule_t* const schedule, const pus_request_t* const request,
                                pus_schedule_set_t* const set, const pus_schedule_set_t* const before)
{
    return (request->performed > 0U) ? keep(schedule, set, before) : pus_done();
}

static void set_flag(pus_schedule_set_t* const set, const uint16_t id, const bool is_enabled)
{
    set->flags[id] = is_enabled ? (EXISTS | ENABLED) : EXISTS;
}

/// Enable or disable the sub-schedules or groups of N x {id}; all if N is 0.
static pus_reply_t set_status(pus_schedule_t* const schedule, pus_request_t* const request,
                              pus_schedule_set_t* const set, const bool is_enabled)
{
    const pus_schedule_set_t before = *set;
    const uint8_t count             = octet_read_u8(&request->reader);
    for (uint16_t id = 0U; (count == 0U) && (id < PUS_SCHEDULE_IDS); id++) {
        if ((set->flags[id] & EXISTS) != 0U) {
            set_flag(set, id, is_enabled);
        }
    }
    for (uint16_t i = 1U; i <= count; i++) {
        const uint8_t id = octet_read_u8(&request->reader);
        if ((set->flags[id] & EXISTS) != 0U) {
            pus_request_perform(request);
            set_flag(set, id, is_enabled);
        } else {
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_UNKNOWN_ID, id);
        }
    }
    return (count == 0U) ? keep(schedule, set, &before) : keep_changes(schedule, request, set, &before);
}

pus_reply_t pus_schedule_enable_sub_schedules(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    return set_status(schedule, request, &schedule->sub_schedules, true);
}

pus_reply_t pus_schedule_disable_sub_schedules(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    return set_status(schedule, request, &schedule->sub_schedules, false);
}

pus_reply_t pus_schedule_enable_groups(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    return set_status(schedule, request, &schedule->groups, true);
}

pus_reply_t pus_schedule_disable_groups(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule = object;
    return set_status(schedule, request, &schedule->groups, false);
}

static pus_reply_t report_set(pus_request_t* const request, const pus_schedule_set_t* const set,
                              const uint8_t subtype)
{
    pus_request_perform(request);
    octet_writer_t writer = pus_list_begin(request, subtype);
    for (uint16_t id = 0U; id < PUS_SCHEDULE_IDS; id++) {
        if ((set->flags[id] & EXISTS) != 0U) {
            octet_write_u8(&writer, (uint8_t)id);
            octet_write_u8(&writer, ((set->flags[id] & ENABLED) != 0U) ? 1U : 0U);
        }
    }
    return pus_list_end(request, &writer, set->count);
}

pus_reply_t pus_schedule_report_sub_schedules(void* const object, pus_request_t* const request)
{
    const pus_schedule_t* const schedule = object;
    return report_set(request, &schedule->sub_schedules, SUB_SCHEDULE_STATUS);
}

pus_reply_t pus_schedule_report_groups(void* const object, pus_request_t* const request)
{
    const pus_schedule_t* const schedule = object;
    return report_set(request, &schedule->groups, GROUP_STATUS);
}

pus_reply_t pus_schedule_create_groups(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule  = object;
    pus_schedule_set_t* const set   = &schedule->groups;
    const pus_schedule_set_t before = *set;
    const uint8_t count             = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        const uint8_t id      = octet_read_u8(&request->reader);
        const uint32_t offset = (uint32_t)request->reader.position;
        const uint8_t status  = octet_read_u8(&request->reader);
        if (status > 1U) {
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_OUT_OF_RANGE, offset);
        } else if (set->flags[id] != 0U) {
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_EXISTS, id);
        } else if (set->count >= schedule->config.group_count) {
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_TABLE_FULL, schedule->config.group_count);
        } else {
            pus_request_perform(request);
            set_flag(set, id, status != 0U);
            set->count++;
        }
    }
    return keep_changes(schedule, request, set, &before);
}

static void delete_group(pus_schedule_t* const schedule, const uint16_t id)
{
    schedule->groups.flags[id] = 0U;
    schedule->groups.count--;
}

pus_reply_t pus_schedule_delete_groups(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule  = object;
    pus_schedule_set_t* const set   = &schedule->groups;
    const pus_schedule_set_t before = *set;
    const uint8_t count             = octet_read_u8(&request->reader);
    for (uint16_t id = 0U; (count == 0U) && (id < PUS_SCHEDULE_IDS); id++) {
        if ((schedule->groups.flags[id] != 0U) && (schedule->group_uses[id] == 0U)) {
            delete_group(schedule, id);
        }
    }
    for (uint16_t i = 1U; i <= count; i++) {
        const uint8_t id = octet_read_u8(&request->reader);
        if (schedule->groups.flags[id] == 0U) {
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_UNKNOWN_ID, id);
        } else if (schedule->group_uses[id] != 0U) {
            schedule_refuse_one(schedule, request, i, PUS_FAILURE_STATE, id);
        } else {
            pus_request_perform(request);
            delete_group(schedule, id);
        }
    }
    return (count == 0U) ? keep(schedule, set, &before) : keep_changes(schedule, request, set, &before);
}
