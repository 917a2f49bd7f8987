// SPDX-License-Identifier: Apache-2.0
// Connects ST[11], ST[22] and ST[19] to the supervisor: these services release requests by time, by position
// or after an event.
#include "fsw/supervisor/services/spacecraft_services.h"

#include "fsw/supervisor/orbit.h"
#include "fsw/supervisor/supervisor_internal.h"

static spacecraft_schedules_t* schedules_of(supervisor_t* const supervisor)
{
    return &supervisor->spacecraft.schedules;
}

static pus_block_chains_t* chains_of(supervisor_t* const supervisor)
{
    spacecraft_schedules_t* const schedules = schedules_of(supervisor);
    if (!schedules->has_chains) {
        pus_block_chains_init(&schedules->chains, schedules->blocks, schedules->slots,
                              SPACECRAFT_REQUEST_BLOCKS);
        schedules->has_chains = true;
    }
    return &schedules->chains;
}

/// Report a request whose release was interrupted by a restart: it is unknown whether it was released.
static void report_lost(void* const context, const pus_activity_id_t* const id)
{
    supervisor_t* const supervisor = (supervisor_t*)context;
    uint8_t octets[6];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u16(&writer, id->source);
    octet_write_u16(&writer, id->apid);
    octet_write_u16(&writer, id->sequence);
    (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_RELEASE_IN_DOUBT, octets, writer.position);
}

/// Returns the common part of the configurations of both schedules.
static pus_schedule_config_t common_config(supervisor_t* const supervisor)
{
    return (pus_schedule_config_t){.process            = subsystem_process(&supervisor->subsystem),
                                   .release            = {supervisor, spacecraft_release},
                                   .persistence        = spacecraft_persistence(supervisor),
                                   .chains             = chains_of(supervisor),
                                   .sub_schedule_count = SPACECRAFT_SUB_SCHEDULES,
                                   .group_count        = SPACECRAFT_GROUPS,
                                   .context            = supervisor,
                                   .lost               = report_lost};
}

// ---- ST[11] ----

static pus_service_t open_time(supervisor_t* const supervisor)
{
    spacecraft_schedules_t* const schedules = schedules_of(supervisor);
    pus_schedule_config_t config            = common_config(supervisor);
    config.activities                       = schedules->time_activities;
    config.nodes                            = schedules->time_nodes;
    config.activity_count =
        spacecraft_capacity(supervisor, PUS_SERVICE_TIME_SCHEDULE, SPACECRAFT_TIME_ACTIVITIES);
    config.buckets      = schedules->time_buckets;
    config.bucket_count = SPACECRAFT_TIME_BUCKETS;
    pus_time_schedule_init(&schedules->time, supervisor->mission->epoch_s, &config);
    return pus_time_schedule_service(&schedules->time);
}

static status_t restore_time(supervisor_t* const supervisor, const uint32_t key, const uint8_t* const octets,
                             const size_t size)
{
    return pus_time_schedule_restore(&schedules_of(supervisor)->time, key, octets, size);
}

static uint64_t step_time(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_time_schedule_t* const time = &schedules_of(supervisor)->time;
    pus_time_schedule_step(time, now_ns);
    return pus_schedule_is_waiting(&time->schedule) ? (now_ns + SPACECRAFT_RETRY_NS)
                                                    : pus_time_schedule_next_ns(time);
}

const spacecraft_binding_t spacecraft_time_schedule = {
    .type = PUS_SERVICE_TIME_SCHEDULE, .open = open_time, .restore = restore_time, .step = step_time};

// ---- ST[22] ----

static uint64_t read_position(void* const context)
{
    supervisor_t* const supervisor = (supervisor_t*)context;
    return supervisor_orbit_position(&supervisor->orbit_state, supervisor->now_ns,
                                     supervisor->orbit_period_ms);
}

static pus_service_t open_position(supervisor_t* const supervisor)
{
    spacecraft_schedules_t* const schedules = schedules_of(supervisor);
    pus_schedule_config_t config            = common_config(supervisor);
    const pus_position_port_t port          = {supervisor, read_position};
    config.activities                       = schedules->position_activities;
    config.nodes                            = schedules->position_nodes;
    config.activity_count =
        spacecraft_capacity(supervisor, PUS_SERVICE_POSITION_SCHEDULE, SPACECRAFT_POSITION_ACTIVITIES);
    config.buckets      = schedules->position_buckets;
    config.bucket_count = SPACECRAFT_POSITION_BUCKETS;
    pus_position_schedule_init(&schedules->position, &port, &config);
    return pus_position_schedule_service(&schedules->position);
}

static status_t restore_position(supervisor_t* const supervisor, const uint32_t key,
                                 const uint8_t* const octets, const size_t size)
{
    return pus_position_schedule_restore(&schedules_of(supervisor)->position, key, octets, size);
}

/// Step ST[22]. No wake time is needed: the supervisor runs at least every 10 ms, and with an orbit period
/// above 656 s the position changes in this time by less than its unit, 2^-16 orbits.
static uint64_t step_position(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_position_schedule_step(&schedules_of(supervisor)->position, now_ns);
    return SPACECRAFT_NEVER;
}

const spacecraft_binding_t spacecraft_position_schedule = {.type    = PUS_SERVICE_POSITION_SCHEDULE,
                                                           .open    = open_position,
                                                           .restore = restore_position,
                                                           .step    = step_position};

// ---- ST[19] ----

static pus_service_t open_actions(supervisor_t* const supervisor)
{
    spacecraft_schedules_t* const schedules = schedules_of(supervisor);
    const pus_event_action_config_t config  = {
         .process     = subsystem_process(&supervisor->subsystem),
         .release     = {supervisor, spacecraft_release},
         .persistence = spacecraft_persistence(supervisor),
         .definitions = schedules->action_definitions,
         .definition_count =
             spacecraft_capacity(supervisor, PUS_SERVICE_EVENT_ACTION, SPACECRAFT_EVENT_ACTIONS),
         .queue        = schedules->action_queue,
         .buckets      = schedules->action_buckets,
         .bucket_count = SPACECRAFT_EVENT_BUCKETS,
         .chains       = chains_of(supervisor)};
    pus_event_action_init(&schedules->actions, &config);
    return pus_event_action_service(&schedules->actions);
}

static status_t restore_actions(supervisor_t* const supervisor, const uint32_t key,
                                const uint8_t* const octets, const size_t size)
{
    return pus_event_action_restore(&schedules_of(supervisor)->actions, key, octets, size);
}

static uint64_t step_actions(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_event_action_t* const actions = &schedules_of(supervisor)->actions;
    pus_event_action_step(actions, now_ns);
    return pus_event_action_is_waiting(actions) ? (now_ns + SPACECRAFT_RETRY_NS) : SPACECRAFT_NEVER;
}

static void observe_event(supervisor_t* const supervisor, const pus_tm_t* const tm,
                          const uint8_t* const packet, const size_t size)
{
    (void)packet;
    (void)size;
    pus_event_occurrence_t occurrence;
    if (pus_event_occurrence_read(tm, &occurrence) == STATUS_OK) {
        pus_event_action_observe(&schedules_of(supervisor)->actions, occurrence.apid, occurrence.event);
    }
}

const spacecraft_binding_t spacecraft_event_action = {.type    = PUS_SERVICE_EVENT_ACTION,
                                                      .open    = open_actions,
                                                      .restore = restore_actions,
                                                      .step    = step_actions,
                                                      .observe = observe_event};
