// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_parameters.h"

#include "base/assertion.h"

#include <stddef.h>
#include <string.h>

typedef struct {
    const char* name;
    value_type_t type;
    uint16_t each;  // Number of values for each joint.
    uint16_t fixed; // Number of additional values.
    size_t offset;  // Offset in the structure of the parameter.
} field_row_t;

typedef struct {
    const char* name;
    size_t offset; // Offset in arm_parameters_t.
    size_t size;
    const field_row_t* rows;
    uint16_t count;
    uint16_t optional; // Number of fields at the end that a descriptor may omit.
} parameter_row_t;

#define FIELD(structure, name, type, each, fixed, member)                                                    \
    {                                                                                                        \
        (name), (type), (each), (fixed), offsetof(structure, member)                                         \
    }
#define PARAMETER(name, member, rows, optional)                                                              \
    {                                                                                                        \
        (name), offsetof(arm_parameters_t, member), sizeof(((const arm_parameters_t*)0)->member), (rows),    \
            (uint16_t)(sizeof(rows) / sizeof((rows)[0])), (optional)                                         \
    }

static const field_row_t cur_values[] = {
    FIELD(arm_cur_values_t, "STATE", VALUE_INT32, 0U, 1U, state),
    FIELD(arm_cur_values_t, "POSITION", VALUE_DOUBLE, 1U, 0U, position_rad),
    FIELD(arm_cur_values_t, "VELOCITY", VALUE_DOUBLE, 1U, 0U, velocity_rad_s),
    FIELD(arm_cur_values_t, "TORQUE", VALUE_DOUBLE, 1U, 0U, torque_nm),
    FIELD(arm_cur_values_t, "COMMAND", VALUE_DOUBLE, 1U, 0U, command),
    FIELD(arm_cur_values_t, "DESIRED", VALUE_DOUBLE, 1U, 0U, desired_rad),
    FIELD(arm_cur_values_t, "TOOL_POSITION", VALUE_DOUBLE, 0U, 3U, tool_position_m),
    FIELD(arm_cur_values_t, "TOOL_ROTATION", VALUE_DOUBLE, 0U, 3U, tool_rotation_rad),
    FIELD(arm_cur_values_t, "TOOL_ERROR", VALUE_DOUBLE, 0U, 2U, tool_error),
    FIELD(arm_cur_values_t, "TOOL_FORCE", VALUE_DOUBLE, 0U, 3U, tool_force_n),
    FIELD(arm_cur_values_t, "STATUSWORD", VALUE_UINT16, 1U, 0U, statusword),
};

static const field_row_t limits[] = {
    FIELD(arm_limit_values_t, "LOWER", VALUE_DOUBLE, 1U, 0U, lower),
    FIELD(arm_limit_values_t, "UPPER", VALUE_DOUBLE, 1U, 0U, upper),
    FIELD(arm_limit_values_t, "SPEED", VALUE_DOUBLE, 1U, 0U, speed),
    FIELD(arm_limit_values_t, "ACCELERATION", VALUE_DOUBLE, 1U, 0U, acceleration),
    FIELD(arm_limit_values_t, "TORQUE", VALUE_DOUBLE, 1U, 0U, torque),
    FIELD(arm_limit_values_t, "TOOL_SPEED", VALUE_DOUBLE, 0U, 1U, tool_speed),
    FIELD(arm_limit_values_t, "TOOL_ACCELERATION", VALUE_DOUBLE, 0U, 1U, tool_acceleration),
    FIELD(arm_limit_values_t, "TOOL_RATE", VALUE_DOUBLE, 0U, 1U, tool_rate),
    FIELD(arm_limit_values_t, "TOOL_ANGULAR_ACCELERATION", VALUE_DOUBLE, 0U, 1U, tool_angular_acceleration),
    FIELD(arm_limit_values_t, "TOLERANCE", VALUE_DOUBLE, 0U, 1U, tolerance),
};

