// SPDX-License-Identifier: Apache-2.0
#include "sim/truth/truth.h"

#include <lcm/eventlog.h>
#include <stddef.h>
#include <stdio.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>

#define EVENT_MAX 512U
#define BUFFER_OCTETS 262144U
#define CHANNEL_MAX 16U ///< Names of channels are shorter.
#define TEXT_MAX 96U    ///< Longer words are cut.

// What lcm-gen computes from the .lcm files; a test compares them.
#define JOINTS_FINGERPRINT 0x0b0870ea2bd9c736U
#define STICK_FINGERPRINT 0x8924374ffa747569U
#define CONTACT_FINGERPRINT 0x1cd1395f138a451aU
#define OPERATOR_FINGERPRINT 0x9c09812942901a56U
#define DRIVE_FINGERPRINT 0x234a7675b50e9ae7U
#define FAULT_FINGERPRINT 0x80b9c8e8a82d7e4aU

struct truth {
    lcm_eventlog_t* log;
    bool failed;
};

/// One event under construction: big-endian, as LCM encodes.
typedef struct {
    uint8_t octet[EVENT_MAX];
    size_t used;
} event_t;

static void put(event_t* const event, const uint64_t value, const unsigned octets)
{
    for (unsigned i = octets; i > 0U; i--) {
        event->octet[event->used] = (uint8_t)(value >> (8U * (i - 1U)));
        event->used++;
    }
}

static void put_bool(event_t* const event, const bool value)
{
    put(event, value ? 1U : 0U, 1U);
}

static void put_doubles(event_t* const event, const double* const value, const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &value[i], sizeof bits);
        put(event, bits, 8U);
    }
}

static void put_text(event_t* const event, const char* const text)
{
    const size_t length = (strlen(text) < TEXT_MAX) ? strlen(text) : TEXT_MAX;
    put(event, length + 1U, 4U);
    memcpy(&event->octet[event->used], text, length);
    event->used += length;
    put(event, 0U, 1U);
}

static void begin(event_t* const event, const uint64_t fingerprint, const uint64_t time_ns)
{
    event->used = 0U;
    put(event, fingerprint, 8U);
    put(event, time_ns, 8U);
}

static status_t write_event(truth_t* const truth, const char* const channel, const uint64_t time_ns,
                            event_t* const event)
{
    if (truth->failed) {
        return STATUS_IO;
    }
    char name[CHANNEL_MAX]; // The library requires a writable text.
    const size_t length = strlen(channel);
    memcpy(name, channel, length + 1U);
    lcm_eventlog_event_t record = {
        .timestamp  = (int64_t)(time_ns / 1000U),
        .channellen = (int32_t)length,
        .datalen    = (int32_t)event->used,
        .channel    = name,
        .data       = event->octet,
    };
    truth->failed = lcm_eventlog_write_event(truth->log, &record) != 0;
    return truth->failed ? STATUS_IO : STATUS_OK;
}

status_t truth_open(const char* const path, truth_t** const out_truth)
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
    // One task writes thousands of small pieces a second: no lock for each, and few calls of the system.
    (void)__fsetlocking(truth->log->f, FSETLOCKING_BYCALLER);
    (void)setvbuf(truth->log->f, NULL, _IOFBF, BUFFER_OCTETS);
    *out_truth = truth;
    return STATUS_OK;
}

status_t truth_close(truth_t* const truth)
{
    if (truth == NULL) {
        return STATUS_OK;
    }
    const bool failed = truth->failed || (fflush(truth->log->f) != 0) || (ferror(truth->log->f) != 0);
    lcm_eventlog_destroy(truth->log);
    free(truth);
    return failed ? STATUS_IO : STATUS_OK;
}

status_t truth_joints(truth_t* const truth, const uint64_t time_ns, const truth_joints_t* const joints)
{
    event_t event;
    begin(&event, JOINTS_FINGERPRINT, time_ns);
    put_doubles(&event, joints->position_rad, TRUTH_JOINTS);
    put_doubles(&event, joints->velocity_rad_s, TRUTH_JOINTS);
    put_doubles(&event, joints->motor_position_rad, TRUTH_JOINTS);
    put_doubles(&event, joints->motor_torque_nm, TRUTH_JOINTS);
    put_doubles(&event, joints->joint_torque_nm, TRUTH_JOINTS);
    put_doubles(&event, joints->friction_nm, TRUTH_JOINTS);
    put_bool(&event, joints->brake_engaged[0]);
    put_bool(&event, joints->brake_engaged[1]);
    return write_event(truth, "JOINTS", time_ns, &event);
}

status_t truth_stick(truth_t* const truth, const uint64_t time_ns, const truth_stick_t* const stick)
{
    event_t event;
    begin(&event, STICK_FINGERPRINT, time_ns);
    put_doubles(&event, stick->position_rad, TRUTH_AXES);
    put_doubles(&event, stick->velocity_rad_s, TRUTH_AXES);
    put_doubles(&event, stick->motor_torque_nm, TRUTH_AXES);
    put_doubles(&event, stick->hand_torque_nm, TRUTH_AXES);
    return write_event(truth, "STICK", time_ns, &event);
}

status_t truth_contact(truth_t* const truth, const uint64_t time_ns, const truth_contact_t* const contact)
{
    event_t event;
    begin(&event, CONTACT_FINGERPRINT, time_ns);
    put_doubles(&event, contact->tip_m, 3U);
    put_bool(&event, contact->in_contact);
    put_bool(&event, contact->spring_hooked);
    put_doubles(&event, contact->contact_point_m, 3U);
    put_doubles(&event, contact->contact_force_n, 3U);
    put_doubles(&event, contact->spring_force_n, 3U);
    put_doubles(&event, contact->external_torque_nm, TRUTH_JOINTS);
    return write_event(truth, "CONTACT", time_ns, &event);
}

status_t truth_operator(truth_t* const truth, const uint64_t time_ns, const truth_operator_t* const operator_)
{
    event_t event;
    begin(&event, OPERATOR_FINGERPRINT, time_ns);
    put_doubles(&event, operator_->intent_rad, TRUTH_AXES);
    put_doubles(&event, operator_->wanted_tip_m, 2U);
    put_doubles(&event, operator_->expected_torque_nm, TRUTH_JOINTS);
    put_doubles(&event, &operator_->grip, 1U);
    put_text(&event, operator_->verb);
    return write_event(truth, "OPERATOR", time_ns, &event);
}

status_t truth_drive(truth_t* const truth, const uint64_t time_ns, const truth_drive_t* const drive)
{
    event_t event;
    begin(&event, DRIVE_FINGERPRINT, time_ns);
    put_text(&event, drive->bus);
    put(&event, drive->node, 4U);
    put(&event, drive->axis, 4U);
    put(&event, drive->statusword, 4U);
    put_bool(&event, drive->plugged);
    put_bool(&event, drive->brake_engaged);
    return write_event(truth, "DRIVE", time_ns, &event);
}

status_t truth_fault(truth_t* const truth, const uint64_t time_ns, const truth_fault_t* const fault)
{
    event_t event;
    begin(&event, FAULT_FINGERPRINT, time_ns);
    put_text(&event, fault->kind);
    put_text(&event, fault->target);
    put_bool(&event, fault->active);
    return write_event(truth, "FAULT", time_ns, &event);
}
