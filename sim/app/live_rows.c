// SPDX-License-Identifier: Apache-2.0
#include "sim/app/live_rows.h"

#include <stdarg.h>
#include <stdio.h>

#define NS_PER_S 1.0e9

typedef struct {
    char* text;
    size_t size;
} row_t;

__attribute__((format(printf, 2, 3))) static void add(row_t* const row, const char* const format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int more = vsnprintf(&row->text[row->size], LIVE_ROW_OCTETS - row->size, format, arguments);
    va_end(arguments);
    // A text that does not fit completely is left out.
    const size_t room = LIVE_ROW_OCTETS - 1U - row->size;
    row->size += ((more > 0) && ((size_t)more <= room)) ? (size_t)more : 0U;
}

static void add_names(row_t* const row, const char* const of, const char* const* const parts,
                      const size_t count)
{
    for (size_t i = 0U; i < count; i++) {
        add(row, " %s.%s", of, parts[i]);
    }
}

static void add_values(row_t* const row, const double* const values, const size_t count)
{
    for (size_t i = 0U; i < count; i++) {
        add(row, " %.7g", values[i]);
    }
}

size_t live_rows_columns(const world_t* const world, char text[LIVE_ROW_OCTETS])
{
    static const char* const joint[]   = {"position", "torque", "brake"};
    static const char* const axis[]    = {"position", "torque", "hand"};
    static const char* const contact[] = {"contact", "contact-x", "contact-y", "contact-z"};
    static const char* const spring[]  = {"spring", "spring-x", "spring-y", "spring-z"};
    static const char* const base[]    = {"x", "y", "z", "qw", "qx", "qy", "qz"};
    static const char* const wheel[]   = {"momentum"};
    static const char* const valve[]   = {"open"};
    char name[(2U * DOCUMENT_TEXT_MAX) + 2U];
    row_t row = {.text = text};
    add(&row, "columns time");
    for (size_t r = 0U; r < world->robot_count; r++) {
        for (size_t i = 0U; i < world->robot[r].model.joint_count; i++) {
            (void)snprintf(name, sizeof name, "%s.%s", world->robot[r].name,
                           world->robot[r].model.joint[i].name);
            add_names(&row, name, joint, sizeof joint / sizeof joint[0]);
        }
    }
    for (size_t k = 0U; k < world->joystick_count; k++) {
        for (unsigned i = 0U; i < world->joystick[k].axes; i++) {
            (void)snprintf(name, sizeof name, "%s.%u", world->joystick[k].device.name, i + 1U);
            add_names(&row, name, axis, sizeof axis / sizeof axis[0]);
        }
    }
    for (size_t i = 0U; i < world->contact_count; i++) {
        add_names(&row, world->contact[i].a, contact, sizeof contact / sizeof contact[0]);
    }
    for (size_t i = 0U; i < world->spring_count; i++) {
        add_names(&row, world->spring[i].on, spring, sizeof spring / sizeof spring[0]);
    }
    for (size_t r = 0U; r < world->robot_count; r++) {
        if (world->robot[r].is_free) {
            add_names(&row, world->robot[r].name, base, sizeof base / sizeof base[0]);
        }
    }
    for (size_t i = 0U; i < world->wheel_count; i++) {
        add_names(&row, world->wheel[i].device.name, wheel, 1U);
    }
    for (size_t i = 0U; i < world->valve_count; i++) {
        add_names(&row, world->valve[i].name, valve, 1U);
    }
    add(&row, "\n");
    return row.size;
}

size_t live_rows_row(const world_t* const world, const plant_truth_t* const truth, char text[LIVE_ROW_OCTETS])
{
    row_t row = {.text = text};
    add(&row, "truth %.9g", (double)truth->time_ns / NS_PER_S);
    for (unsigned i = 0U; i < truth->joint_count; i++) {
        const double joint[] = {truth->link_position_rad[i], truth->joint_torque_nm[i],
                                truth->brake_engaged[i] ? 1.0 : 0.0};
        add_values(&row, joint, sizeof joint / sizeof joint[0]);
    }
    for (size_t k = 0U; k < world->joystick_count; k++) {
        for (unsigned i = 0U; i < world->joystick[k].axes; i++) {
            const double axis[] = {truth->stick[k].position_rad[i], truth->stick[k].torque_nm[i],
                                   truth->stick[k].hand_torque_nm[i]};
            add_values(&row, axis, sizeof axis / sizeof axis[0]);
        }
    }
    for (size_t i = 0U; i < world->contact_count; i++) {
        add(&row, " %d", truth->contact[i].is_touching ? 1 : 0);
        add_values(&row, truth->contact[i].force_n, 3U);
    }
    for (size_t i = 0U; i < world->spring_count; i++) {
        add(&row, " %d", truth->spring[i].is_hooked ? 1 : 0);
        add_values(&row, truth->spring[i].force_n, 3U);
    }
    for (unsigned i = 0U; i < truth->base_count; i++) {
        add_values(&row, truth->base[i].position_m, 3U);
        add_values(&row, truth->base[i].rotation, 4U);
    }
    for (size_t i = 0U; i < world->wheel_count; i++) {
        add_values(&row, &truth->wheel[i].momentum_nms, 1U);
    }
    for (size_t i = 0U; i < world->valve_count; i++) {
        add(&row, " %d", truth->valve_open[i] ? 1 : 0);
    }
    add(&row, "\n");
    return row.size;
}
