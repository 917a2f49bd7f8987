// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives.h"

#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"
#include "base/octets.h"
#include "base/value.h"

#include <stddef.h>
#include <string.h>

#define OBJECT_MODE_OF_OPERATION 0x6060U
#define MILLISECOND_NS 1000000ULL
#define EVENT_OCTETS_MAX 10U

// A call of drives_configure this long after the previous one starts a new commissioning.
#define CONFIGURE_GAP_NS (20U * MILLISECOND_NS)

#define LOST_AFTER_SYNCS 3U
#define RECEIVE_PARAMETERS 0x1400U ///< Objects of RPDOs (CiA 301).
#define RECEIVE_MAPPINGS 0x1600U
#define EVENT_TIMER 5U ///< Subindex.

static const canopen_network_config_t network_config = {
    .master           = {.node_id              = 0x01U,
                         .heartbeat_ns         = 20U * MILLISECOND_NS, // Devices expect it within 60 ms.
                         .heartbeat_timeout_ns = 60U * MILLISECOND_NS,
                         .sdo_timeout_ns       = 50U * MILLISECOND_NS},
    .lost_after_syncs = LOST_AFTER_SYNCS, // Single frames are lost by chance; three in a row have one cause.
    .call_ns          = 160U * MILLISECOND_NS, // Devices change channel every 120 ms; heartbeat 20 ms.
    .boot_retry_ns    = 300U * MILLISECOND_NS,
    .silence_reported_ns = 100U * MILLISECOND_NS,
    .quick_stop_limit_ns = 200U * MILLISECOND_NS,
};

void drives_init(drives_t* const drives, subsystem_t* const generic, const flow_resolver_t* const resolver,
                 void (*const abandon)(void* self))
{
    FSW_ASSERT((drives != NULL) && (generic != NULL) && (resolver != NULL));
    *drives = (drives_t){
        .generic = generic, .abandon = abandon, .resolver = resolver, .goal = CIA402_GOAL_DISABLED};
    canopen_network_init(&drives->network, &network_config);
}

static void enter(drives_t* const drives, const drives_activity_t activity)
{
    const bool is_new = (activity != drives->activity);
    drives->activity  = activity;
    if (is_new && (drives->abandon != NULL)) {
        drives->abandon(drives);
    }
}

// ---- Events ----

static void raise_fault(drives_t* const drives, const canopen_network_fault_t* const fault)
{
    static const char* const names[] = {
        [NETWORK_DEVICE_LOST] = "DEVICE_LOST",       [NETWORK_DRIVE_FAULT] = "DRIVE_FAULT",
        [NETWORK_DRIVE_WARNING] = "DRIVE_WARNING",   [NETWORK_BUS_WARNING] = "BUS_WARNING",
        [NETWORK_DEVICE_REFUSED] = "DEVICE_REFUSED", [NETWORK_FOREIGN_SYNC] = "FOREIGN_SYNC"};
    const descriptor_event_t* const event =
        descriptor_find_event_name(subsystem_descriptor(drives->generic), names[fault->kind]);
    if (event == NULL) {
        return;
    }
    uint8_t octets[EVENT_OCTETS_MAX];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    const bool has_data   = (event->octets > 0U); // BUS_WARNING may do without.
    if (has_data) {
        octet_write_u8(&writer, fault->node);
    }
    if (has_data && (fault->kind != NETWORK_DEVICE_LOST) && (fault->kind != NETWORK_DEVICE_REFUSED)) {
        octet_write_u16(&writer, fault->code);
    }
    if (fault->kind == NETWORK_DEVICE_REFUSED) {
        octet_write_u8(&writer, (uint8_t)fault->refusal);
        octet_write_u32(&writer, fault->object);
        octet_write_u32(&writer, fault->detail);
    }
    (void)subsystem_raise(drives->generic, event->id, octets, writer.position);
}

static void raise_faults(drives_t* const drives)
{
    canopen_network_fault_t fault;
    while (canopen_network_take_fault(&drives->network, &fault) == STATUS_OK) {
        raise_fault(drives, &fault);
    }
}

// ---- Commissioning ----

/// End node of the first device; all are on its bus and the channel B of that. Null: there are no devices.
static const descriptor_endnode_t* first_endnode(const drives_t* const drives)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    return (descriptor->device_count > 0U) ? drives_endnode(descriptor, &descriptor->devices[0]) : NULL;
}

