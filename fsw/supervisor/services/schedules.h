// SPDX-License-Identifier: Apache-2.0
/// Storage of the schedules of ST[11] and ST[22], and of ST[19]. It has room for the largest capacities that
/// a descriptor may grant. The three services share the blocks for their requests.
#ifndef FSW_SUPERVISOR_SERVICES_SCHEDULES_H
#define FSW_SUPERVISOR_SERVICES_SCHEDULES_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "pus/st11/st11_time_schedule.h"
#include "pus/st19/st19_event_action.h"
#include "pus/st22/st22_position_schedule.h"

#define SPACECRAFT_TIME_ACTIVITIES DESCRIPTOR_TIME_ACTIVITIES_MAX
#define SPACECRAFT_TIME_BUCKETS 16384U
#define SPACECRAFT_POSITION_ACTIVITIES DESCRIPTOR_POSITION_ACTIVITIES_MAX
#define SPACECRAFT_POSITION_BUCKETS 1024U
#define SPACECRAFT_EVENT_ACTIONS DESCRIPTOR_EVENT_ACTIONS_MAX
#define SPACECRAFT_EVENT_BUCKETS 1024U
#define SPACECRAFT_SUB_SCHEDULES 64U
#define SPACECRAFT_GROUPS 64U
#define SPACECRAFT_REQUEST_BLOCKS 32768U ///< Number of blocks of PUS_BLOCK_CHAIN_BLOCK octets.

typedef struct { // Private to fsw/supervisor.
    pus_time_schedule_t time;
    pus_activity_t time_activities[SPACECRAFT_TIME_ACTIVITIES];
    pus_sorted_index_node_t time_nodes[SPACECRAFT_TIME_ACTIVITIES];
    uint16_t time_buckets[SPACECRAFT_TIME_BUCKETS];
    pus_position_schedule_t position;
    pus_activity_t position_activities[SPACECRAFT_POSITION_ACTIVITIES];
    pus_sorted_index_node_t position_nodes[SPACECRAFT_POSITION_ACTIVITIES];
    uint16_t position_buckets[SPACECRAFT_POSITION_BUCKETS];
    pus_event_action_t actions;
    pus_event_action_definition_t action_definitions[SPACECRAFT_EVENT_ACTIONS];
    uint16_t action_queue[SPACECRAFT_EVENT_ACTIONS];
    uint16_t action_buckets[SPACECRAFT_EVENT_BUCKETS];
    bool has_chains;
    pus_block_chains_t chains;
    uint64_t blocks[PUS_BLOCK_CHAIN_WORDS(SPACECRAFT_REQUEST_BLOCKS)];
    pool_slot_t slots[SPACECRAFT_REQUEST_BLOCKS];
} spacecraft_schedules_t;

#endif // FSW_SUPERVISOR_SERVICES_SCHEDULES_H
