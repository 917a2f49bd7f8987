// SPDX-License-Identifier: Apache-2.0
#include "fsw/drives/drives.h"

#include "fsw/drives/drives_fitting.h"
#include "base/assertion.h"
#include "base/octets.h"
#include "base/value.h"

#include <stddef.h>
#include <string.h>

#define MILLISECOND_NS 1000000ULL
#define EVENT_OCTETS_MAX 10U

// A call of drives_configure this long after the previous one starts a new commissioning.
#define CONFIGURE_GAP_NS (20U * MILLISECOND_NS)

#define LOST_AFTER_SYNCS 3U
#define RECEIVE_PARAMETERS 0x1400U ///< Objects of RPDOs (CiA 301).
#define RECEIVE_MAPPINGS 0x1600U
#define EVENT_TIMER 5U ///< Subindex.

static const canopen_network_config_t network_config = {
    .master = {.node_id              = 0x01U,
               .heartbeat_ns         = 20U * MILLISECOND_NS, // Devices expect it within 60 ms.
               .heartbeat_timeout_ns = 60U * MILLISECOND_NS,
               .sdo_timeout_ns       = 50U * MILLISECOND_NS},
    // A single frame can be lost by chance; three in a row are a failure.
    .lost_after_syncs    = LOST_AFTER_SYNCS,
    .selection_ns        = 160U * MILLISECOND_NS, // 120 ms to the change of channel, and two heartbeats.
    .boot_retry_ns       = 300U * MILLISECOND_NS,
    .silence_reported_ns = 100U * MILLISECOND_NS,
    .quick_stop_limit_ns = 200U * MILLISECOND_NS,
};

void drives_init(drives_t* const drives, subsystem_t* const generic, const flow_resolver_t* const resolver,
                 void (*const abandon)(void* self))
{
    FSW_ASSERT((drives != NULL) && (generic != NULL) && (resolver != NULL));
    *drives = (drives_t){
        .generic = generic, .abandon = abandon, .resolver = resolver, .goal = CIA402_GOAL_DISABLED};
    for (uint8_t i = 0U; i < DRIVES_BUSES_MAX; i++) {
        canopen_network_init(&drives->buses[i].network, &network_config);
    }
}

/// Change the activity; a change aborts all commanded motions.
static void enter(drives_t* const drives, const drives_activity_t activity)
{
    const bool is_new = (activity != drives->activity);
    drives->activity  = activity;
    if (is_new && (drives->abandon != NULL)) {
        drives->abandon(drives);
    }
}

// ---- Events ----

static void raise_fault(drives_t* const drives, const uint8_t bus, const canopen_network_fault_t* const fault)
{
    static const char* const names[] = {
        [NETWORK_DEVICE_LOST] = "DEVICE_LOST",       [NETWORK_DRIVE_FAULT] = "DRIVE_FAULT",
        [NETWORK_DRIVE_WARNING] = "DRIVE_WARNING",   [NETWORK_BUS_WARNING] = "BUS_WARNING",
        [NETWORK_DEVICE_REFUSED] = "DEVICE_REFUSED", [NETWORK_SYNC_CONFLICT] = "SYNC_CONFLICT"};
    const descriptor_event_t* const event =
        descriptor_find_event_name(subsystem_descriptor(drives->generic), names[fault->kind]);
    if (event == NULL) {
        return;
    }
    uint8_t octets[EVENT_OCTETS_MAX];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    const bool has_data   = (event->octets > 0U); // BUS_WARNING may have no data.
    if (has_data) {
        octet_write_u8(&writer, fault->node);
    }
    if (has_data && (fault->kind != NETWORK_DEVICE_LOST) && (fault->kind != NETWORK_DEVICE_REFUSED)) {
        const unsigned offset = (fault->node == 0U) ? (bus * DRIVES_BUS_CODE) : 0U;
        octet_write_u16(&writer, (uint16_t)(fault->code + offset));
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
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        while (canopen_network_take_fault(&drives->buses[i].network, &fault) == STATUS_OK) {
            raise_fault(drives, i, &fault);
        }
    }
}