/// Every device of every configuration, each node once.
static status_t add_devices(drives_t* const drives)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    status_t status                                = STATUS_OK;
    canopen_network_clear(&drives->network);
    for (uint16_t i = 0U; (status == STATUS_OK) && (i < descriptor->device_count); i++) {
        const uint8_t node = drives_endnode(descriptor, &descriptor->devices[i])->node;
        if (canopen_network_find(&drives->network, node) == NETWORK_NO_DEVICE) {
            status = canopen_network_add(&drives->network, descriptor->devices[i].type, node);
        }
    }
    return status;
}

/// Open the bus, unless it is open.
static status_t open_bus(drives_t* const drives)
{
    if (flow_can_is_open(drives->network.flow)) {
        return STATUS_OK;
    }
    const descriptor_endnode_t* const buses = first_endnode(drives);
    status_t status                         = (buses != NULL) ? add_devices(drives) : STATUS_NOT_FOUND;
    if (status == STATUS_OK) {
        const char* const channel_b = (buses->redundant_bus[0] != '\0') ? buses->redundant_bus : NULL;
        status = canopen_network_open(&drives->network, drives->resolver, buses->bus, channel_b);
    }
    if (status == STATUS_OK) {
        drives->goal          = CIA402_GOAL_DISABLED;
        drives->configuration = NULL;
        drives->is_closing    = false;
    }
    return status;
}

status_t drives_borrow(drives_t* const drives)
{
    FSW_ASSERT(drives != NULL);
    const bool was_open   = flow_can_is_open(drives->network.flow);
    const status_t status = open_bus(drives);
    drives->is_borrowed   = drives->is_borrowed || (!was_open && (status == STATUS_OK));
    return status;
}

void drives_give_back(drives_t* const drives)
{
    FSW_ASSERT(drives != NULL);
    if (drives->is_borrowed) {
        canopen_network_close(&drives->network);
    }
}

status_t drives_hardware_init(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    enter(drives, DRIVES_RESTING);
    const status_t opened = open_bus(drives);
    if (opened != STATUS_OK) {
        return opened;
    }
    drives->is_borrowed   = false;
    const status_t status = canopen_network_boot(&drives->network, subsystem_now_ns(drives->generic));
    raise_faults(drives); // Before the failure that they explain.
    return status;
}

/// Value of a setting, with the event timer of an RPDO [ms] as long as the mission gives master and devices.
static uint64_t value_of(const drives_t* const drives, const descriptor_setting_t* const setting)
{
    const uint64_t deadline_ns = subsystem_device_deadline_ns(drives->generic);
    const uint64_t deadline_ms = (deadline_ns + MILLISECOND_NS - 1U) / MILLISECOND_NS;
    const bool is_event_timer  = (setting->index >= RECEIVE_PARAMETERS) &&
                                (setting->index < RECEIVE_MAPPINGS) && (setting->subindex == EVENT_TIMER);
    return (is_event_timer && (deadline_ms > setting->bits)) ? deadline_ms : setting->bits;
}

/// Settings of one device of the descriptor.
static status_t add_settings(drives_t* const drives, const descriptor_device_t* const device)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    const uint8_t node                             = drives_endnode(descriptor, device)->node;
    const uint8_t index                            = canopen_network_find(&drives->network, node);
    status_t status = (index != NETWORK_NO_DEVICE) ? STATUS_OK : STATUS_NOT_FOUND;
    for (uint16_t i = 0U; (status == STATUS_OK) && (i < device->setting_count); i++) {
        const descriptor_setting_t* const source = &descriptor->settings[device->first_setting + i];
        const canopen_setting_t setting          = {.index    = source->index,
                                                    .subindex = source->subindex,
                                                    .octets   = (uint8_t)value_size(source->type),
                                                    .kind     = SETTING_WRITE,
                                                    .value    = value_of(drives, source)};
        status                                   = canopen_network_set(&drives->network, index, &setting);
    }
    return status;
}

