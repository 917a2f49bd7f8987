// SPDX-License-Identifier: Apache-2.0
#include "sim/truth/truth.h"

#include "sim/logs/write_behind.h"

#include <lcm/eventlog.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Octets for the longest event (the names of a world with all entries), and padding. Every step writes and
// compares all events: with the padding they begin in different sets of the processor's cache, which repeat
// every 4096 octets.
#define EVENT_MAX (16384U + 640U)
#define HEADER_OCTETS 28U           // Octets of an event before the name of its channel.
#define SYNCHRONISATION 0xEDA1DA01U // First octets of an event.
#define CHANNEL_MAX 16U             ///< Names of channels are shorter.
#define TEXT_MAX 96U                ///< Longer texts are cut.
#define TIME_AT 8U                  ///< The time of an event follows its fingerprint.
#define CONTENT_AT 16U              ///< The content follows its time.

// Fingerprints of the types. lcm-gen computes them from the .lcm files, and a test compares them.
#define WORLD_FINGERPRINT 0x887e8e9e77de14a2U
#define SPRING_FINGERPRINT 0xa89b5a445320e88aU
#define BASE_FINGERPRINT 0x2ae373c47d896116U
#define BUS_FINGERPRINT 0xe2ad0559ed8d3f75U
#define BENCH_FINGERPRINT 0xbb90db965cc14840U
#define INSTRUMENT_FINGERPRINT 0x1867ed987b9ee58cU
#define POWER_FINGERPRINT 0x2e4b63f6784b06f8U
#define NAMES_FINGERPRINT 0x0a16769a90c1072dU
#define WHEEL_FINGERPRINT 0xfc7c75bdfc75624eU
#define CUT_FINGERPRINT 0x82eedeeaec5cb47eU
#define JOINTS_FINGERPRINT 0x155462f69b65a80dU
#define STICK_FINGERPRINT 0x179a3fc0f9b09d08U
#define CONTACT_FINGERPRINT 0xec3f64684bc9faf9U
#define OPERATOR_FINGERPRINT 0x9c09812942901a56U
#define DRIVE_FINGERPRINT 0x234a7675b50e9ae7U
#define VALVE_FINGERPRINT 0x203d8547f783828aU
#define LATCH_FINGERPRINT 0x6082048e59e35adaU
#define FAULT_FINGERPRINT 0x80b9c8e8a82d7e4aU

/// One event under construction, encoded big-endian as in LCM except its floating point numbers, which are
/// consecutive. Because every step compares them, they are in the processor's byte order until the event is
/// written.
typedef struct {
    size_t used;
    size_t numbers_at;
    size_t numbers;
    uint64_t time_ns;
    uint8_t octet[EVENT_MAX];
} event_t;

/// The channels that are passed at every step, in the order of a step.
typedef enum {
    JOINTS,
    STICK,
    CONTACT,
    SPRING,
    WHEEL,
    BASE,
    BENCH,
    INSTRUMENT,
    POWER,
    BUS,
    OPERATOR,
    STATE_CHANNELS
} state_channel_t;

static const char* const state_names[STATE_CHANNELS] = {"JOINTS", "STICK", "CONTACT", "SPRING",
                                                        "WHEEL",  "BASE",  "BENCH",   "INSTRUMENT",
                                                        "POWER",  "BUS",   "OPERATOR"};

typedef struct {
    event_t written;  ///< Last event in the log; empty if there is none.
    event_t left_out; ///< Later event that is not in the log; empty if there is none.
} history_t;

struct truth {
    lcm_eventlog_t* log;
    uint64_t octets;
    uint64_t max_octets;
    bool is_cut;
    bool failed; // The task of `events` sets it.
    history_t history[STATE_CHANNELS];
    write_behind_t events;
};

static void put_u8(event_t* const event, const uint8_t value)
{
    event->octet[event->used] = value;
    event->used++;
}

static void store_u32(uint8_t* const octet, const uint32_t value)
{
    octet[0] = (uint8_t)(value >> 24);
    octet[1] = (uint8_t)(value >> 16);
    octet[2] = (uint8_t)(value >> 8);
    octet[3] = (uint8_t)value;
}

static void store_u64(uint8_t* const octet, const uint64_t value)
{
    octet[0] = (uint8_t)(value >> 56);
    octet[1] = (uint8_t)(value >> 48);
    octet[2] = (uint8_t)(value >> 40);
    octet[3] = (uint8_t)(value >> 32);
    octet[4] = (uint8_t)(value >> 24);
    octet[5] = (uint8_t)(value >> 16);
    octet[6] = (uint8_t)(value >> 8);
    octet[7] = (uint8_t)value;
}