static const field_row_t control[] = {
    FIELD(arm_control_values_t, "KP", VALUE_DOUBLE, 1U, 0U, kp),
    FIELD(arm_control_values_t, "KD", VALUE_DOUBLE, 1U, 0U, kd),
    FIELD(arm_control_values_t, "VELOCITY_BANDWIDTH", VALUE_DOUBLE, 0U, 1U, velocity_bandwidth),
    FIELD(arm_control_values_t, "FRICTION_SHARE", VALUE_DOUBLE, 0U, 1U, friction_share),
    FIELD(arm_control_values_t, "FADE_TIME", VALUE_DOUBLE, 0U, 1U, fade_time),
    FIELD(arm_control_values_t, "SINGULAR_LIMIT", VALUE_DOUBLE, 0U, 1U, singular_limit),
    FIELD(arm_control_values_t, "SINGULAR_DAMPING", VALUE_DOUBLE, 0U, 1U, singular_damping),
    FIELD(arm_control_values_t, "COMPLIANT", VALUE_BOOL, 0U, 1U, is_compliant),
    FIELD(arm_control_values_t, "TOOL_STIFFNESS", VALUE_DOUBLE, 0U, 6U, tool_stiffness),
    FIELD(arm_control_values_t, "TOOL_DAMPING", VALUE_DOUBLE, 0U, 6U, tool_damping),
    FIELD(arm_control_values_t, "JOINT_DAMPING", VALUE_DOUBLE, 0U, 1U, joint_damping),
    FIELD(arm_control_values_t, "TORQUE_GAIN", VALUE_DOUBLE, 0U, 1U, torque_gain),
};

static const field_row_t geometry[] = {
    FIELD(arm_geometry_values_t, "ORIGIN", VALUE_DOUBLE, 3U, 0U, origin),
    FIELD(arm_geometry_values_t, "RPY", VALUE_DOUBLE, 3U, 0U, rpy),
    FIELD(arm_geometry_values_t, "AXIS", VALUE_DOUBLE, 3U, 0U, axis),
    FIELD(arm_geometry_values_t, "TOOL", VALUE_DOUBLE, 0U, 3U, tool),
    FIELD(arm_geometry_values_t, "TOOL_RPY", VALUE_DOUBLE, 0U, 3U, tool_rpy),
    FIELD(arm_geometry_values_t, "PRISMATIC", VALUE_BOOL, 1U, 0U, is_prismatic),
};

static const field_row_t masses[] = {
    FIELD(arm_mass_values_t, "MASS", VALUE_DOUBLE, 1U, 0U, mass),
    FIELD(arm_mass_values_t, "CENTRE", VALUE_DOUBLE, 3U, 0U, centre),
    FIELD(arm_mass_values_t, "INERTIA", VALUE_DOUBLE, 6U, 0U, inertia),
    FIELD(arm_mass_values_t, "GRAVITY", VALUE_DOUBLE, 0U, 3U, gravity),
};

static const field_row_t drives[] = {
    FIELD(arm_drive_values_t, "ROTOR_INERTIA", VALUE_DOUBLE, 1U, 0U, rotor_inertia),
    FIELD(arm_drive_values_t, "STIFFNESS", VALUE_DOUBLE, 1U, 0U, stiffness),
    FIELD(arm_drive_values_t, "COULOMB", VALUE_DOUBLE, 1U, 0U, coulomb),
    FIELD(arm_drive_values_t, "VISCOUS", VALUE_DOUBLE, 1U, 0U, viscous),
};