// ---- Buses ----

/// True if the buses are open. All are opened and closed together.
static bool is_open(const drives_t* const drives)
{
    return (drives->bus_count > 0U) && flow_can_is_open(drives->buses[0].network.flow);
}

static void close_buses(drives_t* const drives)
{
    for (uint8_t i = 0U; i < DRIVES_BUSES_MAX; i++) {
        canopen_network_close(&drives->buses[i].network);
    }
    drives->step = DRIVES_STEP_NONE;
}

/// Stop process data on every bus.
static void stop_buses(drives_t* const drives)
{
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        canopen_network_stop(&drives->buses[i].network);
    }
    drives->step = DRIVES_STEP_NONE;
}

/// List the buses of the descriptor, each with its first end node.
static void list_buses(drives_t* const drives)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    drives->bus_count                              = 0U;
    for (uint16_t i = 0U; i < descriptor->device_count; i++) {
        const descriptor_endnode_t* const endnode = drives_endnode(descriptor, &descriptor->devices[i]);
        uint8_t bus                               = 0U;
        if (endnode == NULL) { // Stream devices are not on CAN.
            continue;
        }
        while ((bus < drives->bus_count) && (strcmp(drives->buses[bus].endnode->bus, endnode->bus) != 0)) {
            bus++;
        }
        if (bus == drives->bus_count) {
            FSW_ASSERT(bus < DRIVES_BUSES_MAX); // drives_fit has checked their number.
            drives->buses[bus].endnode = endnode;
            drives->bus_count++;
        }
    }
}

/// Call `action` for each bus that has not completed `step` yet; the buses may need different numbers of
/// cycles. STATUS_BUSY until all have completed it; STATUS_OK; or the first status that is an error.
static status_t step_buses(drives_t* const drives, const drives_step_t step,
                           status_t (*const action)(canopen_network_t* network, uint64_t now_ns))
{
    const uint64_t now_ns = subsystem_now_ns(drives->generic);
    const bool is_new     = (drives->step != step);
    status_t result       = STATUS_OK;
    drives->step          = step;
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        drives_bus_t* const bus = &drives->buses[i];
        bus->is_done            = bus->is_done && !is_new;
        const status_t status   = bus->is_done ? STATUS_OK : action(&bus->network, now_ns);
        bus->is_done            = (status == STATUS_OK);
        const bool has_error    = (result != STATUS_OK) && (result != STATUS_BUSY);
        result                  = (!has_error && (status != STATUS_OK)) ? status : result;
    }
    if (result != STATUS_BUSY) {
        drives->step = DRIVES_STEP_NONE;
    }
    return result;
}

// ---- Commissioning ----

/// Add the device of an end node.
static status_t add_device(drives_t* const drives, const char* const type,
                           const descriptor_endnode_t* const endnode)
{
    // drives_fit has checked the number of devices and mappings.
    FSW_ASSERT(drives->device_count < DRIVES_DEVICES_MAX);
    canopen_network_device_t* const entry = &drives->devices[drives->device_count];
    const status_t status = canopen_network_add(drives_network(drives, endnode), entry, type, endnode->node);
    drives->device_count  = (uint8_t)(drives->device_count + ((status == STATUS_OK) ? 1U : 0U));
    if ((status == STATUS_OK) && drives_is_mapped(subsystem_descriptor(drives->generic), endnode->node)) {
        FSW_ASSERT(drives->mapping_count < DRIVES_MAPPINGS_MAX);
        canopen_device_follow_mapping(&entry->device, &drives->mappings[drives->mapping_count]);
        drives->mapping_count++;
    }
    return status;
}