static void put_u32(event_t* const event, const uint32_t value)
{
    store_u32(&event->octet[event->used], value);
    event->used += 4U;
}

static void put_u64(event_t* const event, const uint64_t value)
{
    store_u64(&event->octet[event->used], value);
    event->used += 8U;
}

static void put_bool(event_t* const event, const bool value)
{
    put_u8(event, value ? 1U : 0U);
}

static void put_doubles(event_t* const event, const double* const value, const unsigned count)
{
    event->numbers_at = (event->numbers == 0U) ? event->used : event->numbers_at;
    event->numbers += count;
    uint8_t* octet = &event->octet[event->used];
    for (unsigned i = 0U; i < count; i++) {
        memcpy(&octet[i * sizeof(double)], &value[i], sizeof(double));
    }
    event->used += count * sizeof(double);
}

static void put_text(event_t* const event, const char* const text)
{
    const size_t length = (strlen(text) < TEXT_MAX) ? strlen(text) : TEXT_MAX;
    put_u32(event, (uint32_t)length + 1U);
    memcpy(&event->octet[event->used], text, length);
    event->used += length;
    put_u8(event, 0U);
}

static void begin(event_t* const event, const uint64_t fingerprint, const uint64_t time_ns)
{
    event->used       = CONTENT_AT; // The time is put in when the event is written.
    event->numbers_at = CONTENT_AT;
    event->numbers    = 0U;
    event->time_ns    = time_ns;
    store_u64(event->octet, fingerprint);
}

static bool has_failed(const truth_t* const truth)
{
    return __atomic_load_n(&truth->failed, __ATOMIC_RELAXED);
}

/// Write whole events. After a failure the log ends, because a reader could not detect a gap.
static void write_events(void* const context, const uint8_t* const octets, const size_t size)
{
    truth_t* truth = context;
    if (!has_failed(truth) && (fwrite(octets, size, 1U, truth->log->f) != 1U)) {
        __atomic_store_n(&truth->failed, true, __ATOMIC_RELAXED);
    }
}

/// Copy an event as it is in the log: with its time, and with its numbers big-endian.
static void encode(const event_t* const event, uint8_t* const out_octets)
{
    memcpy(out_octets, event->octet, event->used);
    store_u64(&out_octets[TIME_AT], event->time_ns);
    for (size_t i = 0U; i < event->numbers; i++) {
        const size_t at = event->numbers_at + (i * sizeof(double));
        uint64_t bits;
        memcpy(&bits, &event->octet[at], sizeof bits);
        store_u64(&out_octets[at], bits);
    }
}

/// Pass an event to the task that writes it. lcm_eventlog_write_event writes nine pieces, which takes longer.
static status_t write_record(truth_t* const truth, const char* const channel, const event_t* const event)
{
    const size_t length = strlen(channel);
    const size_t size   = HEADER_OCTETS + length + event->used;
    uint8_t* head       = write_behind_room(&truth->events, size);
    store_u32(&head[0], SYNCHRONISATION);
    store_u64(&head[4], (uint64_t)truth->log->eventcount);
    store_u64(&head[12], event->time_ns / 1000U);
    store_u32(&head[20], (uint32_t)length);
    store_u32(&head[24], (uint32_t)event->used);
    for (size_t i = 0U; i < length; i++) {
        head[HEADER_OCTETS + i] = (uint8_t)channel[i];
    }
    encode(event, &head[HEADER_OCTETS + length]);
    write_behind_add(&truth->events, size);
    truth->log->eventcount++;
    truth->octets += size;
    return has_failed(truth) ? STATUS_IO : STATUS_OK;
}

/// Write CUT, the last event of a log that has reached its maximum size.
static status_t cut(truth_t* const truth, const uint64_t time_ns)
{
    event_t event;
    begin(&event, CUT_FINGERPRINT, time_ns);
    put_u64(&event, truth->octets);
    truth->is_cut = true;
    return write_record(truth, "CUT", &event);
}

static status_t write_event(truth_t* const truth, const char* const channel, event_t* const event)
{
    if (has_failed(truth)) {
        return STATUS_IO;
    }
    if (truth->is_cut) {
        return STATUS_OK;
    }
    const bool is_full = (truth->octets + HEADER_OCTETS + CHANNEL_MAX + event->used) > truth->max_octets;
    return is_full ? cut(truth, event->time_ns) : write_record(truth, channel, event);
}