static const field_row_t counters[] = {
    FIELD(arm_counter_values_t, "CYCLES", VALUE_UINT32, 0U, 1U, cycles),
    FIELD(arm_counter_values_t, "FRAMES_RECEIVED", VALUE_UINT32, 0U, 1U, frames_received),
    FIELD(arm_counter_values_t, "FRAMES_SENT", VALUE_UINT32, 0U, 1U, frames_sent),
    FIELD(arm_counter_values_t, "PDO_MISSED", VALUE_UINT32, 1U, 0U, pdo_missed),
    FIELD(arm_counter_values_t, "EMERGENCIES", VALUE_UINT32, 0U, 1U, emergencies),
    FIELD(arm_counter_values_t, "COMMAND_LIMITED", VALUE_UINT32, 0U, 1U, command_limited),
    FIELD(arm_counter_values_t, "TC_REFUSED", VALUE_UINT32, 0U, 1U, tc_refused),
    FIELD(arm_counter_values_t, "PARAMETER_REFUSED", VALUE_UINT32, 0U, 1U, parameter_refused),
};

static const field_row_t telepresence[] = {
    FIELD(arm_telepresence_values_t, "DIRECTIONS", VALUE_DOUBLE, 0U, 6U, directions),
    FIELD(arm_telepresence_values_t, "POSITION_SCALE", VALUE_DOUBLE, 0U, 1U, position_scale),
    FIELD(arm_telepresence_values_t, "DEAD_BAND", VALUE_DOUBLE, 0U, 1U, dead_band),
    FIELD(arm_telepresence_values_t, "RANGE", VALUE_DOUBLE, 0U, 1U, range),
    FIELD(arm_telepresence_values_t, "BANDWIDTH", VALUE_DOUBLE, 0U, 1U, bandwidth),
    FIELD(arm_telepresence_values_t, "FORCE_SCALE", VALUE_DOUBLE, 0U, 1U, force_scale),
    FIELD(arm_telepresence_values_t, "FORCE_BANDWIDTH", VALUE_DOUBLE, 0U, 1U, force_bandwidth),
    FIELD(arm_telepresence_values_t, "TARE_LIMIT", VALUE_DOUBLE, 0U, 1U, tare_limit),
};

static const field_row_t hand[] = {
    FIELD(arm_hand_values_t, "POSITION", VALUE_DOUBLE, 0U, 2U, position_rad),
    FIELD(arm_hand_values_t, "OFFSET", VALUE_DOUBLE, 0U, 2U, offset_m),
    FIELD(arm_hand_values_t, "STATE", VALUE_UINT8, 0U, 1U, state),
};

static const parameter_row_t rows[ARM_PARAMETERS] = {
    PARAMETER("CUR_VALUES", cur_values, cur_values, 0U),
    PARAMETER("LIMITS", limits, limits, 0U),
    PARAMETER("CONTROL", control, control, 0U),
    PARAMETER("GEOMETRY", geometry, geometry, 1U),
    PARAMETER("MASSES", masses, masses, 0U),
    PARAMETER("DRIVES", drives, drives, 0U),
    PARAMETER("COUNTERS", counters, counters, 0U),
    PARAMETER("TELEPRESENCE", telepresence, telepresence, 0U),
    PARAMETER("HAND", hand, hand, 0U),
};

unsigned arm_joint_count(const subsystem_descriptor_t* const descriptor)
{
    FSW_ASSERT(descriptor != NULL);
    return (descriptor->configuration_count > 0U) ? descriptor->configurations[0].device_count : 0U;
}

/// Returns the number of values of a field.
static unsigned count_of(const field_row_t* const row, const unsigned joint_count)
{
    return (row->each * joint_count) + row->fixed;
}

// ---- Check ----

static bool refuse(subsystem_misfit_t* const misfit, const uint32_t line, const char* const reason)
{
    *misfit = (subsystem_misfit_t){line, reason, 0U};
    return false;
}

static bool field_fits(const descriptor_field_t* const field, const field_row_t* const row,
                       const unsigned joint_count, subsystem_misfit_t* const out_misfit)
{
    if (strcmp(field->name, row->name) != 0) {
        return refuse(out_misfit, field->line,
                      "name of <ParamRef>: expected the next one of this structure of an arm (docs/arm.md)");
    }
    if (field->type != row->type) {
        return refuse(out_misfit, field->line, "type of <ParamRef>: expected that of an arm (docs/arm.md)");
    }
    if (field->count != count_of(row, joint_count)) {
        return refuse(out_misfit, field->line,
                      "count of <ParamRef>: expected as many values as <Device> elements need (docs/arm.md)");
    }
    return true;
}