/// Add every device of every configuration, each node once.
static status_t add_devices(drives_t* const drives)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    status_t status                                = STATUS_OK;
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        canopen_network_clear(&drives->buses[i].network);
    }
    drives->device_count  = 0U;
    drives->mapping_count = 0U;
    for (uint16_t i = 0U; (status == STATUS_OK) && (i < descriptor->device_count); i++) {
        const descriptor_endnode_t* const endnode = drives_endnode(descriptor, &descriptor->devices[i]);
        if ((endnode != NULL) && (drives_find(drives, endnode->node) == NETWORK_NO_DEVICE)) {
            status = add_device(drives, descriptor->devices[i].type, endnode);
        }
    }
    return status;
}

/// Open all buses or none.
static status_t open_networks(drives_t* const drives)
{
    status_t status = (drives->bus_count > 0U) ? STATUS_OK : STATUS_NOT_FOUND;
    for (uint8_t i = 0U; (status == STATUS_OK) && (i < drives->bus_count); i++) {
        drives_bus_t* const bus = &drives->buses[i];
        const char* const channel_b =
            (bus->endnode->redundant_bus[0] != '\0') ? bus->endnode->redundant_bus : NULL;
        status = canopen_network_open(&bus->network, drives->resolver, bus->endnode->bus, channel_b);
        if ((channel_b != NULL) && subsystem_is_restarted(drives->generic)) {
            canopen_network_doubt_channel(&bus->network); // The process before may have used channel B.
        }
    }
    if (status != STATUS_OK) {
        close_buses(drives);
    }
    return status;
}

/// Open the buses, unless they are open.
static status_t open_buses(drives_t* const drives)
{
    if (is_open(drives)) {
        return STATUS_OK;
    }
    list_buses(drives);
    status_t status = add_devices(drives);
    if (status == STATUS_OK) {
        status = open_networks(drives);
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
    const bool was_open   = is_open(drives);
    const status_t status = open_buses(drives);
    drives->is_borrowed   = drives->is_borrowed || (!was_open && (status == STATUS_OK));
    return status;
}

void drives_give_back(drives_t* const drives)
{
    FSW_ASSERT(drives != NULL);
    if (drives->is_borrowed) {
        close_buses(drives);
    }
}

status_t drives_hardware_init(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    enter(drives, DRIVES_RESTING);
    const status_t opened = open_buses(drives);
    if (opened != STATUS_OK) {
        return opened;
    }
    drives->is_borrowed   = false;
    const status_t status = step_buses(drives, DRIVES_STEP_BOOT, canopen_network_boot);
    raise_faults(drives); // The faults are reported before the failure that they explain.
    return status;
}

/// Returns the value of a setting. The event timer of an RPDO [ms] is at least the mission's deadline for
/// devices.
static uint64_t value_of(const drives_t* const drives, const descriptor_setting_t* const setting)
{
    const uint64_t deadline_ns = subsystem_device_deadline_ns(drives->generic);
    const uint64_t deadline_ms = (deadline_ns + MILLISECOND_NS - 1U) / MILLISECOND_NS;
    const bool is_event_timer  = (setting->index >= RECEIVE_PARAMETERS) &&
                                (setting->index < RECEIVE_MAPPINGS) && (setting->subindex == EVENT_TIMER);
    return (is_event_timer && (deadline_ms > setting->bits)) ? deadline_ms : setting->bits;
}

/// Pass the settings of one device of the descriptor to its network.
static status_t add_settings(drives_t* const drives, const descriptor_device_t* const device)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    const descriptor_endnode_t* const endnode      = drives_endnode(descriptor, device);
    if (endnode == NULL) { // Stream devices have no settings.
        return STATUS_OK;
    }
    if (drives_find(drives, endnode->node) == NETWORK_NO_DEVICE) {
        return STATUS_NOT_FOUND;
    }
    canopen_network_t* const network = drives_network(drives, endnode);
    const uint8_t index              = canopen_network_find(network, endnode->node);
    status_t status                  = STATUS_OK;
    canopen_network_include(network, index);
    for (uint16_t i = 0U; (status == STATUS_OK) && (i < device->setting_count); i++) {
        const descriptor_setting_t* const source = &descriptor->settings[device->first_setting + i];
        const canopen_setting_t setting          = {.index    = source->index,
                                                    .subindex = source->subindex,
                                                    .octets   = (uint8_t)value_size(source->type),
                                                    .kind     = SETTING_WRITE,
                                                    .value    = value_of(drives, source)};
        status                                   = canopen_network_set(network, index, &setting);
    }
    return status;
}