// ---- Channels at rest ----

static double number_of(const event_t* const event, const size_t index)
{
    double value;
    memcpy(&value, &event->octet[event->numbers_at + (index * sizeof value)], sizeof value);
    return value;
}

/// True if all floating point numbers differ by at most TRUTH_RESOLUTION, and all other octets are equal.
static bool is_same(const event_t* const a, const event_t* const b)
{
    if ((a->used != b->used) || (a->numbers != b->numbers)) {
        return false;
    }
    // The octets before the numbers are not compared: they are the fingerprint of the channel, the time, and
    // the count of the numbers, which is equal here.
    const size_t end = a->numbers_at + (a->numbers * sizeof(double));
    bool is_equal    = memcmp(&a->octet[end], &b->octet[end], a->used - end) == 0;
    for (size_t i = 0U; is_equal && (i < a->numbers); i++) {
        is_equal = fabs(number_of(a, i) - number_of(b, i)) <= TRUTH_RESOLUTION; // False for NaN.
    }
    return is_equal;
}

static void copy_event(event_t* const to, const event_t* const from)
{
    memcpy(to->octet, from->octet, from->used);
    to->used       = from->used;
    to->numbers_at = from->numbers_at;
    to->numbers    = from->numbers;
    to->time_ns    = from->time_ns;
}

static status_t write_left_out(truth_t* const truth, const state_channel_t channel)
{
    event_t* event        = &truth->history[channel].left_out;
    const status_t status = (event->used > 0U) ? write_event(truth, state_names[channel], event) : STATUS_OK;
    event->used           = 0U;
    return status;
}

/// Write the event of a step if it differs from the last event of its channel. If the event of the previous
/// step was left out, write that one first, so that the log shows when the change began.
static status_t write_state(truth_t* const truth, const state_channel_t channel, event_t* const event)
{
    history_t* history    = &truth->history[channel];
    const bool is_at_rest = is_same(event, &history->written);
    if (is_at_rest && (event->time_ns < (history->written.time_ns + TRUTH_INTERVAL_NS))) {
        copy_event(&history->left_out, event);
        return has_failed(truth) ? STATUS_IO : STATUS_OK;
    }
    history->left_out.used = is_at_rest ? 0U : history->left_out.used;
    const status_t status  = write_left_out(truth, channel);
    copy_event(&history->written, event);
    return (status == STATUS_OK) ? write_event(truth, state_names[channel], event) : status;
}

/// Do what write_state does for an event that equals the last one of its channel except for its time.
static status_t repeat_state(truth_t* const truth, const state_channel_t channel, const uint64_t time_ns)
{
    history_t* history = &truth->history[channel];
    event_t event;
    if ((history->left_out.used > 0U) && (time_ns < (history->written.time_ns + TRUTH_INTERVAL_NS))) {
        history->left_out.time_ns = time_ns;
        return has_failed(truth) ? STATUS_IO : STATUS_OK;
    }
    copy_event(&event, (history->left_out.used > 0U) ? &history->left_out : &history->written);
    event.time_ns = time_ns;
    return write_state(truth, channel, &event);
}

status_t truth_open(const char* const path, const uint64_t max_octets, truth_t** const out_truth)
{
    *out_truth     = NULL;
    truth_t* truth = calloc(1U, sizeof *truth);
    if (truth == NULL) {
        return STATUS_IO;
    }
    truth->log = lcm_eventlog_create(path, "w");
    if (truth->log == NULL) {
        free(truth);
        return STATUS_IO;
    }
    (void)setvbuf(truth->log->f, NULL, _IONBF, 0U);
    write_behind_open(&truth->events, write_events, truth);
    truth->max_octets = max_octets;
    *out_truth        = truth;
    return STATUS_OK;
}

status_t truth_close(truth_t* const truth)
{
    if (truth == NULL) {
        return STATUS_OK;
    }
    for (unsigned i = 0U; i < STATE_CHANNELS; i++) {
        (void)write_left_out(truth, (state_channel_t)i); // The log then contains the last step.
    }
    write_behind_close(&truth->events);
    const bool failed = has_failed(truth);
    lcm_eventlog_destroy(truth->log);
    free(truth);
    return failed ? STATUS_IO : STATUS_OK;
}