static void set_patience(drives_t* const drives, const descriptor_configuration_t* const configuration)
{
    const uint64_t deadline_ns = subsystem_device_deadline_ns(drives->generic);
    const uint64_t period_ns   = (uint64_t)configuration->sampling_us * 1000U;
    const uint64_t syncs       = (deadline_ns + period_ns - 1U) / period_ns;
    canopen_network_set_patience(&drives->network,
                                 (syncs > LOST_AFTER_SYNCS) ? (uint32_t)syncs : LOST_AFTER_SYNCS);
}

static status_t begin_configuration(drives_t* const drives,
                                    const descriptor_configuration_t* const configuration)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    canopen_network_stop(&drives->network);
    canopen_network_clear_settings(&drives->network);
    drives->configuration = configuration;
    drives->is_written    = false;
    drives->goal          = CIA402_GOAL_DISABLED;
    status_t status       = STATUS_OK;
    set_patience(drives, configuration);
    for (uint16_t i = 0U; (status == STATUS_OK) && (i < configuration->device_count); i++) {
        status = add_settings(drives, &descriptor->devices[configuration->first_device + i]);
    }
    return status;
}

status_t drives_configure(void* const self, const descriptor_configuration_t* const configuration)
{
    FSW_ASSERT((self != NULL) && (configuration != NULL));
    drives_t* const drives = self;
    enter(drives, DRIVES_RESTING);
    const uint64_t now_ns = subsystem_now_ns(drives->generic);
    const bool is_new     = (drives->configuration != configuration) || drives->network.is_running ||
                        ((now_ns - drives->called_ns) > CONFIGURE_GAP_NS);
    status_t status   = is_new ? begin_configuration(drives, configuration) : STATUS_OK;
    drives->called_ns = now_ns;
    if ((status == STATUS_OK) && !drives->is_written) {
        status             = canopen_network_configure(&drives->network, now_ns);
        drives->is_written = (status == STATUS_OK);
    }
    if (status == STATUS_OK) {
        status = canopen_network_start(&drives->network, now_ns);
    }
    raise_faults(drives);
    if ((status != STATUS_OK) && (status != STATUS_BUSY)) {
        canopen_network_stop(&drives->network);
        drives->configuration = NULL;
    }
    return status;
}

int drives_mode(const subsystem_descriptor_t* const descriptor, const descriptor_device_t* const device)
{
    FSW_ASSERT((descriptor != NULL) && (device != NULL));
    int mode = 0;
    for (uint16_t i = 0U; i < device->setting_count; i++) {
        const descriptor_setting_t* const setting = &descriptor->settings[device->first_setting + i];
        if ((setting->index == OBJECT_MODE_OF_OPERATION) && (setting->subindex == 0U)) {
            mode = (int)(int8_t)(uint8_t)setting->bits;
        }
    }
    return mode;
}

status_t drives_post(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    enter(drives, DRIVES_RESTING);
    canopen_network_stop(&drives->network);
    drives->configuration = NULL;
    drives->goal          = CIA402_GOAL_DISABLED;
    return STATUS_OK;
}

status_t drives_hardware_deinit(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    drives->configuration  = NULL;
    drives->is_borrowed    = false;
    if (!flow_can_is_open(drives->network.flow)) {
        return STATUS_OK;
    }
    if (!drives->is_closing) {
        canopen_network_reset_nodes(&drives->network);
        drives->is_closing = true;
        return STATUS_BUSY;
    }
    canopen_network_close(&drives->network);
    drives->is_closing = false;
    return STATUS_OK;
}

void drives_release(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    canopen_network_close(&drives->network);
}

// ---- The cycle ----

/// All axes to a goal.
static status_t go(drives_t* const drives, const canopen_cia402_goal_t goal)
{
    if (goal != drives->goal) {
        // A fault may be reset on the way out of the safe state, never on the way into operation.
        canopen_network_set_goal(&drives->network, goal, goal == CIA402_GOAL_STANDBY);
        drives->goal = goal;
        return STATUS_BUSY; // The statuswords received so far were sent before this command.
    }
    return canopen_network_is_at_goal(&drives->network) ? STATUS_OK : STATUS_BUSY;
}

/// First the axes, then the activity: an activity that needs moving axes must wait until they can move.
static status_t rise(drives_t* const drives, const canopen_cia402_goal_t goal,
                     const drives_activity_t activity)
{
    const status_t status = go(drives, goal);
    if (status == STATUS_OK) {
        enter(drives, activity);
    }
    return status;
}