static bool parameter_fits(const subsystem_descriptor_t* const descriptor, const parameter_row_t* const row,
                           subsystem_misfit_t* const out_misfit)
{
    const descriptor_parameter_t* const parameter = descriptor_find_parameter(descriptor, row->name);
    if ((parameter == NULL) || !parameter->is_struct || (parameter->field_count > row->count) ||
        (parameter->field_count < (row->count - row->optional))) {
        return refuse(out_misfit, (parameter != NULL) ? parameter->line : 1U,
                      "<Parameters>: expected the structures of an arm with all their members (docs/arm.md)");
    }
    const unsigned joint_count = arm_joint_count(descriptor);
    for (uint16_t i = 0U; i < parameter->field_count; i++) {
        if (!field_fits(&descriptor->fields[parameter->first_field + i], &row->rows[i], joint_count,
                        out_misfit)) {
            return false;
        }
    }
    return true;
}

/// Returns the number after the name of a field and an underscore: 2 for "TORQUE_2" and the field "TORQUE".
/// 0 if the name has another form.
static unsigned number_after(const char* const name, const char* const field)
{
    const size_t length = strlen(field);
    unsigned number     = 0U;
    if ((strncmp(name, field, length) != 0) || (name[length] != '_')) {
        return 0U;
    }
    for (const char* next = &name[length + 1U]; *next != '\0'; next++) {
        const bool is_digit = (*next >= '0') && (*next <= '9') && ((number > 0U) || (*next != '0'));
        if (!is_digit || (number >= ARM_JOINTS_MAX)) {
            return 0U;
        }
        number = (10U * number) + (unsigned)(*next - '0');
    }
    return number;
}

/// Find the field of CUR_VALUES of which a parameter is a single value, and the offset of that value; NULL
/// if there is none.
static const field_row_t* source_of(const descriptor_parameter_t* const parameter, const unsigned joint_count,
                                    size_t* const out_offset)
{
    for (size_t i = 0U; i < (sizeof cur_values / sizeof cur_values[0]); i++) {
        const field_row_t* const row = &cur_values[i];
        const unsigned number        = number_after(parameter->name, row->name);
        if ((number >= 1U) && (number <= count_of(row, joint_count))) {
            *out_offset = offsetof(arm_parameters_t, cur_values) + row->offset +
                          ((size_t)(number - 1U) * value_size(row->type));
            return row;
        }
    }
    return NULL;
}

/// Check a parameter that is not one of the structures.
static bool scalar_fits(const subsystem_descriptor_t* const descriptor,
                        const descriptor_parameter_t* const parameter, subsystem_misfit_t* const out_misfit)
{
    size_t offset                         = 0U;
    const descriptor_field_t* const field = &descriptor->fields[parameter->first_field];
    const field_row_t* const row          = source_of(parameter, arm_joint_count(descriptor), &offset);
    if (parameter->is_struct || (row == NULL)) {
        return refuse(
            out_misfit, parameter->line,
            "<Parameters>: expected the structures of an arm, and single values of CUR_VALUES only, "
            "e.g. TORQUE_1 (docs/arm.md)");
    }
    if ((field->type != row->type) || (field->count != 1U) || parameter->is_settable) {
        return refuse(out_misfit, parameter->line,
                      "<ParamRef>: expected the type of this value of CUR_VALUES, count 1, not settable "
                      "(docs/arm.md)");
    }
    return true;
}