void truth_flush(truth_t* const truth, const bool waits)
{
    write_behind_flush(&truth->events, waits); // truth_close reports what could not be written.
}

static void put_bools(event_t* const event, const bool* const value, const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        put_bool(event, value[i]);
    }
}

static void put_names(event_t* const event, const truth_names_t* const names)
{
    put_u32(event, names->count);
    for (unsigned i = 0U; i < names->count; i++) {
        put_text(event, names->name[i]);
    }
}

status_t truth_world(truth_t* const truth, const uint64_t time_ns, const truth_world_t* const world)
{
    event_t event;
    begin(&event, WORLD_FINGERPRINT, time_ns);
    put_names(&event, &world->joints);
    put_names(&event, &world->axes);
    put_names(&event, &world->contacts);
    put_names(&event, &world->springs);
    put_names(&event, &world->bases);
    return write_event(truth, "WORLD", &event);
}

status_t truth_joints(truth_t* const truth, const uint64_t time_ns, const truth_joints_t* const joints)
{
    event_t event;
    begin(&event, JOINTS_FINGERPRINT, time_ns);
    put_u32(&event, joints->count);
    put_doubles(&event, joints->position_rad, joints->count);
    put_doubles(&event, joints->velocity_rad_s, joints->count);
    put_doubles(&event, joints->motor_position_rad, joints->count);
    put_doubles(&event, joints->motor_torque_nm, joints->count);
    put_doubles(&event, joints->joint_torque_nm, joints->count);
    put_doubles(&event, joints->friction_nm, joints->count);
    put_doubles(&event, joints->external_torque_nm, joints->count);
    put_bools(&event, joints->brake_engaged, joints->count);
    return write_state(truth, JOINTS, &event);
}

status_t truth_stick(truth_t* const truth, const uint64_t time_ns, const truth_stick_t* const stick)
{
    event_t event;
    begin(&event, STICK_FINGERPRINT, time_ns);
    put_u32(&event, stick->count);
    put_doubles(&event, stick->position_rad, stick->count);
    put_doubles(&event, stick->velocity_rad_s, stick->count);
    put_doubles(&event, stick->motor_torque_nm, stick->count);
    put_doubles(&event, stick->hand_torque_nm, stick->count);
    return write_state(truth, STICK, &event);
}

status_t truth_contacts(truth_t* const truth, const uint64_t time_ns, const truth_touch_t* const contact,
                        const unsigned count)
{
    event_t event;
    begin(&event, CONTACT_FINGERPRINT, time_ns);
    put_u32(&event, count);
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, contact[i].place_m, 3U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, contact[i].point_m, 3U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, contact[i].force_n, 3U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_bool(&event, contact[i].is_active);
    }
    return write_state(truth, CONTACT, &event);
}

status_t truth_springs(truth_t* const truth, const uint64_t time_ns, const truth_touch_t* const spring,
                       const unsigned count)
{
    event_t event;
    begin(&event, SPRING_FINGERPRINT, time_ns);
    put_u32(&event, count);
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, spring[i].place_m, 3U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, spring[i].force_n, 3U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_bool(&event, spring[i].is_active);
    }
    return write_state(truth, SPRING, &event);
}

status_t truth_bases(truth_t* const truth, const uint64_t time_ns, const truth_base_t* const base,
                     const unsigned count)
{
    event_t event;
    begin(&event, BASE_FINGERPRINT, time_ns);
    put_u32(&event, count);
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, base[i].position_m, 3U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, base[i].rotation, 4U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, base[i].velocity_m_s, 3U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, base[i].rate_rad_s, 3U);
    }
    return write_state(truth, BASE, &event);
}

status_t truth_wheels(truth_t* const truth, const uint64_t time_ns, const truth_wheel_t* const wheel,
                      const unsigned count)
{
    event_t event;
    begin(&event, WHEEL_FINGERPRINT, time_ns);
    put_u32(&event, count);
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, &wheel[i].momentum_nms, 1U);
    }
    for (unsigned i = 0U; i < count; i++) {
        put_doubles(&event, &wheel[i].torque_nm, 1U);
    }
    return write_state(truth, WHEEL, &event);
}

status_t truth_benches(truth_t* const truth, const uint64_t time_ns, const truth_benches_t* const benches)
{
    event_t event;
    begin(&event, BENCH_FINGERPRINT, time_ns);
    put_u32(&event, benches->count);
    put_doubles(&event, benches->position_rad, benches->count);
    put_doubles(&event, benches->velocity_rad_s, benches->count);
    put_doubles(&event, benches->output_torque_nm, benches->count);
    return write_state(truth, BENCH, &event);
}