/// First the activity, then the axes.
static status_t descend(drives_t* const drives, const drives_activity_t activity,
                        const canopen_cia402_goal_t goal)
{
    enter(drives, activity);
    return go(drives, goal);
}

status_t drives_start_control(void* const self)
{
    FSW_ASSERT(self != NULL);
    return rise(self, CIA402_GOAL_STANDBY, DRIVES_PREPARED);
}

status_t drives_stop_control(void* const self)
{
    FSW_ASSERT(self != NULL);
    return descend(self, DRIVES_RESTING, CIA402_GOAL_DISABLED);
}

status_t drives_engage(void* const self)
{
    FSW_ASSERT(self != NULL);
    return rise(self, CIA402_GOAL_ENABLED, DRIVES_ENGAGED);
}

status_t drives_disengage(void* const self)
{
    FSW_ASSERT(self != NULL);
    return descend(self, DRIVES_PREPARED, CIA402_GOAL_STANDBY);
}

status_t drives_secure(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    enter(drives, DRIVES_RESTING);
    drives->goal = CIA402_GOAL_DISABLED;
    return canopen_network_secure(&drives->network, subsystem_now_ns(drives->generic));
}

status_t drives_select_channel(drives_t* const drives, const uint8_t channel)
{
    FSW_ASSERT(drives != NULL);
    const descriptor_endnode_t* const buses = first_endnode(drives);
    const bool has_channel_b                = (buses != NULL) && (buses->redundant_bus[0] != '\0');
    if ((channel == NETWORK_CHANNEL_B) && !has_channel_b) {
        return STATUS_OUT_OF_RANGE;
    }
    const status_t status = canopen_network_select_channel(&drives->network, channel);
    const descriptor_event_t* const event =
        descriptor_find_event_name(subsystem_descriptor(drives->generic), "CHANNEL_SELECTED");
    if ((status == STATUS_OK) && (event != NULL)) {
        (void)subsystem_raise(drives->generic, event->id, &channel, 1U);
    }
    return status;
}

void drives_sense(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    const uint64_t now_ns  = subsystem_now_ns(drives->generic);
    const bool is_given_up = (drives->configuration != NULL) && !drives->network.is_running &&
                             ((now_ns - drives->called_ns) > CONFIGURE_GAP_NS);
    if (is_given_up) { // Its time was over: no SYNC for devices that are not commissioned.
        canopen_network_stop(&drives->network);
        drives->configuration = NULL;
    }
    canopen_network_sense(&drives->network, now_ns);
    raise_faults(drives);
}

void drives_emit(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    canopen_network_emit(&drives->network, subsystem_now_ns(drives->generic));
}

/// Index in the network of a device of the applied configuration, or NETWORK_NO_DEVICE.
static uint8_t index_of(const drives_t* const drives, const uint16_t position)
{
    const descriptor_configuration_t* const configuration = drives->configuration;
    if ((configuration == NULL) || (position >= configuration->device_count)) {
        return NETWORK_NO_DEVICE;
    }
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    const descriptor_device_t* const device = &descriptor->devices[configuration->first_device + position];
    return canopen_network_find(&drives->network, drives_endnode(descriptor, device)->node);
}

canopen_device_t* drives_device(drives_t* const drives, const uint16_t position)
{
    FSW_ASSERT(drives != NULL);
    const uint8_t index = index_of(drives, position);
    return (index != NETWORK_NO_DEVICE) ? &drives->network.devices[index].device : NULL;
}

bool drives_are_running(const drives_t* const drives)
{
    FSW_ASSERT(drives != NULL);
    return drives->network.is_running;
}

uint32_t drives_missed(const drives_t* const drives, const uint16_t position)
{
    FSW_ASSERT(drives != NULL);
    const uint8_t index = index_of(drives, position);
    return (index != NETWORK_NO_DEVICE) ? drives->network.devices[index].missed : 0U;
}

uint32_t drives_limited(const drives_t* const drives)
{
    FSW_ASSERT(drives != NULL);
    uint32_t sum = 0U;
    for (uint8_t i = 0U; i < drives->network.device_count; i++) {
        for (uint8_t k = 0U; k < PROFILE_AXES_MAX; k++) {
            sum += drives->network.devices[i].device.axes[k].limited;
        }
    }
    return sum;
}