static bool is_structure(const char* const name)
{
    for (unsigned i = 0U; i < ARM_PARAMETERS; i++) {
        if (strcmp(rows[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

/// Check all parameters that are not structures.
static bool scalars_fit(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &descriptor->parameters[i];
        if (!is_structure(parameter->name) && !scalar_fits(descriptor, parameter, out_misfit)) {
            return false;
        }
    }
    if (descriptor->parameter_count > (ARM_PARAMETERS + ARM_SCALARS)) {
        return refuse(out_misfit, descriptor->parameters[ARM_PARAMETERS + ARM_SCALARS].line,
                      "<ParamRef>: expected at most 48 single values of CUR_VALUES");
    }
    return true;
}

bool arm_parameters_fit(const subsystem_descriptor_t* const descriptor, subsystem_misfit_t* const out_misfit)
{
    FSW_ASSERT((descriptor != NULL) && (out_misfit != NULL));
    for (unsigned i = 0U; i < ARM_PARAMETERS; i++) {
        if (!parameter_fits(descriptor, &rows[i], out_misfit)) {
            return false;
        }
    }
    return scalars_fit(descriptor, out_misfit);
}

// ---- Definitions ----

/// Define a structure; its fields follow those already defined. Returns the new number of fields.
static uint16_t define_structure(arm_definitions_t* const definitions, const parameter_row_t* const row,
                                 const descriptor_parameter_t* const parameter, const unsigned joint_count,
                                 const uint16_t used)
{
    definitions->offsets[definitions->count] = row->offset;
    definitions->definitions[definitions->count] =
        (parameter_definition_t){.name        = row->name,
                                 .id          = parameter->id,
                                 .fields      = &definitions->fields[used],
                                 .field_count = parameter->field_count,
                                 .memory_size = (uint32_t)row->size,
                                 .wire_size   = parameter->wire_size};
    definitions->count++;
    for (uint16_t k = 0U; k < parameter->field_count; k++) {
        const field_row_t* const field = &row->rows[k];
        definitions->fields[used + k]  = (parameter_field_t){.name   = field->name,
                                                             .type   = field->type,
                                                             .count  = (uint16_t)count_of(field, joint_count),
                                                             .offset = (uint32_t)field->offset};
    }
    return used + parameter->field_count;
}

static void define_scalar(arm_definitions_t* const definitions, const descriptor_parameter_t* const parameter,
                          const unsigned joint_count, const uint16_t used)
{
    const field_row_t* const row =
        source_of(parameter, joint_count, &definitions->offsets[definitions->count]);
    FSW_ASSERT(row != NULL);
    definitions->fields[used] = (parameter_field_t){.name = parameter->name, .type = row->type, .count = 1U};
    definitions->definitions[definitions->count] =
        (parameter_definition_t){.name        = parameter->name,
                                 .id          = parameter->id,
                                 .fields      = &definitions->fields[used],
                                 .field_count = 1U,
                                 .memory_size = (uint32_t)value_size(row->type),
                                 .wire_size   = parameter->wire_size};
    definitions->count++;
}

void arm_definitions_create(arm_definitions_t* const definitions,
                            const subsystem_descriptor_t* const descriptor)
{
    FSW_ASSERT((definitions != NULL) && (descriptor != NULL));
    const unsigned joint_count = arm_joint_count(descriptor);
    uint16_t used              = 0U;
    definitions->count         = 0U;
    for (unsigned i = 0U; i < ARM_PARAMETERS; i++) {
        const descriptor_parameter_t* const parameter = descriptor_find_parameter(descriptor, rows[i].name);
        FSW_ASSERT((parameter != NULL) && ((used + rows[i].count) <= ARM_FIELDS));
        used = define_structure(definitions, &rows[i], parameter, joint_count, used);
    }
    for (uint16_t i = 0U; i < descriptor->parameter_count; i++) {
        const descriptor_parameter_t* const parameter = &descriptor->parameters[i];
        if (!is_structure(parameter->name)) {
            FSW_ASSERT(definitions->count < (ARM_PARAMETERS + ARM_SCALARS));
            define_scalar(definitions, parameter, joint_count, used);
            used++;
        }
    }
}

// ---- Model ----

/// True if every axis has a direction and no value of mass or drive is negative.
static bool is_sound(const arm_parameters_t* const parameters, const unsigned joint_count)
{
    bool is_good = true;
    for (size_t i = 0U; i < joint_count; i++) {
        const double length = arm_length(arm_vector(&parameters->geometry.axis[3U * i]));
        is_good             = is_good && (length > 0.0) && (parameters->masses.mass[i] >= 0.0) &&
                  (parameters->drives.rotor_inertia[i] >= 0.0) && (parameters->drives.stiffness[i] >= 0.0);
    }
    return is_good;
}

status_t arm_model_of_parameters(const arm_parameters_t* const parameters, const unsigned joint_count,
                                 arm_model_t* const out_model)
{
    FSW_ASSERT((parameters != NULL) && (out_model != NULL) && (joint_count <= ARM_JOINTS_MAX));
    if (!is_sound(parameters, joint_count)) {
        return STATUS_INVALID;
    }
    const arm_geometry_values_t* const shape = &parameters->geometry;
    const arm_mass_values_t* const mass      = &parameters->masses;
    *out_model                               = (arm_model_t){
                                      .joint_count = joint_count,
                                      .tool = {.rotation = arm_rotation_of_rpy(shape->tool_rpy), .position_m = arm_vector(shape->tool)},
                                      .gravity_m_s2 = arm_vector(mass->gravity)};
    for (size_t i = 0U; i < joint_count; i++) {
        const double* const inertia = &mass->inertia[6U * i];
        const arm_vector_t axis     = arm_vector(&shape->axis[3U * i]);
        const double length         = arm_length(axis);
        out_model->link[i] = (arm_link_t){.origin   = {.rotation   = arm_rotation_of_rpy(&shape->rpy[3U * i]),
                                                       .position_m = arm_vector(&shape->origin[3U * i])},
                                          .axis     = arm_times(axis, 1.0 / length),
                                          .mass_kg  = mass->mass[i],
                                          .centre_m = arm_vector(&mass->centre[3U * i]),
                                          .inertia_kgm2 = {{{inertia[0], inertia[1], inertia[2]},
                                                            {inertia[1], inertia[3], inertia[4]},
                                                            {inertia[2], inertia[4], inertia[5]}}},
                                          .is_prismatic = shape->is_prismatic[i]};
    }
    return STATUS_OK;
}

void arm_limits_of_parameters(const arm_parameters_t* const parameters, const unsigned joint_count,
                              arm_limits_t* const out_limits)
{
    FSW_ASSERT((parameters != NULL) && (out_limits != NULL));
    const arm_limit_values_t* const values = &parameters->limits;
    *out_limits                            = (arm_limits_t){.tool_speed_m_s                   = values->tool_speed,
                                                            .tool_acceleration_m_s2           = values->tool_acceleration,
                                                            .tool_rate_rad_s                  = values->tool_rate,
                                                            .tool_angular_acceleration_rad_s2 = values->tool_angular_acceleration,
                                                            .tolerance                        = values->tolerance,
                                                            .inverse = {.limit   = parameters->control.singular_limit,
                                                                        .damping = parameters->control.singular_damping}};
    for (unsigned i = 0U; i < joint_count; i++) {
        out_limits->lower_rad[i]           = values->lower[i];
        out_limits->upper_rad[i]           = values->upper[i];
        out_limits->speed_rad_s[i]         = values->speed[i];
        out_limits->acceleration_rad_s2[i] = values->acceleration[i];
    }
}

void arm_hand_settings_of_parameters(const arm_parameters_t* const parameters,
                                     arm_hand_settings_t* const out_settings)
{
    FSW_ASSERT((parameters != NULL) && (out_settings != NULL));
    const arm_telepresence_values_t* const values = &parameters->telepresence;
    *out_settings = (arm_hand_settings_t){.scale_m_rad     = values->position_scale,
                                          .dead_band_rad   = values->dead_band,
                                          .range_m         = values->range,
                                          .bandwidth_rad_s = values->bandwidth};
    arm_hand_directions(values->directions, out_settings->direction);
}