/// Set the number of SYNCs after which a device is lost: the deadline for devices, but at least
/// LOST_AFTER_SYNCS.
static void set_lost_after(drives_t* const drives, const descriptor_configuration_t* const configuration)
{
    const uint64_t deadline_ns = subsystem_device_deadline_ns(drives->generic);
    const uint64_t period_ns   = (uint64_t)configuration->sampling_us * 1000U;
    const uint64_t syncs       = (deadline_ns + period_ns - 1U) / period_ns;
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        canopen_network_set_lost_after(&drives->buses[i].network,
                                       (syncs > LOST_AFTER_SYNCS) ? (uint32_t)syncs : LOST_AFTER_SYNCS);
    }
}

static status_t begin_configuration(drives_t* const drives,
                                    const descriptor_configuration_t* const configuration)
{
    const subsystem_descriptor_t* const descriptor = subsystem_descriptor(drives->generic);
    stop_buses(drives);
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        canopen_network_clear_settings(&drives->buses[i].network);
    }
    drives_note_devices(drives, configuration);
    drives->configuration = configuration;
    drives->is_written    = false;
    drives->goal          = CIA402_GOAL_DISABLED;
    status_t status       = STATUS_OK;
    set_lost_after(drives, configuration);
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
    const bool is_new     = (drives->configuration != configuration) || drives_are_running(drives) ||
                        ((now_ns - drives->called_ns) > CONFIGURE_GAP_NS);
    status_t status   = is_new ? begin_configuration(drives, configuration) : STATUS_OK;
    drives->called_ns = now_ns;
    if ((status == STATUS_OK) && !drives->is_written) {
        status             = step_buses(drives, DRIVES_STEP_CONFIGURE, canopen_network_configure);
        drives->is_written = (status == STATUS_OK);
    }
    if (status == STATUS_OK) { // All buses start in the same cycle, so that they send equally many SYNCs.
        status = step_buses(drives, DRIVES_STEP_START, canopen_network_start);
    }
    raise_faults(drives);
    if ((status != STATUS_OK) && (status != STATUS_BUSY)) {
        stop_buses(drives);
        drives->configuration = NULL;
    }
    return status;
}

status_t drives_post(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    enter(drives, DRIVES_RESTING);
    stop_buses(drives);
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
    if (!is_open(drives)) {
        return STATUS_OK;
    }
    if (!drives->is_closing) {
        for (uint8_t i = 0U; i < drives->bus_count; i++) {
            canopen_network_reset_nodes(&drives->buses[i].network);
        }
        // The reset frame needs a cycle on the bus before the buses are closed.
        drives->is_closing = true;
        return STATUS_BUSY;
    }
    close_buses(drives);
    drives->is_closing = false;
    return STATUS_OK;
}

void drives_release(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    close_buses(drives);
}

// ---- The cycle ----

/// Set the goal of all axes. STATUS_BUSY until they have reached it, then STATUS_OK.
static status_t reach_goal(drives_t* const drives, const canopen_cia402_goal_t goal)
{
    if (goal != drives->goal) {
        // A fault may be reset on the way out of the safe state, never on the way into operation.
        for (uint8_t i = 0U; i < drives->bus_count; i++) {
            canopen_network_set_goal(&drives->buses[i].network, goal, goal == CIA402_GOAL_STANDBY);
        }
        drives->goal = goal;
        drives->step = DRIVES_STEP_NONE;
        return STATUS_BUSY; // The statuswords received so far were sent before this command.
    }
    bool are_all = (drives->bus_count > 0U);
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        are_all = are_all && canopen_network_is_at_goal(&drives->buses[i].network);
    }
    return are_all ? STATUS_OK : STATUS_BUSY;
}