status_t truth_instruments(truth_t* const truth, const uint64_t time_ns,
                           const truth_instruments_t* const instruments)
{
    event_t event;
    begin(&event, INSTRUMENT_FINGERPRINT, time_ns);
    put_u32(&event, instruments->count);
    put_doubles(&event, instruments->value, instruments->count);
    put_bools(&event, instruments->enabled, instruments->count);
    put_bools(&event, instruments->plugged, instruments->count);
    return write_state(truth, INSTRUMENT, &event);
}

status_t truth_power(truth_t* const truth, const uint64_t time_ns, const bool* const supplied,
                     const unsigned count)
{
    event_t event;
    begin(&event, POWER_FINGERPRINT, time_ns);
    put_u32(&event, count);
    put_bools(&event, supplied, count);
    return write_state(truth, POWER, &event);
}

status_t truth_buses(truth_t* const truth, const uint64_t time_ns, const truth_buses_t* const buses)
{
    event_t event;
    begin(&event, BUS_FINGERPRINT, time_ns);
    put_u32(&event, buses->count);
    put_doubles(&event, buses->load, buses->count);
    for (unsigned i = 0U; i < buses->count; i++) {
        put_u64(&event, buses->frames[i]);
    }
    for (unsigned i = 0U; i < buses->count; i++) {
        put_u64(&event, buses->errors[i]);
    }
    for (unsigned i = 0U; i < buses->count; i++) {
        put_u32(&event, (uint32_t)buses->state[i]);
    }
    for (unsigned i = 0U; i < buses->count; i++) {
        put_u32(&event, buses->off[i]);
    }
    put_bools(&event, buses->plugged, buses->count);
    return write_state(truth, BUS, &event);
}

status_t truth_buses_again(truth_t* const truth, const uint64_t time_ns)
{
    return repeat_state(truth, BUS, time_ns);
}

status_t truth_names(truth_t* const truth, const uint64_t time_ns, const char* const channel,
                     const truth_names_t* const names)
{
    event_t event;
    begin(&event, NAMES_FINGERPRINT, time_ns);
    put_text(&event, channel);
    put_names(&event, names);
    return write_event(truth, "NAMES", &event);
}

status_t truth_operator(truth_t* const truth, const uint64_t time_ns, const truth_operator_t* const operator_)
{
    event_t event;
    begin(&event, OPERATOR_FINGERPRINT, time_ns);
    put_doubles(&event, operator_->intent_rad, 2U);
    put_doubles(&event, operator_->wanted_tip_m, 2U);
    put_doubles(&event, operator_->expected_torque_nm, 2U);
    put_doubles(&event, &operator_->grip, 1U);
    put_text(&event, operator_->verb);
    return write_state(truth, OPERATOR, &event);
}

status_t truth_drive(truth_t* const truth, const uint64_t time_ns, const truth_drive_t* const drive)
{
    event_t event;
    begin(&event, DRIVE_FINGERPRINT, time_ns);
    put_text(&event, drive->bus);
    put_u32(&event, drive->node);
    put_u32(&event, drive->axis);
    put_u32(&event, drive->statusword);
    put_bool(&event, drive->plugged);
    put_bool(&event, drive->brake_engaged);
    return write_event(truth, "DRIVE", &event);
}

status_t truth_valve(truth_t* const truth, const uint64_t time_ns, const truth_valve_t* const valve)
{
    event_t event;
    begin(&event, VALVE_FINGERPRINT, time_ns);
    put_text(&event, valve->name);
    put_bool(&event, valve->is_open);
    return write_event(truth, "VALVE", &event);
}

status_t truth_latch(truth_t* const truth, const uint64_t time_ns, const truth_latch_t* const latch)
{
    event_t event;
    begin(&event, LATCH_FINGERPRINT, time_ns);
    put_text(&event, latch->name);
    put_bool(&event, latch->is_closed);
    return write_event(truth, "LATCH", &event);
}

status_t truth_fault(truth_t* const truth, const uint64_t time_ns, const truth_fault_t* const fault)
{
    event_t event;
    begin(&event, FAULT_FINGERPRINT, time_ns);
    put_text(&event, fault->kind);
    put_text(&event, fault->target);
    put_bool(&event, fault->active);
    return write_event(truth, "FAULT", &event);
}