/// Change first the axes, then the activity: an activity that needs moving axes must wait until they can
/// move.
static status_t change_axes_first(drives_t* const drives, const canopen_cia402_goal_t goal,
                                  const drives_activity_t activity)
{
    const status_t status = reach_goal(drives, goal);
    if (status == STATUS_OK) {
        enter(drives, activity);
    }
    return status;
}

/// Change first the activity, then the axes.
static status_t change_activity_first(drives_t* const drives, const drives_activity_t activity,
                                      const canopen_cia402_goal_t goal)
{
    enter(drives, activity);
    return reach_goal(drives, goal);
}

status_t drives_start_control(void* const self)
{
    FSW_ASSERT(self != NULL);
    return change_axes_first(self, CIA402_GOAL_STANDBY, DRIVES_PREPARED);
}

status_t drives_stop_control(void* const self)
{
    FSW_ASSERT(self != NULL);
    return change_activity_first(self, DRIVES_RESTING, CIA402_GOAL_DISABLED);
}

status_t drives_engage(void* const self)
{
    FSW_ASSERT(self != NULL);
    return change_axes_first(self, CIA402_GOAL_ENABLED, DRIVES_ENGAGED);
}

status_t drives_disengage(void* const self)
{
    FSW_ASSERT(self != NULL);
    return change_activity_first(self, DRIVES_PREPARED, CIA402_GOAL_STANDBY);
}

status_t drives_secure(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives = self;
    enter(drives, DRIVES_RESTING);
    drives->goal = CIA402_GOAL_DISABLED;
    // All buses begin in the same cycle.
    return step_buses(drives, DRIVES_STEP_SECURE, canopen_network_secure);
}

/// Check that every bus has the channel. STATUS_OK, STATUS_OUT_OF_RANGE, STATUS_NOT_FOUND.
static status_t check_channel(const drives_t* const drives, const uint8_t channel)
{
    status_t status =
        ((drives->bus_count > 0U) && (channel < NETWORK_CHANNELS)) ? STATUS_OK : STATUS_OUT_OF_RANGE;
    for (uint8_t i = 0U; (status == STATUS_OK) && (i < drives->bus_count); i++) {
        const drives_bus_t* const bus = &drives->buses[i];
        if ((channel == NETWORK_CHANNEL_B) && (bus->endnode->redundant_bus[0] == '\0')) {
            status = STATUS_OUT_OF_RANGE;
        } else if (!canopen_network_has_channel(&bus->network, channel)) {
            status = STATUS_NOT_FOUND;
        } else {
            // This bus has the channel; check the next one.
        }
    }
    return status;
}

status_t drives_select_channel(drives_t* const drives, const uint8_t channel)
{
    FSW_ASSERT(drives != NULL);
    if (!is_open(drives)) {
        list_buses(drives);
    }
    status_t status = check_channel(drives, channel);
    for (uint8_t i = 0U; (status == STATUS_OK) && (i < DRIVES_BUSES_MAX); i++) {
        status = canopen_network_select_channel(&drives->buses[i].network, channel);
    }
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
    const bool is_given_up = (drives->configuration != NULL) && !drives_are_running(drives) &&
                             ((now_ns - drives->called_ns) > CONFIGURE_GAP_NS);
    if (is_given_up) { // Commissioning timed out: devices that are not commissioned get no SYNC.
        stop_buses(drives);
        drives->configuration = NULL;
    }
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        canopen_network_sense(&drives->buses[i].network, now_ns);
    }
    raise_faults(drives);
}

void drives_emit(void* const self)
{
    FSW_ASSERT(self != NULL);
    drives_t* const drives   = self;
    const bool is_sync_first = subsystem_descriptor(drives->generic)->is_sync_first;
    // Send SYNC on all buses before the commands of any bus.
    for (uint8_t i = 0U; is_sync_first && (i < drives->bus_count); i++) {
        canopen_network_send_sync(&drives->buses[i].network);
    }
    for (uint8_t i = 0U; i < drives->bus_count; i++) {
        canopen_network_emit(&drives->buses[i].network, subsystem_now_ns(drives->generic));
    }
}
